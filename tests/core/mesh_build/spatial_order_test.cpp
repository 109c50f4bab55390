// The order of a mesh's patches and groups.
#include "core/mesh_build/spatial_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "pierce/box.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

TEST(SpatialOrderTest, AlignedRunsLieInBoxesOfTheirOwn) {
    test::Random random(4);
    for (std::size_t count : {0, 1, 2, 5, 16, 17, 300, 1000}) {
        std::vector<Vec3d> points(count);
        for (Vec3d& p : points) p = random.in_box(1);
        const std::vector<std::uint32_t> order = spatial_order(points);
        std::vector<std::uint32_t> sorted = order;
        std::ranges::sort(sorted);
        for (std::uint32_t i = 0; i < count; ++i) ASSERT_EQ(sorted[i], i);
        for (std::size_t run = 1; run < count; run *= 2) {
            std::vector<Box> boxes((count + run - 1) / run);
            for (std::size_t i = 0; i < count; ++i) boxes[i / run].extend(points[order[i]]);
            for (std::size_t i = 0; i < boxes.size(); ++i)
                for (std::size_t j = 0; j < i; ++j)
                    ASSERT_FALSE(overlap(boxes[i], boxes[j]))
                        << "seed " << random.seed() << ", runs of " << run;
        }
    }
}

TEST(SpatialOrderTest, EqualPointsKeepTheirOrder) {
    const std::vector<Vec3d> points(100, Vec3d{1, 2, 3});
    const std::vector<std::uint32_t> order = spatial_order(points);
    for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(order[i], i);
}

}  // namespace
}  // namespace pierce
