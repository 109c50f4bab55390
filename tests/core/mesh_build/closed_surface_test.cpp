// A surface that is made closed: which triangles are turned, left out or added, and that it winds
// around the same points as the mesh did before it was damaged.
#include "core/mesh_build/closed_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh_build/caps.hpp"
#include "core/mesh_build/mesh_topology.hpp"
#include "core/mesh_build/winding_tree.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/mesh_fix.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

MeshTraits traits_of(const MeshData& data) {
    return traits_of(data, HalfEdges(data.triangles, data.positions.size()), {});
}

double mean_edge(const MeshData& data) { return traits_of(data).mean_edge_length; }

/// The surface of a mesh as a mesh, and what was done.
std::pair<MeshData, MeshInside> solid(const MeshData& mesh, Inside rule = Inside::automatic) {
    Workers workers(0);
    ClosedSurface surface = closed_surface(mesh, rule, workers);
    EXPECT_EQ(surface.triangles.size(), surface.given.size());
    return {{mesh.positions, std::move(surface.triangles)}, surface.inside};
}

/// True if both meshes have the same triangles in the same order, facing the same way.
bool same_triangles(const MeshData& mesh, const MeshData& other) {
    return std::ranges::equal(mesh.triangles, other.triangles, [](Triangle t, const Triangle& o) {
        for (int turn = 0; turn < 2 && t != o; ++turn) std::ranges::rotate(t.vertex, t.vertex + 1);
        return t == o;
    });
}

/// Fails unless the surface is closed and winds around random points as `whole` does, but for a
/// share of them.
void expect_same_inside(const MeshData& surface, const MeshData& whole, double share,
                        const std::string& what) {
    ASSERT_EQ(traits_of(surface).inconsistent_edges, 0u) << what;
    const WindingTree winding(surface.positions, surface.triangles),
        exact(whole.positions, whole.triangles);
    test::Random random(7);
    Box box;
    for (Vec3f p : whole.positions) box.extend(to_double(p));
    int differ = 0;
    constexpr int points = 500;
    for (int i = 0; i < points; ++i) {
        Vec3d p;
        for (int k = 0; k < 3; ++k) p[k] = random.uniform(box.lower[k], box.upper[k]);
        const double w = winding.exactly_at(p);
        ASSERT_NEAR(w, std::round(w), 1e-6) << what;
        differ += std::lround(w) != std::lround(exact.exactly_at(p));
    }
    EXPECT_LE(differ, share * points) << what;
}

TEST(ClosedSurfaceTest, BoxWithAMissingOrATurnedTriangle) {
    const MeshData box = scenes::box({0, 0, 0}, {1, 2, 3});
    for (std::uint32_t t = 0; t < box.triangles.size(); ++t) {
        MeshData open = box;
        open.triangles.erase(open.triangles.begin() + t);
        const auto [closed, inside] = solid(open);
        EXPECT_EQ(inside.rule, Inside::winding);
        EXPECT_EQ(inside.holes, 1u);
        EXPECT_EQ(inside.cap_triangles, 1u);
        expect_same_inside(closed, box, 0, "without triangle " + std::to_string(t));

        MeshData flipped = box;
        std::swap(flipped.triangles[t].vertex[0], flipped.triangles[t].vertex[1]);
        const auto [turned, how] = solid(flipped);
        EXPECT_EQ(how.turned_triangles, 1u);
        EXPECT_EQ(how.cap_triangles, 0u);
        expect_same_inside(turned, box, 0, "with triangle " + std::to_string(t) + " turned");
    }
}

/// With the triangles in another order, one of them first.
MeshData in_order(MeshData mesh, std::size_t first) {
    std::ranges::rotate(mesh.triangles,
                        mesh.triangles.begin() + static_cast<std::ptrdiff_t>(first));
    return mesh;
}

MeshData inside_out(MeshData mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t.vertex[1], t.vertex[2]);
    return mesh;
}

TEST(ClosedSurfaceTest, WhichWayPartsFaceDoesNotDependOnTheirOrder) {
    const MeshData a = scenes::box({0, 0, 0}, {1, 1, 1}),
                   b = scenes::box({0.9f, 0.1f, 0.1f}, {2, 0.9f, 0.9f});
    const MeshData whole = scenes::joined(a, b);
    for (const bool both : {false, true})
        for (std::size_t first = 0; first < b.triangles.size(); ++first)
            for (const std::size_t missing : {3u, 8u}) {
                MeshData mesh = scenes::joined(both ? inside_out(a) : a,
                                               in_order(inside_out(b), first));
                mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(missing));
                const auto [closed, inside] = solid(mesh);
                EXPECT_EQ(inside.rule, Inside::winding);
                EXPECT_EQ(inside.turned_triangles, both ? 23u : 12u);
                expect_same_inside(closed, whole, 0, std::to_string(first));
            }
}

