// Work that is shared out among threads.
#include "core/base/workers.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <stdexcept>
#include <string>

namespace pierce {
namespace {

TEST(WorkersTest, EachItemIsWorkedOnOnce) {
    for (const std::uint32_t threads : {1u, 2u, 5u})
        for (const std::uint32_t count : {0u, 1u, 7u, 1000u}) {
            std::vector<std::atomic<int>> times(count);
            Workers(threads).share_out("counting", count, 3,
                                       [&](std::uint32_t begin, std::uint32_t end) {
                                           for (std::uint32_t i = begin; i < end; ++i) ++times[i];
                                       });
            for (const auto& n : times) EXPECT_EQ(n, 1);
        }
}

TEST(WorkersTest, JobsAreDoneOnceEach) {
    std::atomic<int> sum = 0;
    Workers(3).side_by_side(
        "adding", [&] { sum += 1; }, [&] { sum += 10; }, [&] { sum += 100; }, [&] { sum += 1000; });
    EXPECT_EQ(sum, 1111);
}

TEST(WorkersTest, WhatWorkThrowsReachesTheCaller) {
    std::atomic<int> done = 0;
    const auto work = [&](std::uint32_t begin, std::uint32_t) {
        ++done;
        if (begin == 40) throw std::runtime_error("item 40");
    };
    EXPECT_THROW(Workers(4).share_out("failing", 100, 1, work), std::runtime_error);
    EXPECT_EQ(done, 100);
}

TEST(WorkersTest, ProgressIsToldOnceWorkTakesLong) {
    std::string last;
    double share = 0;
    int calls = 0;
    std::optional<Workers> workers(std::in_place, 2, [&](std::string_view what, double done) {
        last = what;
        EXPECT_GE(done, 0);
        EXPECT_LE(done, 1);
        share = done;
        ++calls;
    });
    workers->share_out("quick", 10, 1, [](std::uint32_t, std::uint32_t) {});
    EXPECT_EQ(calls, 0);
    workers->share_out("slow", 40, 1, [](std::uint32_t, std::uint32_t) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    });
    EXPECT_GT(calls, 0);
    EXPECT_LT(calls, 40);
    EXPECT_EQ(last, "slow");
    EXPECT_GT(share, 0.3);
    workers.reset();
    EXPECT_EQ(share, 1);
}

}  // namespace
}  // namespace pierce
