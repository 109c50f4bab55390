// What a mesh knows about itself: traits, normals, patches and its clearance grid.
#include "pierce/mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <set>
#include <string_view>
#include <thread>
#include <vector>

#include "core/device/bits.hpp"
#include "core/device/view.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "pierce/error.hpp"
#include "scenes/named/shapes.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

TEST(MeshTest, TraitsTellOpenFlippedAndDegenerate) {
    const MeshData box = scenes::box({0, 0, 0}, {1, 2, 3});
    const Mesh sound("box", box);
    EXPECT_TRUE(sound.traits().closed());
    EXPECT_NEAR(sound.traits().volume, 6, 1e-12);

    MeshData open = box;
    open.triangles.pop_back();
    EXPECT_FALSE(Mesh("open", open).traits().closed());
    EXPECT_EQ(Mesh("open", open).traits().boundary_edges, 3u);

    MeshData flipped = box;
    std::swap(flipped.triangles[0].vertex[0], flipped.triangles[0].vertex[1]);
    EXPECT_FALSE(Mesh("flipped", flipped).traits().closed());

    MeshData inside_out = box;
    for (Triangle& t : inside_out.triangles) std::swap(t.vertex[0], t.vertex[1]);
    EXPECT_TRUE(Mesh("inside out", inside_out).traits().closed());
    EXPECT_NEAR(Mesh("inside out", inside_out).traits().volume, -6, 1e-12);

    MeshData thin = box;
    thin.triangles.push_back({{0, 1, 1}});
    EXPECT_EQ(Mesh("thin", thin).traits().degenerate_triangles, 1u);
}

TEST(MeshTest, WhatIsNoMeshIsRefused) {
    const auto scaled = [](double by) {
        MeshData data = scenes::box({-1, -1, -1}, {1, 1, 1});
        for (Vec3f& p : data.positions) p = to_float(by * to_double(p));
        return data;
    };
    EXPECT_NO_THROW(Mesh("a point", scaled(0)));
    EXPECT_NO_THROW(Mesh("small", scaled(0x1p-61)));
    EXPECT_THROW(Mesh("too small", scaled(0x1p-63)), InputError);
    EXPECT_NO_THROW(Mesh("large", scaled(0x1p60)));
    EXPECT_THROW(Mesh("too large", scaled(0x1p61)), InputError);
    const auto no_rule = static_cast<Inside>(4);
    EXPECT_THROW(Mesh("no rule", scaled(1), {.inside = no_rule}), InputError);
    const Mesh box("box", scaled(1));
    EXPECT_EQ(box.given_triangle(11), 11u);
    EXPECT_THROW((void)box.given_triangle(12), InputError);
    EXPECT_THROW((void)box.given_triangle(no_triangle), InputError);
}