TEST(ClosedSurfaceTest, CavitiesStayCavitiesWhereAllIsInsideOut) {
    const MeshData ball = scenes::sphere(1, 2),
                   hollow = scenes::joined(ball, inside_out(scenes::sphere(0.5, 1)));
    for (const bool turned : {false, true}) {
        MeshData mesh = turned ? inside_out(hollow) : hollow;
        mesh.triangles.erase(mesh.triangles.begin() + 7);
        const auto [closed, inside] = solid(mesh);
        EXPECT_EQ(inside.turned_triangles, turned ? mesh.triangles.size() : 0u);
        EXPECT_EQ(inside.left_out_triangles, 0u);
        expect_same_inside(closed, hollow, 0.01, turned ? "turned" : "as it is");
    }
}

/// A box whose sides have vertices of their own and `n` by `n` squares, and stand apart from each
/// other by `gap`.
MeshData box_of_sides(std::uint32_t n, double gap, const std::vector<int>& apart) {
    MeshData mesh;
    for (int side = 0; side < 6; ++side) {
        MeshData grid = scenes::grid(1, 1, n + 1, n + 1);
        Box box;
        for (Vec3f p : grid.positions) box.extend(to_double(p));
        int flat = 0;
        while (box.upper[flat] - box.lower[flat] > 0) ++flat;
        const int axis = side / 2, sign = side % 2 == 0 ? -1 : 1;
        const bool is_apart = std::ranges::find(apart, side) != apart.end();
        for (Vec3f& p : grid.positions) {
            const Vec3d from = to_double(p) - box.center();
            Vec3d to;
            to[axis] = sign * (0.5 + (is_apart ? gap : 0.0));
            to[(axis + 1) % 3] = from[(flat + 1) % 3];
            to[(axis + 2) % 3] = from[(flat + 2) % 3];
            p = to_float(to);
        }
        const Triangle& t = grid.triangles[0];
        const auto at = [&](int k) { return to_double(grid.positions[t.vertex[k]]); };
        if (cross(at(1) - at(0), at(2) - at(0))[axis] * sign < 0) grid = inside_out(grid);
        mesh = scenes::joined(mesh, grid);
    }
    return mesh;
}

TEST(ClosedSurfaceTest, GapsBetweenSidesAreSewnUp) {
    const MeshData whole = scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f});
    for (const std::uint32_t n : {1u, 4u, 9u})
        for (const double gap : {1e-7, 1e-4, 5e-3})
            for (const std::vector<int>& apart :
                 {std::vector{5}, {4, 5}, {3, 5}, {1, 3, 5}, {0, 1, 2, 3, 4, 5}}) {
                const std::string what = std::to_string(n) + " " + std::to_string(gap) + " " +
                                         std::to_string(apart.size());
                MeshData mesh = box_of_sides(n, gap, apart);
                for (const bool some_turned : {false, true}) {
                    // Sides 1 and 4 face inward.
                    if (some_turned)
                        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
                            if (const std::size_t side = 6 * t / mesh.triangles.size();
                                side == 1 || side == 4)
                                std::swap(mesh.triangles[t].vertex[1], mesh.triangles[t].vertex[2]);
                    const auto [closed, inside] = solid(mesh);
                    EXPECT_EQ(inside.rule, Inside::winding) << what;
                    EXPECT_EQ(inside.turned_triangles, some_turned ? 4 * n * n : 0) << what;
                    EXPECT_LT(inside.cap_share, 0.02) << what;
                    expect_same_inside(closed, whole, 0.02, what);
                }
            }
}

