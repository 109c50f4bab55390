// Sheets against continuous collision by definition: every vertex and triangle, every two edges,
// tested one by one; and the hard cases that a single pose does not answer: 20, 24 and 25.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "core/geometry/closest_point.hpp"
#include "core/geometry/continuous.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/mesh_edges.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using scenes::joined;
using scenes::moved;

class SheetsTest : public testing::TestWithParam<test::NamedBackend> {
protected:
    World world_{GetParam().make()};
};

/// A flat sheet of `cells` by `cells` squares of side `cell`, its normals up.
MeshData flat(std::uint32_t cells, float cell, Vec3f corner) {
    MeshData mesh;
    for (std::uint32_t y = 0; y <= cells; ++y)
        for (std::uint32_t x = 0; x <= cells; ++x)
            mesh.positions.push_back(
                corner + Vec3f{cell * static_cast<float>(x), cell * static_cast<float>(y), 0});
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return y * (cells + 1) + x; };
    for (std::uint32_t y = 0; y < cells; ++y)
        for (std::uint32_t x = 0; x < cells; ++x) {
            mesh.triangles.push_back({{at(x, y), at(x + 1, y), at(x + 1, y + 1)}});
            mesh.triangles.push_back({{at(x, y), at(x + 1, y + 1), at(x, y + 1)}});
        }
    return mesh;
}

BodyId add_sheet(World& world, const MeshData& mesh, double thickness,
                 SelfCollision self = SelfCollision::on) {
    const BodyId body = world.add_deforming_body(world.add_mesh("sheet", mesh));
    world.set_collision(body, {self, true, thickness});
    return body;
}

std::span<const Contact> step(World& world, BodyId body, std::span<const Vec3f> from,
                              std::span<const Vec3f> to) {
    world.set_motion(body, from, to);
    world.detect();
    return world.contacts();
}

TEST_P(SheetsTest, LayersThatMoveTogetherDoNotMeet) {
    const MeshData mesh = joined(flat(4, 0.25f, {0, 0, 0}), flat(4, 0.25f, {0.03f, 0.02f, 0.1f}));
    const auto to = moved(mesh.positions, {0, 0, 0.2f});
    for (const SelfCollision how :
         {SelfCollision::on, SelfCollision::rays, SelfCollision::published}) {
        World world(GetParam().make());
        const BodyId body = add_sheet(world, mesh, 0.01, how);
        const auto contacts = step(world, body, mesh.positions, to);
        if (how == SelfCollision::published)
            EXPECT_GT(contacts.size(), 0u) << "with absolute velocities they do (hard case 25)";
        else
            EXPECT_EQ(contacts.size(), 0u);
    }
}

/// A sheet that is creased sharply: nothing meets, seen along the crease's middle, but its two
/// halves are near.
TEST_P(SheetsTest, TheHalvesOfACreaseAreNear) {
    MeshData rest = flat(4, 1, {-2, -2, 0});
    // Every second square is cut the other way, so that the stars on the crease reach far.
    for (std::uint32_t square = 0; square < 16; ++square) {
        const std::uint32_t x = square % 4, y = square / 4, at = y * 5 + x;
        if ((x + y) % 2 != 0) continue;
        rest.triangles[2 * square] = {{at, at + 1, at + 5}};
        rest.triangles[2 * square + 1] = {{at + 1, at + 6, at + 5}};
    }
    std::vector<Vec3f> creased = rest.positions;
    const double half = 0.17;  // radians
    for (Vec3f& p : creased) {
        const double x = static_cast<double>(p.x);
        if (x < 0) p.y += 0.3f;
        p.x = static_cast<float>(x * std::sin(half));
        p.z = static_cast<float>(std::fabs(x) * std::cos(half));
    }
    const double thickness = 0.5;
    const BodyId body = add_sheet(world_, rest, thickness);
    const auto contacts = step(world_, body, creased, creased);
    int near = 0;
    for (std::uint32_t v = 0; v < creased.size(); ++v)
        for (std::uint32_t t = 0; t < rest.triangles.size(); ++t) {
            const auto& vertex = rest.triangles[t].vertex;
            if (std::ranges::find(vertex, v) != std::end(vertex)) continue;
            const auto at = [](const std::vector<Vec3f>& positions, std::uint32_t w) {
                return to_double(positions[w]);
            };
            const Vec3d a = at(creased, vertex[0]), b = at(creased, vertex[1]),
                        c = at(creased, vertex[2]), p = at(creased, v), n = cross(b - a, c - a);
            const double first = dot(n, cross(c - b, p - b)), second = dot(n, cross(a - c, p - c)),
                         all = dot(n, n), clear = 1e-3 * all;
            if (first < clear || second < clear || first + second > all - clear) continue;
            const double distance = std::fabs(dot(n, p - a)) / std::sqrt(all);
            const Vec3d r = at(rest.positions, v);
            const double at_rest = length(r - closest_on_triangle(r, at(rest.positions, vertex[0]),
                                                                  at(rest.positions, vertex[1]),
                                                                  at(rest.positions, vertex[2])));
            if (distance > std::min(thickness, at_rest / 2) - 1e-3) continue;
            ++near;
            EXPECT_EQ(std::ranges::count_if(contacts,
                                            [&](const Contact& k) {
                                                return !k.is_edge() && k.vertex == v &&
                                                       k.triangle == t;
                                            }),
                      1)
                << "vertex " << v << " and triangle " << t << " are " << distance << " apart";
        }
    EXPECT_GT(near, 5);
}

