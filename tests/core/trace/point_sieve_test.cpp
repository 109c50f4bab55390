// What float32 leaves out before the exact search for the closest triangle: never that one.
#include "core/trace/point_sieve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/device/bits.hpp"
#include "core/device/four.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/closest_search.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

/// A point, and triangles near it: slivers, tiny ones and some without area among them.
struct Case {
    Vec3d point;
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
    Box box;

    explicit Case(test::Random& random) {
        const double scale = std::exp2(random.integer(0, 1) == 0 ? random.integer(-12, 12)
                                                                 : random.integer(-64, 50));
        const Vec3d place = random.in_box(scale * std::exp2(random.integer(-4, 10)));
        for (std::uint32_t t = 0; t < 8; ++t) {
            const double size = scale * std::exp2(random.uniform(-12, 0)),
                         thin = random.integer(0, 2) == 0 ? std::exp2(random.uniform(-24, 0)) : 1;
            const Vec3d at = place + random.in_box(scale), side = size * random.unit_vector(),
                        other = random.uniform(0, 1) * side + thin * size * random.unit_vector();
            for (const Vec3d p : {at, at + side, at + other}) positions.push_back(to_float(p));
            triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}});
        }
        if (random.integer(0, 1) == 0) positions[23] = positions[20];  // two at the same place
        point = random.integer(0, 1) == 0
                    ? place + random.in_box(2 * scale)
                    : to_double(positions[0]) + random.in_box(scale * 0x1p-12);
        for (const Vec3f p : positions) box.extend(to_double(p));
    }
    Surface surface() const {
        return {.positions = view_of(positions), .triangles = view_of(triangles)};
    }
    Vec3f corner(std::uint32_t t, int k) const { return positions[triangles[t].vertex[k]]; }
};

TEST(PointSieveTest, TheClosestTriangleIsNeverLeftOut) {
    test::Random random(11);
    int found = 0, left_out = 0, left_out_side_by_side = 0;
    for (int i = 0; i < 50000; ++i) {
        const Case at(random);
        ClosestSearch all(at.point, at.surface(), at.box.extent());
        for (std::uint32_t t = 0; t < 8; ++t) all.test(t);
        const double limit = random.integer(0, 1) == 0 ? at.box.extent() : all.limit();
        PointSieve one(at.point, limit, at.box), four(at.point, limit, at.box);
        std::uint32_t may = 0, may_side_by_side = 0;
        for (std::uint32_t t = 0; t < 8; ++t)
            may |= std::uint32_t{one.may_be_closest(at.corner(t, 0), at.corner(t, 1),
                                                    at.corner(t, 2))}
                   << t;
        for (std::uint32_t t = 0; t < 8; t += 4) {
            FourVec3 corners[3];
            for (int k = 0; k < 3; ++k)
                corners[k] = FourVec3::of(at.corner(t, k), at.corner(t + 1, k), at.corner(t + 2, k),
                                          at.corner(t + 3, k));
            may_side_by_side |= four.may_be_closest(corners) << t;
        }
        if (random.integer(0, 3) == 0) {
            PointSieve limited(at.point, limit, at.box);
            limited.keep_limit();
            for (std::uint32_t t = 0; t < 8; ++t)
                if (distance_to(at.point, at.surface(), t) <= limit) {
                    ASSERT_TRUE(
                        limited.may_be_closest(at.corner(t, 0), at.corner(t, 1), at.corner(t, 2)))
                        << "seed " << random.seed() << ", case " << i << ", triangle " << t;
                }
        }
        left_out += 8 - static_cast<int>(bit_count(may));
        left_out_side_by_side += 8 - static_cast<int>(bit_count(may_side_by_side));
        if (all.triangle() == no_triangle) continue;
        ++found;
        ASSERT_NE(may >> all.triangle() & 1, 0u) << "seed " << random.seed() << ", case " << i;
        ASSERT_NE(may_side_by_side >> all.triangle() & 1, 0u)
            << "seed " << random.seed() << ", case " << i;
    }
    EXPECT_GT(found, 40000);
    EXPECT_GT(left_out, 150000);
    EXPECT_GT(left_out_side_by_side, 150000);
}

}  // namespace
}  // namespace pierce