/// A box with walls across its middle, each of which meets the others and the sides.
MeshData box_with_walls(int walls) {
    MeshData mesh;
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
                mesh.positions.push_back(
                    {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    const auto at = [](const int(&p)[3]) {
        return static_cast<std::uint32_t>(9 * (p[0] + 1) + 3 * (p[1] + 1) + p[2] + 1);
    };
    for (int axis = 0; axis < 3; ++axis)
        for (int level = -1; level <= 1; ++level)
            for (int i = -1; i < 1 && (level != 0 || axis < walls); ++i)
                for (int j = -1; j < 1; ++j) {
                    int p[4][3];
                    for (int k = 0; k < 4; ++k) {
                        p[k][axis] = level;
                        p[k][(axis + 1) % 3] = i + (k == 1 || k == 2);
                        p[k][(axis + 2) % 3] = j + (k >= 2);
                    }
                    Triangle one{{at(p[0]), at(p[1]), at(p[2])}},
                        other{{at(p[0]), at(p[2]), at(p[3])}};
                    if (level < 0)
                        for (Triangle* t : {&one, &other}) std::swap(t->vertex[1], t->vertex[2]);
                    mesh.triangles.push_back(one);
                    mesh.triangles.push_back(other);
                }
    return mesh;
}

TEST(ClosedSurfaceTest, WallsThatCrossAreLeftOut) {
    const MeshData whole = scenes::box({-1, -1, -1}, {1, 1, 1});
    std::mt19937 order(5);
    for (int walls = 1; walls <= 3; ++walls)
        for (int i = 0; i < 8; ++i) {
            MeshData mesh = box_with_walls(walls);
            // Which way walls face says nothing.
            for (Triangle& t : mesh.triangles) {
                const auto is_on = [&](int axis) {
                    return std::ranges::all_of(
                        t.vertex, [&](std::uint32_t v) { return mesh.positions[v][axis] == 0; });
                };
                if ((is_on(0) && (i & 1) != 0) || (is_on(1) && (i & 2) != 0) ||
                    (is_on(2) && (i & 4) != 0))
                    std::swap(t.vertex[1], t.vertex[2]);
            }
            std::ranges::shuffle(mesh.triangles, order);
            const auto [closed, inside] = solid(mesh);
            EXPECT_EQ(inside.rule, Inside::winding);
            EXPECT_EQ(inside.left_out_triangles, 8u * static_cast<std::uint32_t>(walls));
            EXPECT_EQ(inside.cap_triangles, 0u);
            expect_same_inside(closed, whole, 0, std::to_string(walls) + " " + std::to_string(i));
        }
}

// At the rim of a wall, what is left around the hole has two triangles: the wall and another side.
TEST(ClosedSurfaceTest, ATriangleThatIsMissingAtTheRimOfAWallIsAHole) {
    const MeshData whole = scenes::box({-1, -1, -1}, {1, 1, 1});
    const MeshData mesh = box_with_walls(1);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        MeshData damaged = mesh;
        damaged.triangles.erase(damaged.triangles.begin() + static_cast<std::ptrdiff_t>(t));
        const auto [closed, inside] = solid(damaged);
        EXPECT_EQ(inside.rule, Inside::winding) << t;
        expect_same_inside(closed, whole, 0, "without " + std::to_string(t));
    }
}

// Each box is a closed patch whose middles of triangles lie in the other one, or in a third one.
TEST(ClosedSurfaceTest, ClosedPartsThatStickOutOfOthersStay) {
    MeshData small = scenes::box({-0.8f, -0.8f, -0.8f}, {0.8f, 0.8f, 0.8f});
    // Its diagonal lies along x.
    const Vec3d x = normalized(Vec3d{1, 1, 1}), y = normalized(cross(Vec3d{0, 0, 1}, x)),
                z = cross(x, y);
    for (Vec3f& p : small.positions) {
        const Vec3d from = to_double(p);
        p = to_float({dot(x, from), dot(y, from), dot(z, from)});
    }
    const MeshData whole = scenes::joined(scenes::box({-1, -1, -1}, {1, 1, 1}), small);
    MeshData open = whole;
    open.triangles.push_back({{0, 1, 2}});  // a scrap: the mesh is not closed
    open.positions.insert(open.positions.end(), {{5, 0, 0}, {5, 1, 0}, {5, 0, 1}});
    const auto n = static_cast<std::uint32_t>(open.positions.size());
    open.triangles.back() = {{n - 3, n - 2, n - 1}};
    const auto [closed, inside] = solid(open);
    EXPECT_EQ(inside.left_out_triangles, 1u);
    expect_same_inside(closed, whole, 0, "with a scrap");
}

TEST(ClosedSurfaceTest, OpeningsAreNoHoles) {
    MeshData crate = scenes::box({0, 0, 0}, {1, 1, 3});
    std::erase_if(crate.triangles, [&](const Triangle& t) {
        return std::ranges::all_of(t.vertex, [&](auto v) { return crate.positions[v].z == 3; });
    });
    ASSERT_EQ(crate.triangles.size(), 10u);
    EXPECT_FALSE(solid(crate).second.exists());
    EXPECT_TRUE(solid(crate).first.triangles.empty());
    EXPECT_TRUE(solid(crate, Inside::winding).second.exists());

    const MeshData tube = scenes::tube(1, 6, 24, 20), sheet = scenes::grid(1, 1, 20, 20);
    EXPECT_FALSE(solid(tube).second.exists());
    EXPECT_TRUE(solid(tube, Inside::winding).second.exists());
    EXPECT_FALSE(solid(sheet).second.exists());
    EXPECT_FALSE(solid(sheet, Inside::winding).second.exists());
}

/// A mesh in which every triangle has vertices of its own, as STL files hold it.
TEST(ClosedSurfaceTest, SoupOfTriangles) {
    const MeshData ball = scenes::sphere(1, 3);
    MeshData soup;
    for (const Triangle& t : ball.triangles) {
        for (std::uint32_t v : t.vertex) soup.positions.push_back(ball.positions[v]);
        const auto n = static_cast<std::uint32_t>(soup.positions.size());
        soup.triangles.push_back({{n - 3, n - 2, n - 1}});
    }
    const auto [closed, inside] = solid(soup);
    EXPECT_EQ(inside.joined_vertices, soup.positions.size() - ball.positions.size());
    EXPECT_EQ(inside.cap_triangles, 0u);
    EXPECT_EQ(inside.left_out_triangles, 0u);
    expect_same_inside(closed, ball, 0, "soup");
}

TEST(ClosedSurfaceTest, DoubledTrianglesCountOnce) {
    const MeshData ball = scenes::sphere(1, 3);
    MeshData doubled = ball, both_ways = ball;
    for (std::uint32_t t = 0; t < 100; ++t) {
        const Triangle& triangle = ball.triangles[3 * t];
        doubled.triangles.push_back({{triangle.vertex[1], triangle.vertex[2], triangle.vertex[0]}});
        both_ways.triangles.push_back(
            {{triangle.vertex[1], triangle.vertex[0], triangle.vertex[2]}});
    }
    for (const MeshData* mesh : {&doubled, &both_ways}) {
        const auto [closed, inside] = solid(*mesh);
        EXPECT_EQ(inside.left_out_triangles, 100u);
        EXPECT_TRUE(same_triangles(closed, ball));
    }
}

TEST(ClosedSurfaceTest, WallsAndScrapsAreLeftOut) {
    // Two boxes with a wall between them, which is given once.
    MeshData boxes = scenes::box({0, 0, 0}, {2, 1, 1});
    const MeshData whole = boxes;
    boxes = scenes::joined(scenes::box({0, 0, 0}, {1, 1, 1}), scenes::box({1, 0, 0}, {2, 1, 1}));
    bool wall = true;
    std::erase_if(boxes.triangles, [&](const Triangle& t) {
        const bool between = std::ranges::all_of(t.vertex,
                                                 [&](auto v) { return boxes.positions[v].x == 1; });
        if (!between) return false;
        const auto id = &t - boxes.triangles.data();
        return !wall || id >= 12;
    });
    ASSERT_EQ(boxes.triangles.size(), 22u);
    const auto [merged, inside] = solid(boxes);
    EXPECT_EQ(inside.left_out_triangles, 2u);
    EXPECT_EQ(inside.cap_triangles, 0u);
    expect_same_inside(merged, whole, 0, "wall");

    // A disc that floats in a ball, and one that floats beside it.
    const MeshData ball = scenes::sphere(1, 3);
    MeshData disc = scenes::grid(0.8, 0.8, 6, 6), scrap = disc;
    for (Vec3f& p : scrap.positions) p.x += 3;
    MeshData all = scenes::joined(scenes::joined(ball, disc), scrap);
    all.triangles.erase(all.triangles.begin());
    const auto [rest, how] = solid(all);
    EXPECT_EQ(how.left_out_triangles, 100u);
    EXPECT_EQ(how.cap_triangles, 1u);
    expect_same_inside(rest, ball, 0, "disc");
}

/// A ball in two halves with a gap between them, of vertices that do not face each other.
TEST(ClosedSurfaceTest, GapsAreBridged) {
    const std::uint32_t around = 40;
    MeshData tube = scenes::capsule(1, 1, around, 8), halves = tube;
    std::vector<Triangle> kept;
    const auto count = static_cast<std::uint32_t>(tube.positions.size());
    for (Vec3f p : tube.positions) {
        const double angle = 0.03;
        halves.positions.push_back(
            {p.x + 0.02f, static_cast<float>(p.y * std::cos(angle) - p.z * std::sin(angle)),
             static_cast<float>(p.y * std::sin(angle) + p.z * std::cos(angle))});
    }
    for (Triangle t : tube.triangles) {
        if (std::ranges::all_of(t.vertex, [&](auto v) { return tube.positions[v].x > 1.2f; }))
            for (std::uint32_t& v : t.vertex) v += count;
        kept.push_back(t);
    }
    halves.triangles = kept;
    ASSERT_EQ(traits_of(halves).boundary_edges, 2 * around);
    const auto [closed, inside] = solid(halves);
    EXPECT_EQ(inside.rule, Inside::winding);
    EXPECT_EQ(inside.holes, 1u);
    EXPECT_EQ(inside.cap_triangles, traits_of(halves).boundary_edges);
    expect_same_inside(closed, tube, 0.02, "gap");
}

TEST(ClosedSurfaceTest, TJunctionsAreClosed) {
    MeshData box = scenes::box({0, 0, 0}, {1, 1, 1});
    const MeshData whole = box;
    // One triangle is cut at the middle of a side, its neighbour is not.
    const Triangle t = box.triangles[5];
    const auto middle = static_cast<std::uint32_t>(box.positions.size());
    box.positions.push_back(to_float(
        0.5 * (to_double(box.positions[t.vertex[0]]) + to_double(box.positions[t.vertex[1]]))));
    box.triangles[5] = {{t.vertex[0], middle, t.vertex[2]}};
    box.triangles.push_back({{middle, t.vertex[1], t.vertex[2]}});
    const auto [closed, inside] = solid(box);
    EXPECT_EQ(inside.rule, Inside::winding);
    EXPECT_EQ(inside.cap_triangles, 1u);
    EXPECT_EQ(inside.cap_share, 0);
    expect_same_inside(closed, whole, 0, "T-junction");
}

TEST(ClosedSurfaceTest, DamagedMeshesKeepTheirInside) {
    const std::vector<std::pair<std::string, MeshData>> shapes = {
        {"torus", scenes::torus(1, 0.4, 40, 20)},
        {"ball", scenes::sphere(1, 3)},
        {"capsule", scenes::capsule(0.5, 1, 24, 12)}};
    for (const auto& [name, whole] : shapes)
        for (const double damage : {0.01, 0.03, 0.1})
            for (std::uint32_t seed = 0; seed < 4; ++seed) {
                test::Random random(seed);
                MeshData torn = whole, flipped = whole;
                const auto hit = [&] { return random.uniform(0, 1) < damage; };
                std::erase_if(torn.triangles, [&](const Triangle&) { return hit(); });
                for (Triangle& t : flipped.triangles)
                    if (hit()) std::swap(t.vertex[0], t.vertex[1]);
                const std::string what = name + " damaged by " + std::to_string(damage) +
                                         ", seed " + std::to_string(seed);
                expect_same_inside(solid(torn, Inside::winding).first, whole, 0.01,
                                   what + ", torn");
                const auto [turned, inside] = solid(flipped, Inside::winding);
                EXPECT_TRUE(same_triangles(turned, whole)) << what;
            }
}

TEST(ClosedSurfaceTest, WhatIsInsideOutIsTurnedButCavitiesAreNot) {
    MeshData ball = scenes::sphere(1, 3), hollow = scenes::sphere(0.5, 2);
    const auto turn = [](MeshData& mesh) {
        for (Triangle& t : mesh.triangles) std::swap(t.vertex[0], t.vertex[1]);
    };
    turn(hollow);
    const MeshData whole = scenes::joined(ball, hollow);
    turn(ball);
    MeshData open = scenes::joined(ball, hollow);
    open.triangles.erase(open.triangles.begin() + 7);
    const auto [closed, inside] = solid(open);
    EXPECT_EQ(inside.turned_triangles, ball.triangles.size() - 1);
    expect_same_inside(closed, whole, 0, "ball with a cavity, inside out");
}

/// Through a hole in the outer wall, some of the cavity's wall is seen from behind.
TEST(ClosedSurfaceTest, CavitiesStayWhereBothWallsHaveHoles) {
    const MeshData ball = scenes::sphere(1, 2);
    MeshData hollow = scenes::sphere(0.6, 2);
    for (Triangle& t : hollow.triangles) std::swap(t.vertex[0], t.vertex[1]);
    const MeshData whole = scenes::joined(ball, hollow);
    test::Random random(44);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    const auto count = static_cast<int>(ball.triangles.size());
    for (int i = 0; i < 40; ++i) {
        MeshData open = whole;
        const int holes = 1 + i % 5;
        for (int k = 0; k < holes; ++k) {
            open.triangles.erase(open.triangles.begin() + count + random.integer(0, count - 10));
            open.triangles.erase(open.triangles.begin() + random.integer(0, count - 10));
        }
        const auto [closed, inside] = solid(open);
        EXPECT_EQ(inside.left_out_triangles, 0u) << holes << " holes in each wall";
        expect_same_inside(closed, whole, 0.01, "a ball with a cavity and holes");
    }
}

/// A loose triangle and what closes it separate nothing, also where they go through a wall.
TEST(FixMeshTest, CoversWhatDetectionCovers) {
    MeshData box = scenes::box({0, 0, 0}, {1, 1, 1});
    const auto first = static_cast<std::uint32_t>(box.positions.size());
    for (const Vec3f p : {Vec3f{0.9f, 0.4f, 0.5f}, Vec3f{1.1f, 0.4f, 0.5f}, Vec3f{1, 0.5f, 0.55f}})
        box.positions.push_back(p);
    box.triangles.push_back({{first, first + 1, first + 2}});
    const Mesh given("given", box), fixed("fixed", fix_mesh(box).mesh);
    ASSERT_TRUE(given.inside().exists() && fixed.inside().exists());
    EXPECT_EQ(given.inside().covered_triangles, fixed.inside().covered_triangles);
    EXPECT_LE(given.inside().covered_triangles, 2u) << "the loose ones, and no wall";
}

TEST(FixMeshTest, ClosesWhatIsNearlyClosed) {
    MeshData ball = scenes::sphere(1, 3);
    const MeshData whole = ball;
    ball.triangles.erase(ball.triangles.begin() + 5);
    ball.triangles.push_back(ball.triangles[8]);
    std::swap(ball.triangles[20].vertex[0], ball.triangles[20].vertex[1]);
    ball.positions.insert(ball.positions.begin(), {9, 9, 9});  // without triangles
    for (Triangle& t : ball.triangles)
        for (std::uint32_t& v : t.vertex) ++v;
    const FixedMesh fixed = fix_mesh(ball);
    EXPECT_EQ(fixed.done.rule, Inside::winding);
    EXPECT_EQ(fixed.done.turned_triangles, 1u);
    EXPECT_EQ(fixed.done.left_out_triangles, 1u);
    EXPECT_EQ(fixed.done.cap_triangles, 1u);
    EXPECT_EQ(fixed.mesh.positions, whole.positions);
    ASSERT_EQ(fixed.vertices.size(), whole.positions.size());
    for (std::uint32_t v = 0; v < fixed.vertices.size(); ++v) EXPECT_EQ(fixed.vertices[v], v + 1);
    expect_same_inside(fixed.mesh, whole, 0, "fixed");
    const FixedMesh again = fix_mesh(fixed.mesh);
    EXPECT_EQ(again.done.rule, Inside::closed);
    EXPECT_TRUE(same_triangles(again.mesh, fixed.mesh));
}

// Two holes: the large one is closed, and then the mesh has an inside.
TEST(FixMeshTest, SaysWhetherTheResultHasAnInside) {
    test::Random random(63);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    const MeshData whole = scenes::box({0, 0, 0}, {1, 1, 1});
    for (int i = 0; i < 2000; ++i) {
        MeshData mesh = whole;
        for (int k = random.integer(1, 3); k > 0; --k) {
            const auto at = static_cast<std::size_t>(
                random.integer(0, static_cast<int>(mesh.triangles.size()) - 1));
            Triangle& t = mesh.triangles[at];
            if (random.integer(0, 2) == 0) {
                // A new vertex on one of its sides.
                const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
                mesh.positions.push_back(
                    0.5f * (mesh.positions[t.vertex[0]] + mesh.positions[t.vertex[1]]));
                mesh.triangles.push_back({{middle, t.vertex[1], t.vertex[2]}});
                mesh.triangles[at].vertex[1] = middle;
            } else if (random.integer(0, 1) == 0) {
                std::swap(t.vertex[0], t.vertex[1]);
            } else {
                mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(at));
            }
        }
        const FixedMesh fixed = fix_mesh(mesh);
        const Mesh made("fixed", fixed.mesh);
        ASSERT_EQ(fixed.done.exists(), made.inside().exists()) << i;
    }
}