/// The vertex of a sheet that comes out of a solid and stays nearer than the thickness.
TEST_P(SheetsTest, AVertexThatLeavesASolidIsNearInTheSameStep) {
    world_.add_fixed_body(world_.add_mesh("box", scenes::box({-1, -1, -1}, {1, 1, 1})));
    const MeshData mesh = {{{0.1f, 0.2f, 0.9f}, {0.3f, 5, 3}, {-0.3f, -5, 3}}, {{{0, 1, 2}}}};
    const BodyId body = add_sheet(world_, mesh, 0.1, SelfCollision::off);
    std::vector<Vec3f> outside = mesh.positions;
    outside[0].z = 1.01f;
    const auto heights = [&](std::span<const Contact> contacts) {
        std::vector<double> found;
        for (const Contact& c : contacts)
            if (!c.is_edge() && c.source_body() == body) found.push_back(c.distance);
        return found;
    };
    const std::vector<double> moving = heights(step(world_, body, mesh.positions, outside)),
                              still = heights(step(world_, body, outside, outside));
    ASSERT_EQ(still.size(), 1u);
    ASSERT_EQ(moving.size(), 1u);
    for (double height : moving) EXPECT_NEAR(height, 0.01, 1e-6);
}

/// What a vertex has been through is known however fast it goes on.
TEST_P(SheetsTest, AVertexThatSinksFastIsRemembered) {
    const BodyId ground = add_sheet(world_, flat(6, 1, {-3, -3, 0}), 0.1, SelfCollision::off);
    const MeshData spike = {{{0.1f, 0.2f, 0.05f}, {0.5f, 0.2f, 1}, {0.1f, 0.6f, 1}}, {{{0, 1, 2}}}};
    const BodyId body = add_sheet(world_, spike, 0.1, SelfCollision::off);
    world_.detect();
    std::vector<Vec3f> at = spike.positions;
    for (int k = 1; k <= 6; ++k) {
        at[0].z -= 0.12f;
        world_.set_positions(body, at);
        world_.detect();
        const auto deep = std::ranges::find_if(world_.contacts(), [&](const Contact& c) {
            return !c.is_edge() && c.source_body() == body && c.vertex == 0;
        });
        ASSERT_NE(deep, world_.contacts().end()) << k;
        EXPECT_EQ(deep->target_body(), ground);
        EXPECT_NEAR(deep->distance, 0.05 - 0.12 * k, 1e-5) << k;
    }
}

/// Whether boxes of bodies are apart, which hangs on how they lie, has nothing to do with it; how
/// deep it is has.
TEST_P(SheetsTest, WhatIsThroughIsRememberedUpToADepth) {
    const MeshData ground = flat(4, 0.5f, {-1, -1, 0}), small = flat(2, 0.2f, {-0.13f, -0.17f, 0});
    for (const Temporal temporal : {Temporal::off, Temporal::paper, Temporal::certified})
        for (const double tilt : {0.0, 0.5})
            for (const bool is_sheet : {false, true})
                for (const float depth : {0.2f, 1.0f, 1.2f}) {
                    SCOPED_TRACE("tilt " + std::to_string(tilt) + ", depth " +
                                 std::to_string(depth));
                    World world(GetParam().make(), {.temporal = temporal});
                    const auto tilted = [&](std::vector<Vec3f> points, float height) {
                        for (Vec3f& p : points) {
                            const double x = p.x, z = p.z + height;
                            p = to_float({x * std::cos(tilt) - z * std::sin(tilt), p.y,
                                          x * std::sin(tilt) + z * std::cos(tilt)});
                        }
                        return points;
                    };
                    const MeshData turned{tilted(ground.positions, 0), ground.triangles};
                    if (is_sheet)
                        add_sheet(world, turned, 0.05, SelfCollision::off);
                    else
                        world.add_fixed_body(world.add_mesh("ground", turned));
                    const BodyId body = add_sheet(
                        world, {tilted(small.positions, 0.1f), small.triangles}, 0.05);
                    world.detect();
                    const auto vertices = [&](float height) {
                        world.set_positions(body, tilted(small.positions, height));
                        world.detect();
                        std::vector<Contact> found;
                        for (const Contact& c : world.contacts())
                            if (!c.is_edge() && c.source_body() == body) found.push_back(c);
                        return found;
                    };
                    ASSERT_EQ(vertices(-depth).size(), 9u);
                    // The mean edge of the ground is 0.57 long, and two of them are remembered.
                    for (int k = 0; k < 2; ++k)
                        EXPECT_EQ(vertices(-depth).size(), depth < 1.1f ? 9u : 0u);
                    for (const Contact& c : vertices(-0.02f)) {
                        EXPECT_EQ(c.found, depth < 1.1f ? Found::remembered : Found::near);
                        EXPECT_NEAR(c.distance, depth < 1.1f ? -0.02 : 0.02, 1e-6);
                    }
                }
}

