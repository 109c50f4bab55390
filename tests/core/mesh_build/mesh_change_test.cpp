// What is taken over from a mesh that another one comes from.
#include "core/mesh_build/mesh_change.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <type_traits>
#include <typeinfo>
#include <utility>

#include "core/geometry/closest_point.hpp"
#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/mesh_view.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

/// A torus with a bump, from which some triangles are cut out in the middle of their edges.
MeshData cut(MeshData mesh, test::Random& random, int cuts) {
    for (; cuts > 0; --cuts) {
        const auto t = static_cast<std::size_t>(
            random.integer(0, static_cast<int>(mesh.triangles.size()) - 1));
        Vec3d middle;
        for (std::uint32_t v : mesh.triangles[t].vertex)
            middle += (1.0 / 3) * to_double(mesh.positions[v]);
        const auto v = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(to_float(0.98 * middle));
        const Triangle whole = mesh.triangles[t];
        mesh.triangles[t] = {{whole.vertex[0], whole.vertex[1], v}};
        mesh.triangles.push_back({{whole.vertex[1], whole.vertex[2], v}});
        mesh.triangles.push_back({{whole.vertex[2], whole.vertex[0], v}});
    }
    return mesh;
}

double distance_to(const MeshView& mesh, Vec3d p) {
    double least = 1e30;
    for (const Triangle& t : mesh.triangles) {
        const Corners c = corners_of(mesh.positions, t);
        least = std::min(least, length(p - closest_on_triangle(p, c[0], c[1], c[2])));
    }
    return least;
}

TEST(MeshChangeTest, WhatIsMeasuredIsWhatAMeshMadeAnewHas) {
    test::Random random(3);
    int taken_over = 0;
    for (int round = 0; round < 12; ++round) {
        MeshData data = scenes::torus(1, 0.4, 30, 10);
        Mesh before("before", data);
        before.view();
        for (int step = 0; step < 3; ++step) {
            data = cut(data, random, random.integer(1, 3));
            Mesh now("now", data, before);
            const Mesh fresh("fresh", data);
            const MeshView changed = now.view(), anew = fresh.view();
            const MeshChange change(before.view(), anew);
            for_each_array(
                [&](const auto& array, const auto& same) {
                    // Leaves may couple other triangles; the rest is looked at below.
                    using T = std::remove_cvref_t<decltype(array[0])>;
                    if constexpr (std::is_same_v<T, bvh::Leaf> || std::is_same_v<T, TriangleRing> ||
                                  std::is_same_v<T, std::uint8_t> || std::is_same_v<T, SlabCell> ||
                                  std::is_same_v<T, CellSlab>)
                        return;
                    ASSERT_EQ(array.size, same.size);
                    if (array.size == 0) return;
                    EXPECT_EQ(std::memcmp(array.data, same.data, array.size * sizeof(T)), 0)
                        << typeid(T).name();
                },
                changed, anew);
            EXPECT_NEAR(changed.leaves.size, anew.leaves.size, 0.02 * anew.leaves.size);
            std::uint32_t in_leaves = 0;
            for (const bvh::Leaf& leaf : changed.leaves) in_leaves += leaf.size();
            EXPECT_EQ(in_leaves, changed.triangles.size);
            ASSERT_EQ(changed.rings.size, anew.rings.size);
            EXPECT_EQ(changed.simple, anew.simple);
            for (std::uint32_t t = 0; t < anew.rings.size; ++t) {
                // Gaps depend a little on the order in which triangles are asked.
                TriangleRing ring = changed.rings[t];
                EXPECT_NEAR(ring.gap, anew.rings[t].gap, 0.02 * ring.gap);
                ring.gap = anew.rings[t].gap;
                EXPECT_EQ(std::memcmp(&ring, &anew.rings[t], sizeof ring), 0) << "triangle " << t;
                taken_over += change.ring(anew, t) != nullptr;
            }
            for (std::uint32_t v = 0; v < anew.star_clearance.size; ++v)
                EXPECT_EQ(changed.star_clearance[v], anew.star_clearance[v]);
            // A grid is taken over where it still holds.
            const ClearanceGridView grid = changed.clearance();
            for (int i = 0; i < 200; ++i) {
                const Vec3d p = random.in_box(1.6);
                EXPECT_LE(grid(p), distance_to(anew, p));
            }
            before = std::move(now);
        }
    }
    EXPECT_GT(taken_over, 12 * 3 * 300);
}

TEST(MeshChangeTest, WhatComesNearIsKnown) {
    const auto ball_at = [](double radius, Vec3f place) {
        MeshData ball = scenes::sphere(radius, 2);
        ball.positions = scenes::moved(std::move(ball.positions), place);
        return ball;
    };
    const MeshData three = scenes::joined(
        scenes::joined(ball_at(1, {}), ball_at(0.2, {-3, -3, -3})), ball_at(0.2, {3, 3, 3}));
    const Mesh before("before", three);
    before.view();
    const MeshData grown = scenes::joined(three, ball_at(0.5, {1.55f, 0, 0}));
    const Mesh now("now", grown, before), fresh("fresh", grown);
    const MeshView view = now.view(), anew = fresh.view();
    for (std::uint32_t t = 0; t < view.rings.size; ++t)
        EXPECT_NEAR(view.rings[t].gap, anew.rings[t].gap, 0.02 * anew.rings[t].gap) << t;
    for (std::uint32_t v = 0; v < view.star_clearance.size; ++v)
        EXPECT_EQ(view.star_clearance[v], anew.star_clearance[v]);
    const ClearanceGridView grid = view.clearance();
    test::Random random(4);
    int known = 0;
    for (int i = 0; i < 500; ++i) {
        const Vec3d p = random.in_box(3);
        EXPECT_LE(grid(p), distance_to(view, p));
        known += before.view().clearance()(p) > 0.5;
    }
    EXPECT_GT(known, 100) << "the mesh before knew of clearance";
}

}  // namespace
}  // namespace pierce