// Where holes are closed so that a mesh gets an inside, the last ones are closed, too.
TEST(FixMeshTest, WhatHasAnInsideIsClosed) {
    test::Random random(64);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int closed = 0;
    for (int i = 0; i < 600; ++i) {
        MeshData mesh = scenes::sphere(1, 1);
        const double share = random.uniform(0.05, 0.4);
        std::erase_if(mesh.triangles,
                      [&](const Triangle&) { return random.uniform(0, 1) < share; });
        for (Triangle& t : mesh.triangles)
            if (random.uniform(0, 1) < 0.1) std::swap(t.vertex[0], t.vertex[1]);
        const FixedMesh fixed = fix_mesh(mesh);
        const HalfEdges sides(fixed.mesh.triangles, fixed.mesh.positions.size());
        const bool is_closed = traits_of(fixed.mesh, sides, {}).closed();
        ASSERT_EQ(fixed.done.exists(), is_closed) << i;
        closed += is_closed;
        ASSERT_EQ(fixed.mesh.triangles.size(),
                  mesh.triangles.size() - fixed.done.left_out_triangles + fixed.done.cap_triangles)
            << i;
        for (std::size_t v = 0; v < fixed.vertices.size(); ++v)
            ASSERT_EQ(fixed.mesh.positions[v], mesh.positions[fixed.vertices[v]]) << i;
    }
    EXPECT_GT(closed, 200);
    EXPECT_LT(closed, 600);
}