/// A sheet that is thicker than what is remembered beyond its thickness.
TEST_P(SheetsTest, WhatIsWithinTheThicknessIsRememberedHoweverFineTheMeshIs) {
    const MeshData ground = flat(20, 0.01f, {-0.1f, -0.1f, 0}),
                   small = flat(2, 0.01f, {0, 0, 0.2f});
    add_sheet(world_, ground, 0.1, SelfCollision::off);
    const BodyId body = add_sheet(world_, small, 0.1, SelfCollision::off);
    world_.detect();
    for (int k = 0; k < 3; ++k) {
        world_.set_positions(body, moved(small.positions, {0, 0, -0.25f}));
        world_.detect();
        int vertices = 0;
        for (const Contact& c : world_.contacts()) {
            if (c.is_edge() || c.source_body() != body) continue;
            ++vertices;
            EXPECT_NEAR(c.distance, -0.05, 1e-6) << "step " << k;
            EXPECT_NEAR(std::fabs(c.normal.z), 1, 1e-9);
        }
        EXPECT_GE(vertices, 9) << "step " << k;
    }
}

TEST_P(SheetsTest, AnEndlessMemoryIsOneAsFarAsBodiesCanBe) {
    const MeshData ground = flat(4, 0.5f, {-1, -1, 0}),
                   small = flat(2, 0.2f, {-0.13f, -0.17f, 0.1f});
    for (const double range : {1e39, std::numeric_limits<double>::infinity()}) {
        World world(GetParam().make(), {.open_body_range = range});
        add_sheet(world, ground, 0.05, SelfCollision::off);
        const BodyId body = add_sheet(world, small, 0.05);
        world.detect();
        for (int k = 0; k < 3; ++k) {
            world.set_positions(body, moved(small.positions, {0, 0, -50}));
            world.detect();
            EXPECT_EQ(std::ranges::count_if(world.contacts(),
                                            [&](const Contact& c) {
                                                return !c.is_edge() && c.source_body() == body;
                                            }),
                      9)
                << range << ", step " << k;
        }
    }
}

/// A side that is known stays known when something changes that has nothing to do with it.
TEST_P(SheetsTest, SidesOutlastChangesOfMarginsAndOfOtherPairs) {
    // A sheet goes down over the tip of a solid.
    const MeshData spike = {{{0, 0, 1}, {1, 0, -1}, {-0.5f, 0.9f, -1}, {-0.5f, -0.9f, -1}},
                            {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{1, 3, 2}}}};
    const BodyId solid = world_.add_fixed_body(world_.add_mesh("spike", spike));
    const MeshData mesh = flat(1, 4, {-1.7f, -2, 1.05f});
    const BodyId body = add_sheet(world_, mesh, 0.1, SelfCollision::off);
    world_.detect();
    world_.set_positions(body, moved(mesh.positions, {0, 0, -0.1f}));
    world_.detect();
    for (const auto& [margin, self] :
         {std::pair(-1.0, SelfCollision::off), std::pair(0.01, SelfCollision::off),
          std::pair(0.01, SelfCollision::on)}) {
        world_.set_collision(solid, {.margin = margin});
        world_.set_collision(body, {self, true, 0.1});
        world_.detect();
        const auto c = std::ranges::find_if(world_.contacts(), [&](const Contact& found) {
            return !found.is_edge() && found.source_body() == solid && found.vertex == 0;
        });
        ASSERT_NE(c, world_.contacts().end());
        EXPECT_EQ(c->found, Found::remembered);
        EXPECT_LT(c->distance, 0);
    }
}

