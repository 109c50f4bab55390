// What two solids have in common, against clipped convex bodies, sampling and small moves.
#include "pierce/overlap.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/geometry/closest_point.hpp"
#include "core/mesh_build/winding_tree.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using Polygon = std::vector<Vec3d>;

struct Solid {
    MeshData mesh;
    Pose pose;

    Vec3d at(std::uint32_t v) const {
        return frame_of(pose).to_parent(to_double(mesh.positions[v]));
    }
    Polygon face(std::size_t t) const {
        Polygon corners;
        for (std::uint32_t v : mesh.triangles[t].vertex) corners.push_back(at(v));
        return corners;
    }
};

std::optional<Overlap> overlap_of(const Solid& a, const Solid& b, double same_direction = 0.9) {
    World world;
    const BodyId body_a = world.add_rigid_body(world.add_mesh("a", a.mesh), a.pose);
    const BodyId body_b = world.add_rigid_body(world.add_mesh("b", b.mesh), b.pose);
    return world.overlap(body_a, body_b, same_direction);
}

Vec3d vector_area(const Polygon& polygon) {
    Vec3d sum;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
        sum += 0.5 * cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
    return sum;
}

/// The part of a polygon below a plane (Sutherland and Hodgman 1974).
Polygon clipped(const Polygon& polygon, Vec3d normal, double height) {
    Polygon result;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3d p = polygon[i], q = polygon[(i + 1) % polygon.size()];
        const double at_p = dot(normal, p) - height, at_q = dot(normal, q) - height;
        if (at_p <= 0) result.push_back(p);
        if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0))
            result.push_back(p + at_p / (at_p - at_q) * (q - p));
    }
    return result;
}

/// The parts of a's faces inside a convex body.
std::vector<Polygon> parts_in_convex(const Solid& a, const Solid& convex) {
    std::vector<Polygon> parts;
    for (std::size_t t = 0; t < a.mesh.triangles.size(); ++t) {
        Polygon part = a.face(t);
        for (std::size_t other = 0; other < convex.mesh.triangles.size() && !part.empty();
             ++other) {
            const Polygon face = convex.face(other);
            const Vec3d normal = normalized(vector_area(face));
            part = clipped(part, normal, dot(normal, face[0]));
        }
        if (part.size() > 2) parts.push_back(std::move(part));
    }
    return parts;
}

double volume_under(const std::vector<Polygon>& parts) {
    double sum = 0;
    for (const Polygon& part : parts) sum += dot(part[0], vector_area(part)) / 3;
    return sum;
}

double area_of(const std::vector<Polygon>& parts) {
    double sum = 0;
    for (const Polygon& part : parts) sum += length(vector_area(part));
    return sum;
}

TEST(OverlapTest, ConvexBodiesAsClippedByPlanes) {
    test::Random random(5);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const MeshData shapes[] = {scenes::box({-1, -0.6, -0.5}, {1, 0.6, 0.5}), scenes::sphere(0.9, 1),
                               scenes::capsule(0.5, 0.6, 9, 4)};
    int overlapping = 0;
    for (int i = 0; i < 300; ++i) {
        const Solid a{shapes[random.integer(0, 2)], {random.in_box(0.8), random.rotation()}};
        const Solid b{shapes[random.integer(0, 2)], {random.in_box(0.8), random.rotation()}};
        const std::vector<Polygon> in_b = parts_in_convex(a, b), in_a = parts_in_convex(b, a);
        const double volume = volume_under(in_b) + volume_under(in_a);
        const std::optional<Overlap> found = overlap_of(a, b);
        ASSERT_EQ(found.has_value(), volume > 1e-7) << volume;
        if (!found) continue;
        ++overlapping;
        EXPECT_NEAR(found->volume, volume, 1e-6) << "float32 corners are not quite in one plane";
        EXPECT_NEAR(found->area_a, area_of(in_b), 1e-5);
        EXPECT_NEAR(found->area_b, area_of(in_a), 1e-5);
        Vec3d push;
        for (const Polygon& part : in_b) push += vector_area(part);
        EXPECT_NEAR(length(found->push - push), 0, 1e-5);
        double area = 0;
        for (const ContactPatch& patch : found->patches) area += patch.area;
        EXPECT_NEAR(area, 0.5 * (found->area_a + found->area_b), 1e-7);
    }
    EXPECT_GT(overlapping, 150);
}

