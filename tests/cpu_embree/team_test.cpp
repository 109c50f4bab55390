#include "cpu_embree/team.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <vector>

#include "support/random.hpp"

namespace pierce {
namespace {

TEST(TeamTest, GivesEveryItemToOneThreadInStagesThatFollowEachOther) {
    test::Random random(7);
    SCOPED_TRACE(random.seed());
    for (int threads : {1, 2, 3, 7}) {
        tbb::task_arena arena(threads);
        Team team(arena, threads);
        std::vector<std::uint32_t> last;
        for (int stage = 0; stage < 3000; ++stage) {
            // Each stage reads what the one before wrote, wherever that was done.
            const auto count = static_cast<std::uint32_t>(
                random.integer(0, stage % 10 == 0 ? 5000 : 60));
            std::vector<std::uint32_t> items(count, 0);
            team.share(count, static_cast<std::uint32_t>(random.integer(1, 40)),
                       [&](std::uint32_t begin, std::uint32_t end) {
                           ASSERT_LT(begin, end);
                           for (std::uint32_t i = begin; i < end; ++i)
                               items[i] += 1 + (last.empty() ? 0 : last[i % last.size()]);
                       });
            for (std::uint32_t i = 0; i < count; ++i)
                ASSERT_EQ(items[i], 1 + (last.empty() ? 0 : last[i % last.size()]));
            last.assign(items.size(), 0);
            for (std::uint32_t i = 0; i < count; ++i)
                last[i] = i + static_cast<std::uint32_t>(stage);
        }
    }
}

TEST(TeamTest, HelpersComeBackAfterAPause) {
    tbb::task_arena arena(2);
    Team team(arena, 2);
    for (int round = 0; round < 20; ++round) {
        std::atomic<std::uint32_t> sum = 0;
        team.share(100, 1, [&](std::uint32_t begin, std::uint32_t end) { sum += end - begin; });
        EXPECT_EQ(sum, 100u);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));  // longer than they wait
    }
}

TEST(TeamTest, PassesAFailureOnWhenAllIsOver) {
    tbb::task_arena arena(3);
    Team team(arena, 3);
    for (std::uint32_t bad = 0; bad < 200; ++bad) {
        std::atomic<std::uint32_t> others = 0;
        const auto work = [&](std::uint32_t begin, std::uint32_t end) {
            if (begin <= bad && bad < end) throw std::runtime_error("item");
            others += end - begin;
        };
        EXPECT_THROW(team.share(200, 1, work), std::runtime_error);
        EXPECT_LT(others, 200u);
        others = 0;
        EXPECT_NO_THROW(team.share(bad, 1, work));
        EXPECT_EQ(others, bad);
    }
}

TEST(TeamTest, MayGoWhileItsHelpersWait) {
    for (int round = 0; round < 200; ++round) {
        tbb::task_arena arena(2);
        Team team(arena, 2);
        std::atomic<std::uint32_t> sum = 0;
        team.share(50, 1, [&](std::uint32_t begin, std::uint32_t end) { sum += end - begin; });
        ASSERT_EQ(sum, 50u);
    }
}

}  // namespace
}  // namespace pierce