TEST_P(SheetsTest, AVertexThatPassesThroughAPlateInOneStepIsReported) {
    // Hard case 24: from z = 1 to z = -1 through abs(z) <= 0.005.
    const BodyId plate = world_.add_fixed_body(
        world_.add_mesh("plate", scenes::box({-1, -1, -0.005f}, {1, 1, 0.005f})));
    const MeshData mesh = flat(1, 0.1f, {0.03f, 0.02f, 1});
    const BodyId body = add_sheet(world_, mesh, 0);
    std::set<std::uint32_t> met;
    for (const Contact& c : step(world_, body, mesh.positions, moved(mesh.positions, {0, 0, -2}))) {
        EXPECT_EQ(c.a, plate);
        EXPECT_EQ(c.b, body);
        EXPECT_EQ(c.found, Found::crossing);
        if (c.is_edge() || c.source != Side::b) continue;
        EXPECT_NEAR(c.time, 0.4975, 1e-5) << "entering at the top";
        EXPECT_NEAR(c.normal.z, 1, 1e-12) << "from the plate to the sheet: up, where it came from";
        EXPECT_NEAR(c.distance, -1.005, 1e-6);
        met.insert(c.vertex);
    }
    EXPECT_EQ(met.size(), mesh.positions.size());
}

TEST_P(SheetsTest, ASpokeThatLeansOverTheBorderOfItsFanIsNear) {
    // The middle of four triangles passes close to the border, and a spoke leans over it.
    constexpr float half = 0.15339f;
    const MeshData fan{{{-half, 0, 0}, {0, -half, 0}, {0, 0, 0}, {0, half, 0}, {half, 0, 0}},
                       {{{1, 2, 0}}, {{0, 2, 3}}, {{1, 4, 2}}, {{2, 4, 3}}}};
    const std::vector<Vec3f> bent{{1.99116464f, -0.592964469f, 1.99552486f},
                                  {1.97823951f, -0.538289954f, 2.0565067f},
                                  {2.06859387f, -0.50237251f, 1.95300521f},
                                  {2.27439613f, -0.441026612f, 1.97235518f},
                                  {1.99158932f, -0.145890401f, 1.9399866f}};
    const auto at = [&](std::size_t v) { return to_double(bent[v]); };
    const double apart = segment_distance(at(0), at(3), at(1), at(2));
    EXPECT_NEAR(apart, 0.04687, 1e-5);
    const BodyId body = add_sheet(world_, fan, 0.0518);
    const std::span<const Contact> contacts = step(world_, body, bent, bent);
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_TRUE(contacts[0].is_edge());
    EXPECT_NEAR(contacts[0].distance, apart, 1e-6);
}

TEST_P(SheetsTest, ASheetInsideASolidIsPushedOutTheShortWayWhicheverWayItFaces) {
    // Hard case 20: at z = 0.98 in the unit cube.
    for (const bool faces_up : {true, false}) {
        World world(GetParam().make());
        world.add_fixed_body(world.add_mesh("cube", scenes::box({0, 0, 0}, {1, 1, 1})));
        MeshData mesh = flat(1, 0.125f, {1.0f / 3, 0.25f, 0.98f});
        if (!faces_up)
            for (Triangle& t : mesh.triangles) std::swap(t.vertex[1], t.vertex[2]);
        add_sheet(world, mesh, 0);
        world.detect();
        ASSERT_EQ(world.contacts().size(), mesh.positions.size());
        for (const Contact& c : world.contacts()) {
            EXPECT_NEAR(c.penetration_depth(), 1 - static_cast<double>(0.98f), 1e-9);
            EXPECT_NEAR(c.normal.z, 1, 1e-9) << "from the cube to the sheet";
        }
    }
}