/// Faces, edges and corners that coincide are no special case.
TEST(OverlapTest, AlignedBoxesInEveryArrangement) {
    const Solid unit{scenes::box({0, 0, 0}, {1, 1, 1}), {}};
    const double places[] = {-1, -0.5, 0, 0.25, 1};
    for (const double x : places)
        for (const double y : places)
            for (const double z : places)
                for (const double size : {0.5, 1.0}) {
                    const Solid other{scenes::box({x, y, z}, {x + size, y + size, z + size}), {}};
                    const auto common = [&](double low) {
                        return std::max(0.0, std::min(1.0, low + size) - std::max(0.0, low));
                    };
                    const double expected = common(x) * common(y) * common(z);
                    for (const bool swapped : {false, true}) {
                        const auto found = swapped ? overlap_of(other, unit)
                                                   : overlap_of(unit, other);
                        ASSERT_NEAR(found ? found->volume : 0, expected, 1e-9)
                            << x << " " << y << " " << z << " " << size << " " << swapped;
                    }
                }
}

TEST(OverlapTest, ChangesWithSmallMovesAsItSays) {
    test::Random random(6);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int overlapping = 0;
    for (int i = 0; i < 60; ++i) {
        const Solid a{test::random_closed_mesh(random), {random.in_box(0.4), random.rotation()}};
        const Solid b{test::random_closed_mesh(random), {random.in_box(0.4), random.rotation()}};
        const auto found = overlap_of(a, b), turned = overlap_of(b, a);
        ASSERT_EQ(found.has_value(), turned.has_value());
        if (!found) continue;
        ++overlapping;
        EXPECT_NEAR(found->volume, turned->volume, 1e-9);
        EXPECT_NEAR(length(found->center - turned->center), 0, 1e-6 / found->volume);
        EXPECT_NEAR(length(found->push + turned->push), 0, 1e-7);
        EXPECT_NEAR(length(found->turn + turned->turn), 0, 1e-6);
        constexpr double step = 1e-5;
        for (int k = 0; k < 3; ++k) {
            Solid one = b, other = b;
            one.pose.position[k] += step;
            other.pose.position[k] -= step;
            const auto more = overlap_of(a, one), less = overlap_of(a, other);
            const double slope = ((more ? more->volume : 0) - (less ? less->volume : 0)) /
                                 (2 * step);
            EXPECT_NEAR(slope, -found->push[k], 1e-4 + 1e-3 * std::fabs(found->push[k]));
            // The same for turns of b about the overlap's middle.
            const double half = step / 2;
            const auto rotated = [&](double sign) {
                Quaternion q{0, 0, 0, std::cos(half)};
                (k == 0 ? q.x : k == 1 ? q.y : q.z) = sign * std::sin(half);
                Solid result = b;
                result.mesh.positions.clear();
                for (std::uint32_t v = 0; v < b.mesh.positions.size(); ++v)
                    result.mesh.positions.push_back(to_float(b.at(v) - found->center));
                result.pose = {found->center, q};
                return overlap_of(a, result);
            };
            const auto ahead = rotated(1), back = rotated(-1);
            const double turn_slope = ((ahead ? ahead->volume : 0) - (back ? back->volume : 0)) /
                                      (2 * step);
            EXPECT_NEAR(turn_slope, -found->turn[k], 1e-3 + 1e-2 * std::fabs(found->turn[k]));
        }
    }
    EXPECT_GT(overlapping, 25);
}

/// Samples of a surface inside another one.
struct Sampled {
    double area = 0, depth_volume = 0;
};

Sampled sample(const Solid& a, const Solid& b, test::Random& random) {
    const auto in_b = [&](Vec3d p) { return to_float(frame_of(b.pose).to_local(p)); };
    const WindingTree winding(b.mesh.positions, b.mesh.triangles);
    Sampled sum;
    constexpr int samples = 25;
    for (std::size_t t = 0; t < a.mesh.triangles.size(); ++t) {
        const Polygon face = a.face(t);
        const double area = length(vector_area(face)) / samples;
        for (int i = 0; i < samples; ++i) {
            double u = random.uniform(0, 1), v = random.uniform(0, 1);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            const Vec3d p = face[0] + u * (face[1] - face[0]) + v * (face[2] - face[0]);
            if (winding.exactly_at(to_double(in_b(p))) < 0.5) continue;
            double depth = INFINITY;
            for (std::size_t other = 0; other < b.mesh.triangles.size(); ++other) {
                const Polygon c = b.face(other);
                depth = std::min(depth, length(closest_on_triangle(p, c[0], c[1], c[2]) - p));
            }
            sum.area += area;
            sum.depth_volume += area * depth;
        }
    }
    return sum;
}

