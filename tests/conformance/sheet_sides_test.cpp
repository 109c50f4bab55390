// On which side of a sheet a vertex or an edge belongs: after it has touched, after it has gone
// through a triangle beside the one it ends over, and where a sheet is folded.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"

namespace pierce {
namespace {

class SheetSidesTest : public testing::TestWithParam<test::NamedBackend> {
protected:
    BodyId add(const MeshData& mesh, double thickness, std::span<const Vec3f> positions = {}) {
        const BodyId body = world_.add_deforming_body(
            world_.add_mesh("sheet", mesh, {.inside = Inside::none}), positions);
        world_.set_collision(body, {.sheet = true, .thickness = thickness});
        return body;
    }
    /// The world after a step in which a body goes to its mesh moved by `way`.
    std::span<const Contact> step(BodyId body, const MeshData& mesh, Vec3f way) {
        world_.set_positions(body, scenes::moved(mesh.positions, way));
        world_.detect();
        return world_.contacts();
    }

    World world_{GetParam().make()};
};

/// A triangle that stands on its first corner.
MeshData tip() { return {{{0, 0, 0}, {0.05f, 0, 1}, {0, 0.05f, 1}}, {{{0, 1, 2}}}}; }

/// Where the first vertex of `tip` belongs, seen from a triangle: up is positive.
double up(const Contact& c) { return c.source == Side::a ? -c.normal.z : c.normal.z; }

bool is_of_tip(const Contact& c, BodyId tip) {
    return !c.is_edge() && c.source_body() == tip && c.vertex == 0;
}

TEST_P(SheetSidesTest, WhatHasTouchedBelongsWhereItCameFrom) {
    for (const double side : {1.0, -1.0})
        for (const double thickness : {0.0, 0.1})
            for (const float away : {0.02f, 0.3f}) {
                world_ = World(GetParam().make());
                // Edges cross between their ends, and vertices end in triangles.
                const MeshData floor = scenes::grid(2, 2, 3, 3), sheet = scenes::grid(1, 1, 2, 2);
                add(floor, thickness);
                const float s = static_cast<float>(side);
                const auto at = [s](float z) { return Vec3f{0.11f, 0.07f, s * z}; };
                const BodyId body = add(sheet, thickness,
                                        scenes::moved(sheet.positions, at(0.05f)));
                world_.detect();
                for (const float z : {0.04f, 0.0f, 0.0f}) step(body, sheet, at(z));
                EXPECT_GT(world_.stats().edge_contacts, 0u);
                EXPECT_GT(world_.contacts().size(), world_.stats().edge_contacts);
                for (const Contact& c : step(body, sheet, at(away))) {
                    EXPECT_GT(c.distance, 0) << "it is not through";
                    if (!c.is_edge()) {
                        EXPECT_GT((c.source_body() == body ? 1 : -1) * side * up(c), 0);
                    }
                }
                EXPECT_EQ(step(body, sheet, at(away)).empty(), away > thickness);
            }
}

TEST_P(SheetSidesTest, WhatASolverPutsOntoTheSheetIsBack) {
    const MeshData floor = scenes::grid(2, 2, 3, 3), sheet = tip();
    add(floor, 0);
    const BodyId body = add(sheet, 0, scenes::moved(sheet.positions, {0.1f, 0.2f, 0.3f}));
    world_.detect();
    const auto contacts_at = [&](float z) {
        std::vector<Contact> of_tip;
        for (const Contact& c : step(body, sheet, {0.1f, 0.2f, z}))
            if (is_of_tip(c, body)) of_tip.push_back(c);
        return of_tip;
    };
    ASSERT_EQ(contacts_at(-0.05f).size(), 1u);
    for (const Contact& c : contacts_at(0)) EXPECT_GT(up(c), 0);
    for (const Contact& c : contacts_at(0.05f)) EXPECT_GT(c.distance, 0);
    EXPECT_TRUE(contacts_at(0.1f).empty());
}

// Through one triangle of a hexagon to below another one, which shares only its middle with that.
TEST_P(SheetSidesTest, AVertexBelongsOnOneSideOfAllTrianglesAroundACorner) {
    MeshData hexagon{{{0, 0, 0}}, {}};
    for (std::uint32_t k = 0; k < 6; ++k) {
        const double angle = k * std::numbers::pi / 3;
        hexagon.positions.push_back(to_float(Vec3d{std::cos(angle), std::sin(angle), 0}));
        hexagon.triangles.push_back({{0, 1 + k, 1 + (k + 1) % 6}});
    }
    add(hexagon, 0.1);
    const BodyId body = add(tip(), 0.1, scenes::moved(tip().positions, {-0.1f, -0.05f, 0.02f}));
    world_.detect();
    int of_tip = 0;
    for (const Contact& c : step(body, tip(), {0.1f, 0.05f, -0.05f})) {
        if (!is_of_tip(c, body)) continue;
        ++of_tip;
        EXPECT_NEAR(c.distance, -0.05, 1e-6);
        EXPECT_GT(up(c), 0);
    }
    EXPECT_EQ(of_tip, 2) << "the triangle that it meets, and the one that it ends under";
}

// A vertex goes through both layers of a fold and slides on below: the order of triangles says
// nothing about its side of either layer.
TEST_P(SheetSidesTest, SidesInAFoldDoNotDependOnTheOrderOfTriangles) {
    std::array<Triangle, 4> fan{{{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 4}}, {{0, 4, 5}}}};
    std::array<int, 4> order{0, 1, 2, 3};
    do {
        world_ = World(GetParam().make());
        MeshData folded{{{0, 0, 0},
                         {1, -0.5f, 0},
                         {1, 0.5f, 0},
                         {0.3f, 1.2f, 0},
                         {0.9f, 0.45f, -0.1f},
                         {0.9f, -0.6f, -0.1f}},
                        {}};
        for (const int k : order) folded.triangles.push_back(fan[static_cast<std::size_t>(k)]);
        add(folded, 0.15);
        const BodyId body = add(tip(), 0.15, scenes::moved(tip().positions, {0.7f, 0, 0.2f}));
        world_.detect();
        step(body, tip(), {0.7f, 0, -0.2f});
        for (const float z : {-0.2f, -0.15f, -0.05f}) {
            int of_tip = 0;
            for (const Contact& c : step(body, tip(), {0.4f, 0.5f, z})) {
                if (!is_of_tip(c, body)) continue;
                ++of_tip;
                EXPECT_EQ(c.found, Found::remembered);
                EXPECT_GT(up(c), 0);
            }
            EXPECT_EQ(of_tip, 2);
        }
    } while (std::ranges::next_permutation(order).found);
}

INSTANTIATE_TEST_SUITE_P(Backends, SheetSidesTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