TEST_P(SheetsTest, AVertexIsPushedBackToTheSideItCameFromUntilItIsThere) {
    const MeshData mesh = joined(flat(4, 0.25f, {-0.5f, -0.5f, 0}),
                                 flat(1, 0.05f, {0.02f, 0.15f, 0.2f}));
    const BodyId body = add_sheet(world_, mesh, 0.02);
    std::vector<Vec3f> now = mesh.positions;
    const auto lower_by = [&](float dz) {
        std::vector<Vec3f> next = now;
        for (std::size_t v = 25; v < next.size(); ++v) next[v] = next[v] + Vec3f{0.01f, 0, dz};
        world_.set_positions(body, next);
        now = next;
        world_.detect();
        std::vector<Contact> vertices;
        for (const Contact& c : world_.contacts())
            if (!c.is_edge() && c.vertex >= 25) vertices.push_back(c);
        return vertices;
    };
    EXPECT_TRUE(lower_by(-0.1f).empty()) << "0.1 above";
    for (const Contact& c : lower_by(-0.15f)) {  // 0.05 below
        EXPECT_EQ(c.found, Found::crossing);
        EXPECT_NEAR(c.distance, -0.05, 1e-5);
        EXPECT_NEAR(c.time, 2.0 / 3, 1e-4);
        EXPECT_NEAR(c.normal.z, -1, 1e-6)
            << "from the vertex' body, a, to b: away from where the vertex belongs";
        EXPECT_EQ(c.age, 0u);
    }
    for (int k = 0; k < 3; ++k) {
        const auto contacts = lower_by(-0.005f);
        ASSERT_EQ(contacts.size(), 4u) << "still through, deeper than the thickness";
        for (const Contact& c : contacts) {
            EXPECT_EQ(c.found, Found::remembered);
            EXPECT_NEAR(c.distance, -0.055 - 0.005 * k, 1e-5);
            EXPECT_NEAR(c.normal.z, -1, 1e-6);
        }
    }
    const auto back = lower_by(0.075f);
    ASSERT_EQ(back.size(), 4u);
    for (const Contact& c : back) {
        EXPECT_NEAR(c.distance, 0.01, 1e-5) << "back above";
        EXPECT_NEAR(c.normal.z, -1, 1e-6);
    }
    for (const Contact& c : lower_by(0.001f)) EXPECT_EQ(c.found, Found::near);
    EXPECT_TRUE(lower_by(0.1f).empty());
}

TEST_P(SheetsTest, AVertexThatPassesOneTriangleAndEndsOverItsNeighborBelongsOnTheSideItCameFrom) {
    // From above the cell (0, 0) to below the cell (1, 0): through one triangle, and then close to
    // another one.
    MeshData mesh = joined(flat(4, 0.25f, {0, 0, 0}), flat(1, 0.01f, {0.2f, 0.05f, 0.1f}));
    const BodyId body = add_sheet(world_, mesh, 0.02);
    std::vector<Vec3f> to = mesh.positions;
    for (std::size_t v = 25; v < to.size(); ++v) to[v] += Vec3f{0.053f, 0, -0.11f};
    std::set<std::uint32_t> crossing, near;
    for (const Contact& c : step(world_, body, mesh.positions, to)) {
        if (c.is_edge() || c.vertex < 25) continue;
        EXPECT_NEAR(c.distance, -0.01, 1e-6);
        EXPECT_NEAR(c.normal.z, -1, 1e-6) << "from the vertex to the triangle: it belongs above";
        (c.found == Found::crossing ? crossing : near).insert(c.vertex);
    }
    EXPECT_GT(near.size(), 0u) << "some end over a triangle that they do not meet";
    EXPECT_EQ(crossing.size(), 4u);
    // Around the border it is another matter.
    for (std::size_t v = 25; v < to.size(); ++v) {
        mesh.positions[v].y -= 0.3f;
        to[v].y -= 0.04f;
    }
    World fresh(GetParam().make());
    for (const Contact& c : step(fresh, add_sheet(fresh, mesh, 0.02), mesh.positions, to)) {
        EXPECT_NE(c.found, Found::remembered);
        if (c.is_edge() || c.vertex < 25 || c.found == Found::crossing) continue;
        EXPECT_NEAR(c.distance, 0.01, 1e-6) << "it came from outside, below";
        EXPECT_NEAR(c.normal.z, 1, 1e-6);
    }
}

TEST_P(SheetsTest, WhatStartsTangledHasADirectionOrSaysSo) {
    // A vertical sheet half through a flat one, since nobody knows when.
    MeshData upright = flat(2, 0.1f, {0, 0, 0});
    for (Vec3f& p : upright.positions) p = {p.x + 0.31f, 0.13f, p.y - 0.07f};
    const MeshData mesh = joined(flat(4, 0.25f, {0, 0, 0}), upright);
    add_sheet(world_, mesh, 0.001);
    world_.detect();
    ASSERT_GT(world_.stats().tangled, 0u);
    std::uint32_t tangled = 0;
    for (const Contact& c : world_.contacts()) {
        if (c.found != Found::tangled) continue;
        ++tangled;
        EXPECT_TRUE(c.is_edge());
        EXPECT_NEAR(length(c.normal), 1, 1e-12);
        EXPECT_NEAR(length(c.point_a - c.point_b), 0, 1e-7) << "where the edge runs through";
    }
    EXPECT_EQ(tangled, world_.stats().tangled);
}