TEST(OverlapTest, PatchesAsSampled) {
    test::Random random(7);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int overlapping = 0;
    const MeshData ring = scenes::torus(1, 0.4, 20, 10);
    for (int i = 0; i < 10; ++i) {
        const Solid a{ring, {random.in_box(0.5), random.rotation()}};
        const Solid b{ring, {random.in_box(0.5), random.rotation()}};
        const auto found = overlap_of(a, b);
        if (!found || found->volume < 0.05) continue;
        ++overlapping;
        const Sampled in_b = sample(a, b, random), in_a = sample(b, a, random);
        EXPECT_NEAR(found->area_a, in_b.area, 0.05 * found->area_a + 0.02);
        EXPECT_NEAR(found->area_b, in_a.area, 0.05 * found->area_b + 0.02);
        double depth_volume = 0;
        for (const ContactPatch& patch : found->patches) {
            depth_volume += patch.depth_volume;
            EXPECT_LE(patch.depth_volume, patch.depth * patch.area * (1 + 1e-9));
            EXPECT_NEAR(length(patch.normal), 1, 1e-9);
        }
        const double sampled = 0.5 * (in_b.depth_volume + in_a.depth_volume);
        EXPECT_NEAR(depth_volume, sampled, 0.06 * sampled + 0.002);
    }
    EXPECT_GT(overlapping, 4);
}

TEST(OverlapTest, ABallInAPlateIsACapWithOnePatch) {
    const double radius = 1, depth = 0.1;
    const Solid ball{scenes::sphere(radius, 5), {{0, 0, radius - depth}, {0, 0, 0, 1}}};
    const Solid plate{scenes::box({-3, -3, -1}, {3, 3, 0}), {}};
    const auto found = overlap_of(ball, plate, 0.8);
    ASSERT_TRUE(found);
    const double pi = std::numbers::pi;
    const double cap = pi * depth * depth * (3 * radius - depth) / 3;
    EXPECT_NEAR(found->volume, cap, 0.01 * cap);
    EXPECT_NEAR(found->area_a, 2 * pi * radius * depth, 0.01);
    EXPECT_NEAR(found->area_b, pi * (2 * radius * depth - depth * depth), 0.01);
    EXPECT_NEAR(found->push.z, -found->area_b, 1e-9);
    ASSERT_EQ(found->patches.size(), 1u);
    const ContactPatch& patch = found->patches[0];
    EXPECT_NEAR(patch.depth, depth, 1e-3);
    EXPECT_NEAR(patch.normal.z, -1, 1e-3) << "from the ball to the plate";
    EXPECT_NEAR(patch.depth_volume, cap, 0.05 * cap);
    EXPECT_NEAR(length(patch.center - Vec3d{0, 0, -0.025}), 0, 0.01);
}

/// Of a tube that stands in a floor, the middle of the floor's ring is in the hole.
TEST(OverlapTest, TheDeepestPlaceOfARingIsInside) {
    constexpr std::uint32_t around = 24;
    constexpr double inner = 0.8, outer = 1, sunk = 0.01;
    MeshData tube;
    for (const double radius : {inner, outer})
        for (const double z : {-sunk, 1.0})
            for (std::uint32_t k = 0; k < around; ++k) {
                const double angle = 2 * std::numbers::pi * k / around;
                tube.positions.push_back(
                    to_float({radius * std::cos(angle), radius * std::sin(angle), z}));
            }
    const std::array<std::uint32_t, 4> ring = {0, around, 3 * around, 2 * around};
    for (std::size_t side = 0; side < 4; ++side)
        for (std::uint32_t k = 0; k < around; ++k) {
            const std::uint32_t next = (k + 1) % around, a = ring[side], b = ring[(side + 1) % 4];
            tube.triangles.push_back({{a + k, b + k, b + next}});
            tube.triangles.push_back({{a + k, b + next, a + next}});
        }
    const Solid floor{scenes::box({-3, -3, -1}, {3, 3, 0}), {}};
    const auto found = overlap_of(Solid{tube, {}}, floor);
    ASSERT_TRUE(found);
    ASSERT_FALSE(found->patches.empty());
    const ContactPatch& patch = found->patches[0];
    EXPECT_NEAR(patch.depth, sunk, 1e-6);
    EXPECT_NEAR(patch.normal.z, -1, 1e-6) << "from the tube to the floor";
    const double from_axis = std::hypot(patch.deepest.x, patch.deepest.y);
    EXPECT_TRUE(from_axis > inner - 0.02 && from_axis < outer) << from_axis;
    EXPECT_LT(patch.depth_volume, found->volume);
}

