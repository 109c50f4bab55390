// Things in one array: wherever they move, no two of them share an item.
#include "core/base/places.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "support/random.hpp"

namespace pierce {
namespace {

void expect_apart(const Places& places, std::uint32_t things) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> spans;
    for (std::uint32_t t = 0; t < things; ++t)
        spans.emplace_back(places.first(t), places.first(t) + places.size(t));
    std::ranges::sort(spans);
    for (std::size_t k = 1; k < spans.size(); ++k)
        ASSERT_LE(spans[k - 1].second, spans[k].first) << "thing " << k;
    ASSERT_LE(spans.back().second, places.room());
}

TEST(PlacesTest, ThingsThatGrowMoveIntoTheRoom) {
    test::Random random(11);
    std::size_t moved = 0, refused = 0;
    for (int round = 0; round < 200; ++round) {
        std::vector<std::uint32_t> sizes(static_cast<std::size_t>(random.integer(1, 12)));
        for (std::uint32_t& size : sizes) size = static_cast<std::uint32_t>(random.integer(0, 40));
        Places places;
        places.lay_out(sizes, static_cast<std::uint32_t>(random.integer(0, 300)));
        const auto things = static_cast<std::uint32_t>(sizes.size());
        expect_apart(places, things);
        for (int change = 0; change < 40; ++change) {
            const auto t = static_cast<std::uint32_t>(
                random.integer(0, static_cast<int>(sizes.size()) - 1));
            const auto size = static_cast<std::uint32_t>(random.integer(0, 60));
            const std::uint32_t before = places.first(t);
            if (!places.resize(t, size)) {
                ++refused;
                ASSERT_EQ(places.size(t), sizes[t]);
                continue;
            }
            moved += places.first(t) != before;
            sizes[t] = size;
            for (std::uint32_t k = 0; k < things; ++k) ASSERT_EQ(places.size(k), sizes[k]);
            expect_apart(places, things);
        }
    }
    EXPECT_GT(moved, 500u);
    EXPECT_GT(refused, 500u);
}

}  // namespace
}  // namespace pierce