// A pin through the middle of a triangle has no vertex and no edge of the sheet inside, and no ray
// or chord finds it.
TEST_P(SheetsTest, ASolidThatIsThroughTheMiddleOfATriangleIsTangled) {
    const MeshData pin = scenes::box({0.6, 0.2, -1}, {0.7, 0.3, 1}), sheet = flat(1, 1, {0, 0, 0});
    for (const Motion motion : {Motion::fixed, Motion::rigid, Motion::deforming})
        for (const bool pin_comes_first : {true, false}) {
            World world(GetParam().make());
            const auto add_pin = [&] {
                const MeshId mesh = world.add_mesh("pin", pin);
                return motion == Motion::fixed   ? world.add_fixed_body(mesh)
                       : motion == Motion::rigid ? world.add_rigid_body(mesh)
                                                 : world.add_deforming_body(mesh);
            };
            if (pin_comes_first) add_pin();
            add_sheet(world, sheet, 0.01);
            if (!pin_comes_first) add_pin();
            for (int step = 0; step < 3; ++step) {
                world.detect();
                EXPECT_EQ(world.stats().tangled, 8u) << "long edges, and diagonals of faces";
                EXPECT_EQ(world.contacts().size(), 8u);
                for (const Contact& c : world.contacts()) {
                    EXPECT_TRUE(c.is_edge());
                    EXPECT_EQ(c.source == Side::a, pin_comes_first);
                    EXPECT_NEAR(c.point_a.z, 0, 1e-6);
                }
            }
        }
    // Where the sheet's border is inside the solid, edges of the sheet are found instead.
    World world(GetParam().make());
    world.add_fixed_body(world.add_mesh("wide", scenes::box({0.6, -1, -1}, {0.7, 2, 1})));
    add_sheet(world, sheet, 0.01);
    world.detect();
    EXPECT_EQ(world.stats().tangled, 0u);
    EXPECT_FALSE(world.contacts().empty());
}

TEST_P(SheetsTest, WhatIsRefused) {
    const BodyId rigid = world_.add_rigid_body(
        world_.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1})));
    EXPECT_THROW(world_.set_collision(rigid, {SelfCollision::on, true, 0}), InputError);
    const BodyId open = world_.add_deforming_body(world_.add_mesh("sheet", flat(1, 1, {})));
    EXPECT_THROW(world_.set_collision(open, {SelfCollision::on, false, 0}), InputError)
        << "no inside";
    EXPECT_THROW(world_.set_collision(open, {SelfCollision::on, true, -1}), InputError);
    EXPECT_THROW(world_.set_collision(open, {SelfCollision::off, false, 1}), InputError);
    EXPECT_NO_THROW(world_.set_collision(open, {SelfCollision::on, true, 0.1}));
    const BodyId closed = world_.add_deforming_body(
        world_.add_mesh("solid", scenes::box({0, 0, 0}, {1, 1, 1})));
    EXPECT_THROW(world_.set_collision(closed, {SelfCollision::rays, false, 0}), InputError);
    EXPECT_NO_THROW(world_.set_collision(closed, {SelfCollision::on, false, 0}));
}

/// Two features that meet during a step: kind (0: vertex and triangle, 1: edges), bodies and
/// features.
using Meeting = std::tuple<int, std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t>;

struct Moving {
    const Mesh* mesh;
    std::vector<Vec3f> start, end;

    MovingPoint at(std::uint32_t v) const { return {to_double(start[v]), to_double(end[v])}; }
};

/// All meetings of the bodies with themselves and each other, by definition.
std::set<Meeting> all_meetings(const std::vector<Moving>& bodies) {
    std::set<Meeting> all;
    Impact impact;
    for (std::uint32_t a = 0; a < bodies.size(); ++a)
        for (std::uint32_t b = 0; b < bodies.size(); ++b) {
            const auto edges_a = bodies[a].mesh->view().edges,
                       edges_b = bodies[b].mesh->view().edges;
            for (std::uint32_t v = 0; v < bodies[a].start.size(); ++v)
                for (std::uint32_t t = 0; t < bodies[b].mesh->triangles().size(); ++t) {
                    const Triangle& tri = bodies[b].mesh->triangles()[t];
                    if (a == b && has_vertex(tri, v)) continue;
                    if (vertex_meets_face(bodies[a].at(v), bodies[b].at(tri.vertex[0]),
                                          bodies[b].at(tri.vertex[1]), bodies[b].at(tri.vertex[2]),
                                          impact))
                        all.insert({0, a, v, b, t});
                }
            if (a > b) continue;
            for (std::uint32_t e = 0; e < edges_a.size; ++e)
                for (std::uint32_t f = a == b ? e + 1 : 0; f < edges_b.size; ++f) {
                    const auto &p = edges_a[e].vertex, &q = edges_b[f].vertex;
                    if (a == b && (p[0] == q[0] || p[0] == q[1] || p[1] == q[0] || p[1] == q[1]))
                        continue;
                    if (edges_meet(bodies[a].at(p[0]), bodies[a].at(p[1]), bodies[b].at(q[0]),
                                   bodies[b].at(q[1]), impact))
                        all.insert({1, a, e, b, f});
                }
        }
    return all;
}