TEST(FixMeshTest, SaysNothingWasDoneWhereNothingWouldBeLeft) {
    const MeshData flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 1}}, {{2, 2, 0}}}};
    const FixedMesh fixed = fix_mesh(flat);
    EXPECT_TRUE(same_triangles(fixed.mesh, flat));
    EXPECT_FALSE(fixed.done.exists());
    EXPECT_EQ(fixed.done.left_out_triangles, 0u);
    EXPECT_EQ(fixed.done.joined_vertices, 0u);
}

TEST(FixMeshTest, LeavesOpenMeshesOpenAndClosesTheirSmallHoles) {
    MeshData sheet = scenes::grid(1, 1, 20, 20);
    const std::size_t all = sheet.triangles.size();
    sheet.triangles.erase(sheet.triangles.begin() + 300);
    std::swap(sheet.triangles[100].vertex[0], sheet.triangles[100].vertex[1]);
    const FixedMesh fixed = fix_mesh(sheet);
    EXPECT_FALSE(fixed.done.exists());
    EXPECT_EQ(fixed.done.turned_triangles, 1u);
    EXPECT_EQ(fixed.done.holes, 1u);
    EXPECT_EQ(fixed.mesh.triangles.size(), all);
    EXPECT_THROW(fix_mesh({}), InputError);
    EXPECT_THROW(fix_mesh({{{0, 0, 0}}, {{{0, 1, 2}}}}), InputError);
}