TEST(MeshTest, NormalsPointOutward) {
    const Mesh ball("ball", scenes::sphere(2, 3));
    for (std::size_t v = 0; v < ball.positions().size(); ++v)
        EXPECT_NEAR(dot(to_double(ball.normals()[v]), normalized(to_double(ball.positions()[v]))),
                    1, 1e-3);
    const Mesh box("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    for (std::size_t v = 0; v < 8; ++v)
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(std::abs(box.normals()[v][k]), 1 / std::sqrt(3.0), 1e-6)
                << "weighted by angle, not by triangle";
}

TEST(MeshTest, FansHoldWhatIsAroundAVertexInOrder) {
    test::Random random(9);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::uint32_t closed = 0, open = 0;
    for (int i = 0; i < 12; ++i) {
        const Mesh made("any", test::random_closed_mesh(random));
        // Every fifth triangle away: borders, and vertices where two fans meet.
        MeshData data{{made.positions().begin(), made.positions().end()}, {}};
        for (std::size_t t = 0; t < made.triangles().size(); ++t)
            if (i % 2 == 0 || t % 5 != 0) data.triangles.push_back(made.triangles()[t]);
        const Mesh mesh("any", data);
        const MeshView view = mesh.view();
        ASSERT_EQ(view.fans.size, view.corners.size);
        for (std::uint32_t v = 0; v < view.positions.size; ++v) {
            const std::uint32_t begin = view.corner_offsets[v], end = view.corner_offsets[v + 1];
            std::set<std::pair<std::uint32_t, std::uint32_t>> sides, expected;
            std::set<std::uint32_t> nexts, previous;
            for (std::uint32_t c = begin; c < end; ++c) {
                expected.insert({view.corners[c].next, view.corners[c].previous});
                nexts.insert(view.corners[c].next);
                previous.insert(view.corners[c].previous);
                sides.insert({view.fans[c], view.fans[c + 1 < end ? c + 1 : begin]});
            }
            if (begin < end && view.fans[begin] != no_vertex) {
                EXPECT_EQ(sides, expected) << "vertex " << v;
                ++closed;
            } else {
                ++open;
                EXPECT_TRUE(end - begin < 3 || nexts != previous || i % 2 == 1) << "vertex " << v;
            }
        }
    }
    EXPECT_GT(closed, 500u);
    EXPECT_GT(open, 100u);
}

TEST(MeshTest, StarClearanceIsALowerBoundThatIsAlmostReached) {
    test::Random random(8);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 12; ++i) {
        const Mesh mesh("any", test::random_closed_mesh(random));
        const MeshView view = mesh.view();
        for (std::uint32_t v = 0; v < view.positions.size; v += 7) {
            const Vec3d at = to_double(view.positions[v]);
            double longest_edge = 0, sampled = std::numeric_limits<double>::infinity();
            for (const Triangle& t : view.triangles) {
                const Vec3d corner[3] = {to_double(view.positions[t.vertex[0]]),
                                         to_double(view.positions[t.vertex[1]]),
                                         to_double(view.positions[t.vertex[2]])};
                if (std::ranges::find(t.vertex, v) != std::end(t.vertex)) {
                    for (Vec3d c : corner) longest_edge = std::max(longest_edge, length(c - at));
                    continue;
                }
                constexpr int n = 10;
                for (int a = 0; a <= n; ++a)
                    for (int b = 0; a + b <= n; ++b) {
                        const Vec3d p = (1.0 / n) *
                                        (a * corner[0] + b * corner[1] + (n - a - b) * corner[2]);
                        sampled = std::min(sampled, length(p - at));
                    }
            }
            ASSERT_LE(view.star_clearance[v], sampled) << "mesh " << i << " vertex " << v;
            ASSERT_LE(view.star_clearance[v], longest_edge);
            ASSERT_GE(view.star_clearance[v], 0.8 * std::min(sampled, longest_edge))
                << "mesh " << i << " vertex " << v;
        }
    }
}

TEST(MeshTest, ThreadsChangeNothing) {
    test::Random random(12);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const auto bytes_of = [](const auto& array) {
        return std::string_view(reinterpret_cast<const char*>(array.data),
                                array.size * sizeof *array.data);
    };
    for (int i = 0; i < 4; ++i) {
        const MeshData data = i == 0 ? scenes::torus(1, 0.4, 120, 60)
                                     : test::random_closed_mesh(random);
        const Mesh alone("one thread", data, {.threads = 1}), shared("five", data, {.threads = 5});
        const MeshView a = alone.view(), b = shared.view();
        EXPECT_EQ(a.simple, b.simple);
        for_each_array(
            [&](const auto& one, const auto& other) { EXPECT_EQ(bytes_of(one), bytes_of(other)); },
            a, b);
    }
}

TEST(MeshTest, AViewHasWhatIsNeeded) {
    const Mesh mesh("torus", scenes::torus(1, 0.4, 24, 12));
    const auto has = [&](const MeshNeeds& needs) {
        const MeshView v = mesh.view(needs);
        EXPECT_EQ(v.slab_cells.size > 0, v.slabs_at.cell > 0);
        EXPECT_EQ(v.clearance_steps.size > 0, v.clearance_at.cell > 0);
        return std::array{v.clearance_steps.size > 0, v.slab_cells.size > 0, v.rings.size > 0,
                          v.star_clearance.size > 0,  v.own_exit.size > 0,   v.simple};
    };
    for (int twice = 0; twice < 2; ++twice) {
        EXPECT_EQ(has({}), (std::array{false, false, false, false, false, false}));
        EXPECT_EQ(has({.clearance = true}), (std::array{true, false, false, false, false, false}));
        EXPECT_EQ(has({.slabs = true}), (std::array{false, true, false, false, false, false}));
        EXPECT_EQ(has({.rings = true}), (std::array{false, false, true, false, false, true}));
        EXPECT_EQ(has({.stars = true}), (std::array{false, false, false, true, false, false}));
        EXPECT_EQ(has({.own_exits = true}), (std::array{false, false, false, false, true, false}));
        EXPECT_EQ(has(MeshNeeds::all()), (std::array{true, true, true, true, true, true}));
    }
}