/// What has met during the step, as its contacts say.
std::set<Meeting> crossings(const World& world) {
    std::set<Meeting> found;
    for (const Contact& c : world.contacts()) {
        const std::uint32_t source = c.source_body().index, target = c.target_body().index;
        if (c.found != Found::crossing) continue;
        EXPECT_TRUE(found
                        .insert(c.is_edge() ? Meeting{1, source, c.edge, target, c.other_edge}
                                            : Meeting{0, source, c.vertex, target, c.triangle})
                        .second)
            << "twice";
    }
    return found;
}

TEST_P(SheetsTest, NothingThatMeetsDuringAStepIsMissedAndNothingElseCrosses) {
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        World world(GetParam().make());
        // Two crumpled sheets, one of two layers, that move wildly.
        const MeshData first = joined(flat(3, 0.3f, {0, 0, 0}),
                                      flat(2, 0.4f, {0.1f, 0.05f, 0.12f})),
                       second = flat(3, 0.3f, {0.05f, -0.04f, 0.2f});
        std::vector<Moving> bodies;
        std::vector<BodyId> ids;
        for (const MeshData* mesh : {&first, &second}) {
            ids.push_back(add_sheet(world, *mesh, 0.02));
            Moving m{&world.mesh(world.mesh_of(ids.back())), mesh->positions, mesh->positions};
            const auto shake = [&](Vec3f p, double by) {
                return p + to_float(by * Vec3d{random.uniform(-1, 1), random.uniform(-1, 1),
                                               random.uniform(-1, 1)});
            };
            for (Vec3f& p : m.start) p = shake(p, 0.04);
            for (std::size_t v = 0; v < m.end.size(); ++v) m.end[v] = shake(m.start[v], 0.12);
            world.set_motion(ids.back(), m.start, m.end);
            bodies.push_back(std::move(m));
        }
        world.detect();
        const std::set<Meeting> expected = all_meetings(bodies);
        EXPECT_GT(expected.size(), 10u);
        EXPECT_EQ(crossings(world), expected);

        World reference(reference_backend());
        for (std::size_t b = 0; b < bodies.size(); ++b) {
            reference.set_motion(add_sheet(reference, b == 0 ? first : second, 0.02),
                                 bodies[b].start, bodies[b].end);
        }
        reference.detect();
        EXPECT_EQ(contact_hash(world.contacts()), contact_hash(reference.contacts()));
    }
}

TEST_P(SheetsTest, ASheetMeetsASolidThatDeforms) {
    // A ball that bends comes up through a sheet that sinks into it. They begin apart, so that
    // everything comes from outside.
    const MeshData sheet = flat(5, 0.2f, {-0.5f, -0.45f, 0}), ball = scenes::sphere(0.3, 2);
    World reference(reference_backend());
    std::vector<Moving> bodies;
    for (World* world : {&reference, &world_}) {
        bodies.clear();
        const BodyId ids[] = {add_sheet(*world, sheet, 0.02, SelfCollision::off),
                              world->add_deforming_body(world->add_mesh("ball", ball))};
        bodies.push_back({&world->mesh(world->mesh_of(ids[0])), sheet.positions, sheet.positions});
        bodies.push_back({&world->mesh(world->mesh_of(ids[1])), ball.positions, ball.positions});
        for (Vec3f& p : bodies[0].end) p.z -= 0.05f + 0.1f * p.x * p.x;
        for (Vec3f& p : bodies[1].start) p.z -= 0.35f;
        for (Vec3f& p : bodies[1].end) p = {1.1f * p.x + 0.3f * p.z * p.z, p.y, p.z};
        for (int b = 0; b < 2; ++b) world->set_motion(ids[b], bodies[b].start, bodies[b].end);
        world->detect();
    }
    const std::set<Meeting> expected = all_meetings(bodies);
    EXPECT_GT(expected.size(), 100u);
    EXPECT_EQ(crossings(world_), expected);
    EXPECT_EQ(contact_hash(world_.contacts()), contact_hash(reference.contacts()));
}

