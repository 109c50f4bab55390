// Leaves of trees: every triangle is in one, and two in a leaf share an edge.
#include "core/mesh_build/leaves.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "core/trace/bvh/traversal.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce::bvh {
namespace {

std::array<std::uint32_t, 3> sorted(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::array<std::uint32_t, 3> corners{a, b, c};
    std::ranges::sort(corners);
    return corners;
}

std::array<std::uint32_t, 3> sorted(const Triangle& t) {
    return sorted(t.vertex[0], t.vertex[1], t.vertex[2]);
}

std::vector<Leaf> checked_leaves(const MeshData& mesh) {
    std::vector<Leaf> leaves = leaves_of(mesh);
    std::vector<int> seen(mesh.triangles.size());
    for (const Leaf& leaf : leaves) {
        const auto& c = leaf.corner;
        ++seen[leaf.triangle[0]];
        EXPECT_EQ(sorted(mesh.triangles[leaf.triangle[0]]), sorted(c[0], c[1], c[2]));
        EXPECT_EQ(leaf.size(), leaf.triangle[1] == no_triangle ? 1u : 2u);
        if (leaf.size() == 1) {
            EXPECT_EQ(c[3], c[0]);
            continue;
        }
        ++seen[leaf.triangle[1]];
        EXPECT_LT(leaf.triangle[0], leaf.triangle[1]);
        EXPECT_EQ(sorted(mesh.triangles[leaf.triangle[1]]), sorted(c[3], c[2], c[1]));
    }
    EXPECT_EQ(std::ranges::count(seen, 1), std::ssize(seen)) << "every triangle once";
    EXPECT_TRUE(
        std::ranges::is_sorted(leaves, {}, [](const Leaf& leaf) { return leaf.triangle[0]; }));
    return leaves;
}

TEST(LeavesTest, HoldEveryTriangleOnce) {
    test::Random random(11);
    for (int i = 0; i < 20; ++i) {
        SCOPED_TRACE("seed " + std::to_string(random.seed()) + ", mesh " + std::to_string(i));
        checked_leaves(test::random_closed_mesh(random));
    }
}

TEST(LeavesTest, OfShapesMadeOfQuadsAreTheQuads) {
    EXPECT_EQ(checked_leaves(scenes::torus(2, 0.5, 30, 10)).size(), 300u);
    EXPECT_LT(checked_leaves(scenes::sphere(1, 4)).size(), 2700u)
        << "of 5120 triangles, a few of which stay alone";
}

TEST(LeavesTest, ExcludeTheTrianglesThatARayExcludes) {
    test::Random random(12);
    const MeshData mesh = test::random_closed_mesh(random);
    const auto vertex = [&] {
        const std::uint32_t count = static_cast<std::uint32_t>(mesh.positions.size());
        return random.integer(0, 9) == 0
                   ? no_vertex
                   : static_cast<std::uint32_t>(random.integer(0, static_cast<int>(count) - 1));
    };
    for (Leaf leaf : checked_leaves(mesh))
        for (int i = 0; i < 200; ++i) {
            const auto near = [&] {
                return random.integer(0, 1) == 0 ? leaf.corner[random.integer(0, 3)] : vertex();
            };
            const std::uint32_t first = near(),
                                excluded[2] = {first, random.integer(0, 1) == 0 ? first : near()};
            for (std::uint32_t t = 0; t < 2; ++t)
                EXPECT_EQ((excluded_of(leaf, excluded) >> t & 1) != 0,
                          leaf.triangle[t] == no_triangle ||
                              is_excluded(mesh.triangles[leaf.triangle[t]], excluded))
                    << "seed " << random.seed();
        }
}

/// One triangle; two that do not touch; two that are the same; one with a side of no length; three
/// at one edge.
TEST(LeavesTest, LeaveAloneWhatHasNoPartner) {
    const std::vector<Vec3f> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                                       {1, 1, 1}, {2, 1, 1}, {1, 2, 1}};
    const auto count = [&](std::vector<Triangle> triangles) {
        return checked_leaves({points, std::move(triangles)}).size();
    };
    EXPECT_EQ(count({{{0, 1, 2}}}), 1u);
    EXPECT_EQ(count({{{0, 1, 2}}, {{4, 5, 6}}}), 2u);
    EXPECT_EQ(count({{{0, 1, 2}}, {{0, 1, 2}}}), 1u);
    EXPECT_EQ(count({{{0, 0, 2}}}), 1u);
    EXPECT_EQ(count({{{0, 1, 2}}, {{1, 0, 3}}, {{0, 1, 4}}}), 3u);
}

/// Of the two ways to cut a strip of three triangles, the one with the smaller box.
TEST(LeavesTest, PairTheCloserNeighbour) {
    const MeshData strip{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {9, 1, 0}},
                         {{{1, 4, 3}}, {{0, 1, 2}}, {{1, 3, 2}}}};
    const std::vector<Leaf> leaves = checked_leaves(strip);
    ASSERT_EQ(leaves.size(), 2u);
    EXPECT_EQ(leaves[0].size(), 1u);
    EXPECT_EQ(leaves[1].triangle[1], 2u);
}

}  // namespace
}  // namespace pierce::bvh
