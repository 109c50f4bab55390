#include "core/geometry/half_spaces.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "support/random.hpp"

namespace pierce {
namespace {

/// The closest point of the planes of one, two or three half-spaces; nothing if they are parallel.
std::optional<Vec3d> common_point(const std::vector<HalfSpace>& on) {
    const Vec3d a = on[0].normal;
    if (on.size() == 1) return on[0].least * a;
    Vec3d b = on[1].normal, c = on.size() == 3 ? on[2].normal : cross(a, b);
    const double volume = dot(a, cross(b, c)), third = on.size() == 3 ? on[2].least : 0;
    if (std::fabs(volume) < 1e-9) return std::nullopt;
    return (1 / volume) *
           (on[0].least * cross(b, c) + on[1].least * cross(c, a) + third * cross(a, b));
}

/// By definition: of all points on one, two or three planes that are in all half-spaces, the
/// closest one.
std::optional<Vec3d> closest_of_all(const std::vector<HalfSpace>& all) {
    std::optional<Vec3d> best;
    const auto try_one = [&](const std::vector<HalfSpace>& on) {
        const std::optional<Vec3d> p = common_point(on);
        if (!p || (best && length(*p) >= length(*best))) return;
        for (const HalfSpace& h : all)
            if (dot(h.normal, *p) < h.least - 1e-7) return;
        best = p;
    };
    for (std::size_t i = 0; i < all.size(); ++i) {
        try_one({all[i]});
        for (std::size_t j = 0; j < i; ++j) {
            try_one({all[i], all[j]});
            for (std::size_t k = 0; k < j; ++k) try_one({all[i], all[j], all[k]});
        }
    }
    return best;
}

TEST(HalfSpacesTest, TheClosestPointIsTheBestOfAllCorners) {
    test::Random random(61);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int without = 0, corners = 0;
    for (int i = 0; i < 2000; ++i) {
        std::vector<HalfSpace> all;
        const double spread = random.uniform(0.1, 2);
        const Vec3d up = random.unit_vector();
        for (int k = random.integer(1, 10); k > 0; --k)
            all.push_back({normalized(up + spread * random.unit_vector()), random.uniform(0, 1)});
        const std::optional<Vec3d> expected = closest_of_all(all), found = closest_to_origin(all);
        ASSERT_EQ(found.has_value(), expected.has_value()) << i;
        without += !found;
        if (!found) continue;
        ASSERT_NEAR(length(*found), length(*expected), 1e-6 * (1 + length(*expected))) << i;
        int on = 0;
        for (const HalfSpace& h : all) {
            const double beyond = dot(h.normal, *found) - h.least;
            ASSERT_GE(beyond, -1e-7);
            on += beyond < 1e-7;
        }
        corners += on == 3;
    }
    EXPECT_GT(without, 100);
    EXPECT_GT(corners, 100);
}

TEST(HalfSpacesTest, FlatPatchesHaveAWay) {
    test::Random random(62);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    for (int i = 0; i < 20000; ++i) {
        const Vec3d up = random.unit_vector();
        std::vector<HalfSpace> all;
        for (int k = random.integer(4, 40); k > 0; --k)
            all.push_back({normalized(up + 1e-4 * random.in_box(1)), 0.25});
        const std::optional<Vec3d> found = closest_to_origin(all);
        ASSERT_TRUE(found) << i;
        for (const HalfSpace& h : all) ASSERT_GE(dot(h.normal, *found), h.least - 1e-6) << i;
        ASSERT_NEAR(length(*found), 0.25, 1e-6) << i;
    }
}

TEST(HalfSpacesTest, HardInputs) {
    EXPECT_EQ(closest_to_origin({}), Vec3d{});
    const std::vector<HalfSpace> same(100, {{0, 0, 1}, 2});
    EXPECT_EQ(closest_to_origin(same), (Vec3d{0, 0, 2}));
    const std::vector<HalfSpace> around{{{0, 0, 1}, -1}, {{0, 0, -1}, -1}};
    EXPECT_EQ(closest_to_origin(around), Vec3d{}) << "the origin is in all of them";
    const std::vector<HalfSpace> slab{{{0, 0, 1}, 1}, {{0, 0, -1}, 1}};
    EXPECT_FALSE(closest_to_origin(slab));
    // Normals that are nearly, but not quite, one.
    std::vector<HalfSpace> fan;
    for (int k = 0; k < 50; ++k)
        fan.push_back({normalized(Vec3d{1e-5 * k, 0, 1}), 1 + 1e-9 * (k % 7)});
    const std::optional<Vec3d> p = closest_to_origin(fan);
    ASSERT_TRUE(p);
    for (const HalfSpace& h : fan) EXPECT_GE(dot(h.normal, *p), h.least - 2e-8);
    EXPECT_NEAR(length(*p), 1, 1e-6);
}

}  // namespace
}  // namespace pierce