TEST(MeshInsideTest, TheRuleDecides) {
    const MeshData box = scenes::box({0, 0, 0}, {1, 1, 1});
    MeshData open = box;
    open.triangles.pop_back();
    const auto rule = [](const MeshData& mesh, Inside inside) {
        const Mesh made("mesh", mesh, {.inside = inside});
        EXPECT_EQ(made.view().closed, made.inside().exists());
        EXPECT_EQ(made.data().triangles, mesh.triangles);
        return made.inside().rule;
    };
    EXPECT_EQ(rule(box, Inside::automatic), Inside::closed);
    EXPECT_EQ(rule(box, Inside::closed), Inside::closed);
    EXPECT_EQ(rule(box, Inside::winding), Inside::winding);
    EXPECT_EQ(rule(box, Inside::none), Inside::none);
    EXPECT_EQ(rule(open, Inside::automatic), Inside::winding);
    EXPECT_EQ(rule(open, Inside::closed), Inside::none);
    EXPECT_EQ(rule(open, Inside::none), Inside::none);
    const Mesh made("open", open);
    EXPECT_EQ(made.triangles().size(), 12u);
    EXPECT_EQ(made.given_triangle(3), 3u);
    EXPECT_EQ(made.given_triangle(11), no_triangle);
    for (const Inside inside : {Inside::automatic, Inside::closed, Inside::winding, Inside::none})
        EXPECT_EQ(inside_named(name(inside)), inside);
    EXPECT_EQ(inside_named("solid"), std::nullopt);
    EXPECT_NE(describe(made.inside()).find("1 hole closed by 1 triangle"), std::string::npos);
}

