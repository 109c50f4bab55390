// The order of a mesh's patches and groups.
#include "core/mesh_build/spatial_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>
#include <utility>

#include "pierce/box.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

TEST(SpatialOrderTest, AlignedRunsLieInBoxesOfTheirOwn) {
    test::Random random(4);
    for (std::size_t count : {0, 1, 2, 5, 16, 17, 300, 1000}) {
        std::vector<Vec3f> points(count);
        for (Vec3f& p : points) p = to_float(random.in_box(1));
        const std::uint32_t leaf = count % 2 == 0 ? 1 : 16;
        const std::vector<std::uint32_t> order = spatial_order(points, leaf);
        std::vector<std::uint32_t> sorted = order;
        std::ranges::sort(sorted);
        for (std::uint32_t i = 0; i < count; ++i) ASSERT_EQ(sorted[i], i);
        for (std::size_t run = leaf; run < count; run *= 2) {
            std::vector<Box> boxes((count + run - 1) / run);
            for (std::size_t i = 0; i < count; ++i)
                boxes[i / run].extend(to_double(points[order[i]]));
            for (std::size_t i = 0; i < boxes.size(); ++i)
                for (std::size_t j = 0; j < i; ++j)
                    ASSERT_FALSE(overlap(boxes[i], boxes[j]))
                        << "seed " << random.seed() << ", runs of " << run;
        }
    }
}

TEST(SpatialOrderTest, AnyStartLeadsToTheSameOrder) {
    test::Random random(5);
    std::mt19937 shuffler(6);
    for (int round = 0; round < 50; ++round) {
        std::vector<Vec3f> points(static_cast<std::size_t>(random.integer(1, 400)));
        for (Vec3f& p : points)
            p = {static_cast<float>(random.integer(0, 9)), static_cast<float>(random.integer(0, 3)),
                 static_cast<float>(random.uniform(0, 5))};
        const std::vector<std::uint32_t> order = spatial_order(points, 4);
        std::vector<std::uint32_t> start = order;
        for (int swaps = random.integer(0, 5); swaps > 0; --swaps)
            std::swap(start[static_cast<std::size_t>(
                          random.integer(0, static_cast<int>(start.size()) - 1))],
                      start.back());
        EXPECT_EQ(spatial_order(points, 4, 1, start), order) << "seed " << random.seed();
        std::ranges::shuffle(start, shuffler);
        EXPECT_EQ(spatial_order(points, 4, 1, start), order) << "seed " << random.seed();
    }
}

TEST(SpatialOrderTest, EqualPointsKeepTheirOrder) {
    const std::vector<Vec3f> points(100, Vec3f{1, 2, 3});
    const std::vector<std::uint32_t> order = spatial_order(points);
    for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(order[i], i);
}

}  // namespace
}  // namespace pierce