TEST(MeshTest, SeveralThreadsMayNeedAMeshAtOnce) {
    const Mesh mesh("torus", scenes::torus(1, 0.4, 60, 30));
    std::vector<std::jthread> threads;
    std::array<std::uint32_t, 4> rings{}, slabs{};
    for (std::size_t k = 0; k < 4; ++k)
        threads.emplace_back([&, k] {
            const MeshView v = mesh.view({.clearance = true, .rings = k > 1, .slabs = k % 2 == 0});
            rings[k] = v.rings.size;
            slabs[k] = v.slab_cells.size;
        });
    threads.clear();
    EXPECT_EQ(rings, (std::array{0u, 0u, 3600u, 3600u}));
    EXPECT_GT(slabs[0], 0u);
    EXPECT_EQ(slabs, (std::array{slabs[0], 0u, slabs[0], 0u}));
}

TEST(MeshTest, ATipBetweenTwoSolidsHasNoNormal) {
    MeshData bowtie{
        {{0, 0, 0}, {1, 0, 1}, {-1, 1, 1}, {-1, -1, 1}, {-1, 0, -1}, {1, -1, -1}, {1, 1, -1}}, {}};
    bowtie.triangles = {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 1, 3}}, {{1, 2, 3}}, {{0, 4, 5}},
                        {{0, 5, 6}}, {{0, 6, 4}}, {{4, 6, 5}}};  // the second is the first
                                                                 // reflected in the tip
    const Mesh mesh("bowtie", bowtie);
    EXPECT_EQ(mesh.normals()[0], Vec3f{});
    EXPECT_GT(length(mesh.normals()[1]), 0.9f);
}

TEST(MeshTest, PatchesHoldEveryVertexOnce) {
    const Mesh mesh("torus", scenes::torus(2, 0.5, 80, 10));
    const MeshView view = mesh.view();
    ASSERT_GT(block_count(view), 1u);
    std::set<std::uint32_t> seen(view.patch_vertices.begin(), view.patch_vertices.end());
    EXPECT_EQ(seen.size(), mesh.positions().size());
    for (std::uint32_t p = 0; p < patch_count(view); ++p)
        for (std::uint32_t k = 0; k < patch_length(view, p); ++k) {
            const Vec3d x = to_double(
                mesh.positions()[view.patch_vertices[p * constants::patch_size + k]]);
            const PatchBlock& block = view.blocks[p / constants::block_size];
            const Vec3d center = patch_center(view.blocks, p);
            const Offsets& offset = view.patches[p];
            EXPECT_NEAR(length(x - center - Vec3d{offset.x[k], offset.y[k], offset.z[k]}), 0,
                        constants::float_ulp * block.reach);
            EXPECT_LE(length(x - center), block.radius[p % constants::block_size]);
            EXPECT_LE(length(x - block.center), block.reach);
        }
}

/// Distance from a point to a triangle, by minimising over its corners, edges and face.
double distance_to_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    const auto to_edge = [&](Vec3d u, Vec3d v) {
        const double s = std::clamp(dot(p - u, v - u) / length_squared(v - u), 0.0, 1.0);
        return length(p - (u + s * (v - u)));
    };
    double best = std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
    const Vec3d n = cross(b - a, c - a);
    const bool over = dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 &&
                      dot(cross(a - c, p - c), n) >= 0;
    if (over) best = std::min(best, std::abs(dot(p - a, normalized(n))));
    return best;
}

