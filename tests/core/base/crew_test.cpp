#include "core/base/crew.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace pierce {
namespace {

TEST(CrewTest, EveryMemberWorksOnceACall) {
    Crew crew(4);
    std::vector<int> calls(4, 0);
    for (int call = 1; call <= 200; ++call) {
        crew.run([&](std::size_t member) { ++calls[member]; });
        EXPECT_EQ(calls, std::vector<int>(4, call));
    }
}

TEST(CrewTest, OneMemberIsTheCaller) {
    Crew crew(1);
    const auto caller = std::this_thread::get_id();
    crew.run([&](std::size_t member) {
        EXPECT_EQ(member, 0u);
        EXPECT_EQ(std::this_thread::get_id(), caller);
    });
}

TEST(CrewTest, AFailureIsThrownWhenAllAreDone) {
    Crew crew(3);
    std::atomic<int> done = 0;
    const auto work = [&](std::size_t member) {
        ++done;
        if (member > 0) throw std::runtime_error(member == 1 ? "one" : "two");
    };
    try {
        crew.run(work);
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "one") << "the first member's";
    }
    EXPECT_EQ(done, 3);
    crew.run([&](std::size_t) { ++done; });
    EXPECT_EQ(done, 6) << "and it goes on";
}

}  // namespace
}  // namespace pierce