/// Caps by all triangulations.
double least_area(const std::vector<Vec3d>& loop, std::size_t i, std::size_t j) {
    if (j < i + 2) return 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = i + 1; k < j; ++k)
        least = std::min(least, least_area(loop, i, k) + least_area(loop, k, j) +
                                    0.5 * length(cross(loop[k] - loop[i], loop[j] - loop[i])));
    return least;
}

TEST(CapsTest, AreOfLeastAreaAndCloseTheSurface) {
    test::Random random(1);
    for (int round = 0; round < 50; ++round) {
        // A fan around a vertex: its border is a hole of as many edges.
        const int edges = random.integer(3, 9);
        MeshData fan;
        fan.positions.push_back({0, 0, 2});
        std::vector<Vec3d> loop;
        for (int i = 0; i < edges; ++i) {
            const double angle = 2 * std::numbers::pi * i / edges;
            fan.positions.push_back(
                to_float(Vec3d{std::cos(angle), std::sin(angle), 0} + random.in_box(0.5)));
            fan.triangles.push_back({{0, static_cast<std::uint32_t>(1 + i),
                                      static_cast<std::uint32_t>(1 + (i + 1) % edges)}});
        }
        for (int i = edges; i > 0; --i)
            loop.push_back(to_double(fan.positions[static_cast<std::size_t>(i)]));
        const std::vector<Cap> caps = caps_of(fan.positions, fan.triangles, mean_edge(fan));
        ASSERT_EQ(caps.size(), 1u);
        EXPECT_EQ(caps[0].border_edges, static_cast<std::uint32_t>(edges));
        EXPECT_NEAR(caps[0].area, least_area(loop, 0, loop.size() - 1), 1e-12);
        for (const Triangle& t : caps[0].triangles) fan.triangles.push_back(t);
        EXPECT_EQ(traits_of(fan).inconsistent_edges, 0u);
    }
}

