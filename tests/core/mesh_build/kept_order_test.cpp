// An order that keeps to another one where things are the same.
#include "core/mesh_build/kept_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "support/random.hpp"

namespace pierce {
namespace {

TEST(KeptOrderTest, EachThingHasAPlaceAndMostKeepTheirs) {
    test::Random random(7);
    std::mt19937 shuffler(8);
    for (int round = 0; round < 300; ++round) {
        const auto before_count = static_cast<std::uint32_t>(random.integer(0, 40)),
                   count = static_cast<std::uint32_t>(random.integer(0, 40));
        std::vector<std::uint32_t> before(before_count), now_of(before_count, is_gone),
            names(count);
        std::iota(before.begin(), before.end(), 0u);
        std::iota(names.begin(), names.end(), 0u);
        std::ranges::shuffle(before, shuffler);
        std::ranges::shuffle(names, shuffler);
        const auto same = static_cast<std::uint32_t>(
            random.integer(0, static_cast<int>(std::min(before_count, count))));
        for (std::uint32_t i = 0; i < same; ++i) now_of[before[i]] = names[i];
        std::ranges::shuffle(before, shuffler);

        const std::vector<std::uint32_t> order = kept_order(before, now_of, count);
        std::vector<std::uint32_t> sorted = order;
        std::ranges::sort(sorted);
        ASSERT_EQ(sorted.size(), count) << "seed " << random.seed();
        for (std::uint32_t i = 0; i < count; ++i) ASSERT_EQ(sorted[i], i);
        // Only those at the end move, each into a place that is free.
        std::uint32_t moved = 0;
        for (std::uint32_t place = 0; place < before_count; ++place)
            moved += now_of[before[place]] != is_gone &&
                     (place >= count || order[place] != now_of[before[place]]);
        EXPECT_LE(moved, before_count > count ? before_count - count : 0u);
    }
}

TEST(KeptOrderTest, WhatIsNewTakesThePlaceOfItsNumber) {
    const std::vector<std::uint32_t> before{2, 0, 3, 1};
    EXPECT_EQ(kept_order(before, std::vector<std::uint32_t>{0, is_gone, is_gone, 3}, 5),
              (std::vector<std::uint32_t>{2, 0, 3, 1, 4}));
}

}  // namespace
}  // namespace pierce
