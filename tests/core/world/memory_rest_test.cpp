#include "core/world/memory_rest.hpp"

#include <gtest/gtest.h>

#include "pierce/constants.hpp"

namespace pierce {
namespace {

StepStats step(std::uint32_t rays, std::uint32_t certified) {
    StepStats stats;
    stats.rays = rays;
    stats.certified = certified;
    return stats;
}

/// Steps until memory rests.
std::uint32_t steps_to_rest(MemoryRest& rest, const StepStats& stats) {
    std::uint32_t steps = 0;
    while (!rest.now() && steps < 1000) {
        rest.note(stats, false);
        ++steps;
    }
    return steps;
}

/// Steps until memory is tried again.
std::uint32_t length(MemoryRest& rest) {
    std::uint32_t steps = 0;
    for (; rest.now(); ++steps) rest.note({}, false);
    return steps;
}

TEST(MemoryRestTest, RestsForLongerEachTime) {
    MemoryRest rest;
    const std::uint32_t trial = constants::memory_trial + constants::memory_patience;
    for (std::uint32_t k = 0; k < 4; ++k) {
        EXPECT_EQ(steps_to_rest(rest, step(90, 10)), trial);
        EXPECT_EQ(length(rest),
                  constants::memory_first_rest << std::min(k, constants::memory_doublings));
    }
}

TEST(MemoryRestTest, MemoryThatPaysStays) {
    MemoryRest rest;
    EXPECT_EQ(steps_to_rest(rest, step(10, 90)), 1000u);
    EXPECT_EQ(steps_to_rest(rest, step(0, 0)), 1000u) << "where nothing is near, nothing is lost";
    steps_to_rest(rest, step(90, 10));
    length(rest);
    for (int i = 0; i < 10; ++i) rest.note(step(10, 90), false);
    steps_to_rest(rest, step(90, 10));
    EXPECT_EQ(length(rest), constants::memory_first_rest) << "a first rest again";
}

TEST(MemoryRestTest, EndsWhereFewBodiesChange) {
    MemoryRest rest;
    steps_to_rest(rest, step(90, 10));
    EXPECT_TRUE(rest.now());
    rest.end();
    EXPECT_FALSE(rest.now());
    EXPECT_EQ(steps_to_rest(rest, step(90, 10)),
              constants::memory_trial + constants::memory_patience);
}

TEST(MemoryRestTest, BodiesThatDeformMustSpareMore) {
    MemoryRest rigid, deforming;
    for (int i = 0; i < 10; ++i) {
        rigid.note(step(20, 80), false);
        deforming.note(step(20, 80), true);
    }
    EXPECT_FALSE(rigid.now());
    EXPECT_TRUE(deforming.now());
}

}  // namespace
}  // namespace pierce