TEST(CapsTest, CloseAnySurface) {
    test::Random random(2);
    for (int round = 0; round < 100; ++round) {
        MeshData mesh;
        const int vertices = random.integer(4, 60);
        for (int v = 0; v < vertices; ++v) mesh.positions.push_back(to_float(random.in_box(1)));
        const auto any = [&] {
            return static_cast<std::uint32_t>(random.integer(0, vertices - 1));
        };
        for (int t = 0; t < 200; ++t) {
            const Triangle one{{any(), any(), any()}};
            if (one.vertex[0] == one.vertex[1] || one.vertex[1] == one.vertex[2] ||
                one.vertex[2] == one.vertex[0])
                continue;
            mesh.triangles.push_back(one);
        }
        for (const Cap& cap : caps_of(mesh.positions, mesh.triangles, mean_edge(mesh)))
            mesh.triangles.insert(mesh.triangles.end(), cap.triangles.begin(), cap.triangles.end());
        EXPECT_EQ(traits_of(mesh).inconsistent_edges, 0u);
    }
}

TEST(WindingTreeTest, TreeAgreesWithTheSumOfSolidAngles) {
    const MeshData ball = scenes::sphere(1, 4);
    MeshData open = ball;
    open.triangles.resize(open.triangles.size() / 2);
    test::Random random(3);
    for (const MeshData* mesh : {&ball, static_cast<const MeshData*>(&open)}) {
        const WindingTree winding(mesh->positions, mesh->triangles);
        double sum = 0, worst = 0;
        constexpr int points = 300;
        for (int i = 0; i < points; ++i) {
            const Vec3d p = random.in_box(1.5);
            const double off = std::fabs(winding.at(p) - winding.exactly_at(p));
            sum += off;
            worst = std::max(worst, off);
        }
        EXPECT_LT(sum / points, 0.01);
        EXPECT_LT(worst, 0.06);
    }
    // On the surface it is the mean of both sides.
    const WindingTree winding(ball.positions, ball.triangles);
    for (std::uint32_t t = 0; t < ball.triangles.size(); t += 100) {
        Vec3d middle;
        for (std::uint32_t v : ball.triangles[t].vertex)
            middle += (1.0 / 3) * to_double(ball.positions[v]);
        EXPECT_NEAR(winding.exactly_at(middle, t), 0.5, 1e-6);
        EXPECT_NEAR(winding.at(middle, t), 0.5, 0.06);
    }
}

}  // namespace
}  // namespace pierce