TEST_P(SheetsTest, SheetsOfSeveralSectionsAreSearchedWhole) {
    // 6272 triangles each, where a section has 4096; every vertex against every triangle of the
    // other, by definition.
    constexpr double thickness = 0.04, doubt = 1e-9;
    test::Random random(12);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::vector<MeshData> sheets;
    std::vector<BodyId> bodies;
    for (int s = 0; s < 2; ++s) {
        sheets.push_back(flat(56, 0.1f,
                              {0.03f * static_cast<float>(s), 0.02f * static_cast<float>(s),
                               0.042f * static_cast<float>(s)}));
        for (Vec3f& p : sheets.back().positions) p.z += static_cast<float>(random.uniform(0, 0.02));
        bodies.push_back(add_sheet(world_, sheets.back(), thickness, SelfCollision::off));
        world_.set_motion(bodies.back(), sheets.back().positions, sheets.back().positions);
    }
    world_.detect();
    std::set<std::tuple<int, std::uint32_t, std::uint32_t>> found;
    for (const Contact& c : world_.contacts())
        if (!c.is_edge()) found.insert({static_cast<int>(c.source), c.vertex, c.triangle});

    std::size_t expected = 0, doubtful = 0;
    for (int side = 0; side < 2; ++side) {
        const MeshData &from = sheets[static_cast<std::size_t>(side)],
                       &onto = sheets[static_cast<std::size_t>(1 - side)];
        for (std::uint32_t t = 0; t < onto.triangles.size(); ++t) {
            Vec3d corner[3];
            for (int k = 0; k < 3; ++k)
                corner[k] = to_double(onto.positions[onto.triangles[t].vertex[k]]);
            const Vec3d n = cross(corner[1] - corner[0], corner[2] - corner[0]);
            for (std::uint32_t v = 0; v < from.positions.size(); ++v) {
                const Vec3d p = to_double(from.positions[v]);
                double inside = thickness - std::fabs(dot(normalized(n), p - corner[0]));
                if (inside < -doubt) continue;
                for (int k = 0; k < 3; ++k)
                    inside = std::min(
                        inside,
                        dot(n, cross(corner[(k + 1) % 3] - corner[k], p - corner[k])) / dot(n, n));
                const bool has = found.contains({side, v, t});
                if (std::fabs(inside) < doubt) {
                    doubtful += has;
                    continue;
                }
                ASSERT_EQ(has, inside > 0)
                    << "side " << side << ", vertex " << v << ", triangle " << t;
                expected += has;
            }
        }
    }
    EXPECT_EQ(found.size(), expected + doubtful);
    // What the step says of itself is what its contacts add up to.
    const auto contacts = world_.contacts();
    const StepStats& stats = world_.stats();
    EXPECT_EQ(stats.contacts, contacts.size());
    EXPECT_EQ(stats.touching_pairs, 1u);
    EXPECT_EQ(stats.self_contacts, 0u);
    EXPECT_EQ(stats.crossings, 0u);
    EXPECT_EQ(stats.edge_contacts, std::ranges::count_if(contacts, &Contact::is_edge));
    EXPECT_GT(expected, 1000u);
    EXPECT_LT(expected, 6000u) << "some are too far apart";
}

TEST_P(SheetsTest, ASheetMeetsRigidBodiesThatMove) {
    const MeshData mesh = flat(6, 0.2f, {-0.6f, -0.6f, 0});
    const BodyId body = add_sheet(world_, mesh, 0.02, SelfCollision::off);
    const BodyId ball = world_.add_rigid_body(
        world_.add_mesh("box", scenes::box({-0.1f, -0.1f, -0.1f}, {0.1f, 0.1f, 0.1f})),
        {{0.03, 0.04, 0.3}, {}});
    world_.detect();
    EXPECT_EQ(world_.contacts().size(), 0u);
    world_.set_pose(ball, {{0.03, 0.04, -0.5}, {0.1, 0.2, 0, 1}});
    world_.detect();
    std::set<std::uint32_t> corners;
    for (const Contact& c : world_.contacts()) {
        EXPECT_EQ(c.a, body);
        if (c.found == Found::crossing && !c.is_edge() && c.source == Side::b) {
            corners.insert(c.vertex);
            EXPECT_NEAR(c.normal.z, 1, 1e-6) << "from the sheet to the box that came from above";
            EXPECT_LT(c.distance, 0);
        }
    }
    EXPECT_EQ(corners.size(), 8u) << "all corners of the box went through";
}

INSTANTIATE_TEST_SUITE_P(Backends, SheetsTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