TEST(OverlapTest, OneBodyInsideAnotherHasNoPatchOfTheOther) {
    const Solid inner{scenes::sphere(0.5, 2), {}}, outer{scenes::sphere(2, 2), {}};
    const auto found = overlap_of(inner, outer);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->volume, 4.0 / 3 * std::numbers::pi * 0.125, 0.05);
    EXPECT_EQ(found->area_b, 0);
    EXPECT_NEAR(length(found->push), 0, 1e-9) << "no small move changes the volume";
    EXPECT_NEAR(length(found->center), 0, 1e-9);
}

TEST(OverlapTest, SmallCornersKeepTheirDigits) {
    test::Random random(31);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    const Solid box{scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}), {}};
    for (const double side : {1e-1, 1e-3, 1e-5, 1e-7})
        for (int i = 0; i < 20; ++i) {
            Solid a = box, b = box;
            a.pose.rotation = b.pose.rotation = random.rotation();
            const Frame frame = frame_of(a.pose);
            b.pose.position = (1 - side) * frame.to_parent({1, 1, 1});
            const auto found = overlap_of(a, b);
            ASSERT_TRUE(found) << side;
            // Positions are rounded to 1e-11.
            const double share = 1e-9 + 1e-10 / side;
            EXPECT_NEAR(found->volume / (side * side * side), 1, 10 * share) << side;
            EXPECT_NEAR(found->area_a / (3 * side * side), 1, 10 * share) << side;
            EXPECT_NEAR(length(found->center - 0.5 * b.pose.position), 0, 10 * share * side);
            for (const ContactPatch& patch : found->patches) {
                EXPECT_LE(patch.depth, 2 * side);
                EXPECT_LE(length(patch.center - 0.5 * b.pose.position), 2 * side);
            }
        }
}

TEST(OverlapTest, WhatOnlyTouchesHasNothingInCommon) {
    test::Random random(32);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    const Solid box{scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}), {}};
    for (int i = 0; i < 200; ++i) {
        Solid a = box, b = box;
        a.pose.rotation = b.pose.rotation = random.rotation();
        b.pose.position = frame_of(a.pose).to_parent(
            {1, random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9)});
        EXPECT_FALSE(overlap_of(a, b)) << i;
    }
}

TEST(OverlapTest, AFarUnusedVertexMakesNothingCoarser) {
    const auto overlap = [](float far) {
        World world;
        MeshData ball = scenes::sphere(1, 2);
        if (far > 0) ball.positions.push_back({far, 0, far});
        const BodyId a = world.add_rigid_body(world.add_mesh("ball", ball)),
                     b = world.add_rigid_body(
                         world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1})));
        return *world.overlap(a, b);
    };
    const Overlap plain = overlap(0);
    for (const float far : {1e3f, 1e6f}) {
        const Overlap with = overlap(far);
        EXPECT_EQ(with.volume, plain.volume) << far;
        ASSERT_EQ(with.patches.size(), plain.patches.size()) << far;
        for (std::size_t i = 0; i < plain.patches.size(); ++i)
            EXPECT_EQ(with.patches[i].area, plain.patches[i].area) << far;
    }
}

TEST(OverlapTest, RefusesWhatHasNoVolume) {
    World world;
    const MeshId ball = world.add_mesh("ball", scenes::sphere(1, 1)),
                 flat = world.add_mesh("flat", scenes::grid(2, 2, 4, 4));
    const BodyId a = world.add_rigid_body(ball), b = world.add_rigid_body(flat),
                 c = world.add_rigid_body(ball, {{9, 0, 0}, {0, 0, 0, 1}});
    EXPECT_THROW(world.overlap(a, a), InputError);
    EXPECT_THROW(world.overlap(a, b), InputError);
    EXPECT_THROW(world.overlap(a, c, 2), InputError);
    EXPECT_FALSE(world.overlap(a, c));
}

}  // namespace
}  // namespace pierce