TEST(ClearanceGridTest, NeverPromisesMoreThanTheTruth) {
    test::Random random(9);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int useful = 0;
    for (int m = 0; m < 20; ++m) {
        const MeshData data = test::random_closed_mesh(random);
        const Mesh mesh("random", data);
        test::Solid solid{{}, data.triangles};
        for (Vec3f p : data.positions) solid.positions.push_back({p.x, p.y, p.z});
        for (int i = 0; i < 200; ++i) {
            const Vec3d p = random.in_box(1.3);
            const double promised = mesh.view().clearance()(p);
            if (promised == 0) continue;
            ++useful;
            EXPECT_FALSE(test::is_inside({p.x, p.y, p.z}, solid));
            double truth = std::numeric_limits<double>::infinity();
            for (const Triangle& t : data.triangles)
                truth = std::min(truth,
                                 distance_to_triangle(p, to_double(data.positions[t.vertex[0]]),
                                                      to_double(data.positions[t.vertex[1]]),
                                                      to_double(data.positions[t.vertex[2]])));
            EXPECT_LE(promised, truth + 1e-6);
        }
    }
    EXPECT_GT(useful, 1000);
}

TEST(AngleTest, MatchesTheStandardLibrary) {
    for (int i = 0; i <= 1000; ++i) {
        const double angle = std::numbers::pi * i / 1000;
        EXPECT_NEAR(angle_of(3 * std::cos(angle), 3 * std::sin(angle)), angle, 3e-8);
    }
    EXPECT_EQ(angle_of(0, 0), 0);
}

TEST(LeadsInsideTest, AgreesWithTheInsideTest) {
    test::Random random(12);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int inside = 0;
    for (int m = 0; m < 20; ++m) {
        const MeshData data = test::random_closed_mesh(random);
        const Mesh mesh("random", data);
        test::Solid solid{{}, data.triangles};
        for (Vec3f p : data.positions) solid.positions.push_back({p.x, p.y, p.z});
        for (int i = 0; i < 50; ++i) {
            const auto v = static_cast<std::uint32_t>(
                random.integer(0, static_cast<int>(data.positions.size()) - 1));
            const Vec3d direction = random.unit_vector();
            if (!leads_inside(mesh.view(), view_of(data.positions), v, direction)) continue;
            ++inside;
            const Vec3d p = to_double(data.positions[v]) + 1e-4 * direction;
            EXPECT_TRUE(test::is_inside({p.x, p.y, p.z}, solid)) << "vertex " << v;
        }
    }
    EXPECT_GT(inside, 50);
}

TEST(TriangleFeaturesTest, EveryVertexAndEdgeBelongsToOneTriangleAndHardlyAnyTriangleHasMany) {
    test::Random random(7);
    for (int i = 0; i < 40; ++i) {
        const Mesh mesh("shape",
                        i == 0 ? scenes::grid(1, 1, 30, 20) : test::random_closed_mesh(random));
        const MeshView& view = mesh.view();
        std::vector<int> vertices(view.positions.size, 0), edges(view.edges.size, 0);
        std::uint32_t with_more_vertices = 0, with_three_edges = 0;
        for (std::uint32_t t = 0; t < view.triangles.size; ++t) {
            const TriangleFeatures& of = view.features[t];
            for (std::uint32_t k = 0; k < 3; ++k) {
                if (of.own >> k & 1) ++vertices[view.triangles[t].vertex[k]];
                if (of.own >> (3 + k) & 1) ++edges[of.edge[k]];
            }
            with_more_vertices += bit_count(of.own & 7) > 1;
            with_three_edges += of.own >> 3 == 7;
        }
        for (const int owners : vertices)
            ASSERT_EQ(owners, 1) << "seed " << random.seed() << ", shape " << i;
        for (const int owners : edges)
            ASSERT_EQ(owners, 1) << "seed " << random.seed() << ", shape " << i;
        // A closed mesh has half as many vertices as triangles, an open one more.
        const std::uint32_t few = view.triangles.size / 20;
        EXPECT_LE(with_more_vertices, i == 0 ? 2 * few : 0)
            << "seed " << random.seed() << ", shape " << i;
        EXPECT_LE(with_three_edges, few) << "seed " << random.seed() << ", shape " << i;
    }
}

}  // namespace
}  // namespace pierce
