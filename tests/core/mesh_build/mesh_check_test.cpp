// The mesh check: every defect is found, counted and placed, and sound meshes have none.
#include "pierce/mesh_check.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/mesh_build/self_intersections.hpp"
#include "pierce/error.hpp"
#include "scenes/named/shapes.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"

namespace pierce {

void PrintTo(const MeshFinding& f, std::ostream* out) {
    *out << name(f.kind) << ": " << f.count << testing::PrintToString(f.places);
}

bool operator==(const MeshFinding& f, const MeshFinding& g) {
    return f.kind == g.kind && f.count == g.count && f.places == g.places;
}

namespace {

using enum MeshDefect;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr MeshCheckOptions everything{.self_intersections = true};

std::vector<MeshFinding> findings_of(const MeshData& mesh) {
    return check_mesh(mesh, everything).findings;
}

MeshData unit_box() { return scenes::box({0, 0, 0}, {1, 1, 1}); }

void turn_around(MeshData& mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t.vertex[0], t.vertex[1]);
}

MeshData joined(MeshData mesh, const MeshData& other) {
    const auto offset = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (const Triangle& t : other.triangles)
        mesh.triangles.push_back(
            {{t.vertex[0] + offset, t.vertex[1] + offset, t.vertex[2] + offset}});
    return mesh;
}

void replace_vertex(MeshData& mesh, std::uint32_t from, std::uint32_t to) {
    for (Triangle& t : mesh.triangles) std::ranges::replace(t.vertex, from, to);
}

TEST(MeshCheckTest, SoundMeshesHaveNoFindings) {
    for (const MeshData& mesh : {unit_box(), scenes::torus(2, 0.5, 30, 10), scenes::sphere(3, 3)}) {
        const MeshReport report = check_mesh(mesh, everything);
        EXPECT_THAT(report.findings, IsEmpty());
        EXPECT_TRUE(report.sound());
        EXPECT_TRUE(report.closed);
        EXPECT_EQ(report.components, 1u);
        EXPECT_EQ(report.vertices, mesh.positions.size());
        EXPECT_EQ(report.triangles, mesh.triangles.size());
    }
    const MeshReport two = check_mesh(joined(unit_box(), scenes::box({2, 0, 0}, {3, 1, 4})),
                                      everything);
    EXPECT_TRUE(two.sound());
    EXPECT_EQ(two.components, 2u);
    EXPECT_NEAR(two.traits.volume, 5, 1e-12);
    EXPECT_EQ(two.box.lower, (Vec3d{0, 0, 0}));
    EXPECT_EQ(two.box.upper, (Vec3d{3, 1, 4}));
}

TEST(MeshCheckTest, NothingAtAll) {
    EXPECT_THAT(findings_of({}), ElementsAre(MeshFinding{no_triangles, 1, {}}));
    EXPECT_THAT(findings_of({{{0, 0, 0}}, {}}),
                ElementsAre(MeshFinding{no_triangles, 1, {}}, MeshFinding{unused_vertex, 1, {0}}));
    EXPECT_FALSE(check_mesh({}).closed);
}

TEST(MeshCheckTest, WhatNoWorldTakes) {
    MeshData far = unit_box(), small = unit_box();
    far.positions[3].y = 1e30f;
    for (Vec3f& p : small.positions)
        for (int k = 0; k < 3; ++k) p[k] *= 1e-30f;
    EXPECT_THAT(check_mesh(far, everything).findings, Contains(MeshFinding{out_of_range, 1, {3}}));
    const MeshReport report = check_mesh(small, everything);
    EXPECT_THAT(report.findings, Contains(MeshFinding{out_of_range, 8, {0, 1, 2, 3, 4, 5, 6, 7}}));
    EXPECT_FALSE(report.sound());
    EXPECT_THROW(Mesh("far", far), InputError);
    EXPECT_THROW(Mesh("small", small), InputError);
}

TEST(MeshCheckTest, NumbersThatAreNone) {
    MeshData mesh = unit_box();
    mesh.positions[3].y = nan;
    mesh.positions.push_back({std::numeric_limits<float>::infinity(), 0, 0});
    const MeshReport report = check_mesh(mesh, everything);
    EXPECT_THAT(report.findings, Contains(MeshFinding{not_finite, 2, {3, 8}}));
    EXPECT_THAT(report.findings, Contains(MeshFinding{unused_vertex, 1, {8}}));
    EXPECT_EQ(report.box.upper, (Vec3d{1, 1, 1}));
    EXPECT_TRUE(std::isfinite(report.traits.volume));
}

TEST(MeshCheckTest, IndicesOutOfRange) {
    MeshData mesh = unit_box();
    mesh.triangles[5] = {{0, 5, 99}};
    EXPECT_THAT(findings_of(mesh), ElementsAre(MeshFinding{bad_index, 1, {5}},
                                               MeshFinding{border_edge, 3, {0, 4, 0, 5, 4, 5}}));
    // What is left keeps the caller's ids.
    mesh.triangles.push_back({{1, 3, 3}});
    EXPECT_THAT(check_mesh(mesh).findings, Contains(MeshFinding{degenerate_triangle, 1, {12}}));
}

TEST(MeshCheckTest, Borders) {
    MeshData mesh = unit_box();
    mesh.triangles.pop_back();
    const MeshReport report = check_mesh(mesh, everything);
    EXPECT_THAT(report.findings, ElementsAre(MeshFinding{border_edge, 3, {1, 5, 1, 7, 5, 7}}));
    EXPECT_FALSE(report.closed);
    EXPECT_FALSE(report.sound());
}

TEST(MeshCheckTest, FlippedTriangle) {
    MeshData mesh = unit_box();
    std::swap(mesh.triangles[0].vertex[0], mesh.triangles[0].vertex[1]);
    EXPECT_THAT(findings_of(mesh), ElementsAre(MeshFinding{flipped_edge, 3, {0, 2, 0, 3, 2, 3}}));
    EXPECT_FALSE(check_mesh(mesh).closed);
}

TEST(MeshCheckTest, FinOnAnEdge) {
    MeshData mesh = unit_box();
    mesh.positions.push_back({0.5, -1, -1});
    mesh.triangles.push_back({{0, 1, 8}});
    EXPECT_THAT(findings_of(mesh), ElementsAre(MeshFinding{border_edge, 2, {0, 8, 1, 8}},
                                               MeshFinding{non_manifold_edge, 1, {0, 1}}));
}

TEST(MeshCheckTest, BoxesThatShareAnEdgeStayClosed) {
    MeshData mesh = joined(unit_box(), scenes::box({1, 1, 0}, {2, 2, 1}));
    replace_vertex(mesh, 8, 3);
    replace_vertex(mesh, 12, 7);
    const MeshReport report = check_mesh(mesh, everything);
    EXPECT_THAT(report.findings, Contains(MeshFinding{non_manifold_edge, 1, {3, 7}}));
    EXPECT_EQ(report.find(bowtie_vertex), nullptr);
    EXPECT_EQ(report.find(border_edge), nullptr);
    EXPECT_TRUE(report.closed);
}

TEST(MeshCheckTest, ComponentsInsideOut) {
    MeshData inverted = scenes::box({2, 0, 0}, {3, 1, 1});
    turn_around(inverted);
    EXPECT_THAT(findings_of(inverted), ElementsAre(MeshFinding{inside_out, 1, {0}}));
    EXPECT_THAT(findings_of(joined(unit_box(), inverted)),
                ElementsAre(MeshFinding{inside_out, 1, {12}}))
        << "beside a component as it should be";

    MeshData cavity = scenes::box({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75});
    turn_around(cavity);
    MeshData hollow = joined(cavity, unit_box());
    EXPECT_THAT(findings_of(hollow), IsEmpty());
    turn_around(hollow);
    EXPECT_THAT(findings_of(hollow), ElementsAre(MeshFinding{inside_out, 2, {0, 12}}))
        << "the wall of the cavity, too";

    // A part that overlaps another one, whichever of its triangles comes first.
    MeshData overlapping = scenes::box({0.9f, 0.1f, 0.1f}, {2, 0.9f, 0.9f});
    turn_around(overlapping);
    for (std::size_t first = 0; first < 12; ++first) {
        std::ranges::rotate(overlapping.triangles, overlapping.triangles.begin() + 1);
        EXPECT_THAT(findings_of(joined(unit_box(), overlapping)),
                    Contains(MeshFinding{inside_out, 1, {12}}));
    }

    // The wall of a cavity stays one where the surface around it lacks a triangle.
    MeshData cracked = joined(cavity, unit_box());
    cracked.triangles.pop_back();
    EXPECT_EQ(check_mesh(cracked, everything).find(inside_out), nullptr);
}

/// A box one of whose edges, 0-1, is split on one side only, and closed by a triangle without area.
MeshData box_with_sliver() {
    MeshData mesh = unit_box();
    mesh.positions.push_back({0.5, 0, 0});
    mesh.triangles[4] = {{0, 8, 5}};
    mesh.triangles.push_back({{8, 1, 5}});
    mesh.triangles.push_back({{0, 1, 8}});
    return mesh;
}

TEST(MeshCheckTest, DegenerateTriangles) {
    EXPECT_THAT(findings_of(box_with_sliver()),
                ElementsAre(MeshFinding{degenerate_triangle, 1, {13}}));
    EXPECT_TRUE(check_mesh(box_with_sliver()).closed);
}

TEST(MeshCheckTest, DuplicateTriangles) {
    MeshData same_way = unit_box(), other_way = unit_box();
    same_way.triangles.push_back({{2, 3, 0}});
    other_way.triangles.push_back({{0, 3, 2}});
    const MeshFinding edges{non_manifold_edge, 3, {0, 2, 0, 3, 2, 3}},
        overlap{self_intersection, 1, {0, 12}};
    EXPECT_THAT(findings_of(same_way),
                ElementsAre(edges, MeshFinding{duplicate_triangle, 1, {12}}, overlap));
    EXPECT_THAT(findings_of(other_way),
                ElementsAre(edges, MeshFinding{opposite_triangle, 1, {12}}, overlap));

    const MeshData pillow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}, {{0, 2, 1}}}};
    EXPECT_THAT(findings_of(pillow), ElementsAre(MeshFinding{opposite_triangle, 1, {1}},
                                                 MeshFinding{no_inward_direction, 3, {0, 1, 2}},
                                                 MeshFinding{self_intersection, 1, {0, 1}}));
}

TEST(MeshCheckTest, BowtieVertices) {
    MeshData mesh = joined(unit_box(), scenes::box({1, 1, 1}, {2, 3, 4}));
    replace_vertex(mesh, 8, 7);
    EXPECT_THAT(check_mesh(mesh).findings, Contains(MeshFinding{bowtie_vertex, 1, {7}}));
    EXPECT_EQ(check_mesh(mesh).components, 1u);

    MeshData tip{
        {{0, 0, 0}, {1, 0, 1}, {-1, 1, 1}, {-1, -1, 1}, {-1, 0, -1}, {1, -1, -1}, {1, 1, -1}}, {}};
    tip.triangles = {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 1, 3}}, {{1, 2, 3}},
                     {{0, 4, 5}}, {{0, 5, 6}}, {{0, 6, 4}}, {{4, 6, 5}}};
    EXPECT_THAT(findings_of(tip), ElementsAre(MeshFinding{bowtie_vertex, 1, {0}},
                                              MeshFinding{no_inward_direction, 1, {0}}));
}

TEST(MeshCheckTest, UnusedAndDuplicateVerticesDoNoHarm) {
    MeshData mesh = joined(unit_box(), {{{0.5, 0.5, 0.5}, {1, 0, 0}}, {}});
    const MeshReport report = check_mesh(mesh, everything);
    EXPECT_THAT(report.findings, ElementsAre(MeshFinding{unused_vertex, 2, {8, 9}},
                                             MeshFinding{duplicate_vertex, 1, {9}}));
    EXPECT_TRUE(report.sound());
    EXPECT_TRUE(report.closed);
    mesh.positions.push_back({9, 9, 9});
    EXPECT_EQ(check_mesh(mesh, everything).box.upper, (Vec3d{1, 1, 1})) << "no part of a body";
}

TEST(MeshCheckTest, CountsAreWholeAndPlacesFew) {
    MeshData soup;
    for (const MeshData box = unit_box(); const Triangle& t : box.triangles)
        soup = joined(soup, {{box.positions[t.vertex[0]], box.positions[t.vertex[1]],
                              box.positions[t.vertex[2]]},
                             {{{0, 1, 2}}}});
    const MeshReport report = check_mesh(soup, everything);
    ASSERT_EQ(report.findings.size(), 2u);
    EXPECT_EQ(report.findings[0].kind, border_edge);
    EXPECT_EQ(report.findings[0].count, 36u);
    EXPECT_EQ(report.findings[0].places.size(), 2 * constants::finding_places);
    EXPECT_EQ(report.findings[1].kind, duplicate_vertex);
    EXPECT_EQ(report.findings[1].count, 28u);
    EXPECT_EQ(report.findings[1].places.size(), constants::finding_places);
    EXPECT_EQ(report.components, 12u);
}

TEST(SelfIntersectionTest, CrossingBoxes) {
    const auto count = [](Vec3d shift) {
        return self_intersections(joined(unit_box(), scenes::box(shift, shift + Vec3d{1, 1, 1})))
            .size();
    };
    EXPECT_GT(count({0.4, 0.3, 0.2}), 0u);
    EXPECT_GT(count({0.5, 0.5, 0}), 0u) << "edges meet edges, and nothing else";
    EXPECT_EQ(count({1.5, 0, 0}), 0u);
    EXPECT_EQ(count({1, 0.3, 0.2}), 0u) << "faces touch";
    EXPECT_EQ(count({1, 1, 0.3}), 0u) << "edges touch";
    for (const double sign : {-1, 1})
        EXPECT_EQ(count({sign * (1 - constants::float_ulp), 0.3, 0.2}), 0u) << "within rounding";
    EXPECT_FALSE(check_mesh(scenes::torus(0.3, 1, 20, 20), everything).sound())
        << "a torus without a hole crosses itself";
    EXPECT_THAT(check_mesh(scenes::torus(0.3, 1, 20, 20)).findings, IsEmpty())
        << "but nobody asked";
}

TEST(SelfIntersectionTest, SheetsOnEachOther) {
    const MeshReport report = check_mesh(joined(unit_box(), scenes::box({1, 0, 0}, {2, 1, 1})),
                                         everything);
    EXPECT_THAT(report.findings, ElementsAre(MeshFinding{self_intersection, 2, {10, 21, 11, 20}},
                                             MeshFinding{duplicate_vertex, 4, {8, 10, 12, 14}}));
    const MeshData folded{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3f, 0.5f, 0}},
                          {{{0, 1, 2}}, {{1, 0, 3}}}};
    EXPECT_THAT(self_intersections(folded), ElementsAre(std::pair{0u, 1u}));
    const MeshData flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3f, -0.5f, 0}},
                        {{{0, 1, 2}}, {{1, 0, 3}}}};
    EXPECT_THAT(self_intersections(flat), IsEmpty());
}

TEST(SelfIntersectionTest, AgreesWithCrossingEdges) {
    test::Random random(31);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int crossing = 0, different = 0;
    for (int i = 0; i < 20000; ++i) {
        Corners a, b;
        for (Vec3d& p : a) p = random.in_box(1);
        for (Vec3d& p : b) p = random.in_box(1);
        if (i % 4 == 0) b[1] = a[2];
        if (is_degenerate(a[0], a[1], a[2]) || is_degenerate(b[0], b[1], b[2])) continue;
        const double inset = i % 4 == 0 ? constants::touch_tolerance : 0;
        const bool by_edges = edge_pierces(a, b, inset, inset) || edge_pierces(b, a, inset, inset);
        different += triangles_cross(a, b) != by_edges || triangles_cross(b, a) != by_edges;
        crossing += by_edges;
    }
    EXPECT_GT(crossing, 1000);
    EXPECT_LE(different, 2) << "that one counts as a touch what the other counts as a crossing "
                               "happens once in many seeds";
}

TEST(MeshCheckTest, InwardDirectionsAgreeWithTheInsideTest) {
    test::Random random(32);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int outward = 0;
    for (int m = 0; m < 60; ++m) {
        MeshData data = scenes::sphere(1, 1);
        for (Vec3f& p : data.positions) p = static_cast<float>(random.uniform(0.03, 1)) * p;
        test::Solid solid{{}, data.triangles};
        for (Vec3f p : data.positions) solid.positions.push_back({p.x, p.y, p.z});
        const Mesh mesh("spikes", data);
        std::vector<std::uint32_t> expected;
        for (std::uint32_t v = 0; v < data.positions.size(); ++v) {
            const Vec3d p = to_double(data.positions[v]) -
                            1e-6 * vertex_normal(mesh.view(), mesh.view().positions, v);
            if (!test::is_inside({p.x, p.y, p.z}, solid)) expected.push_back(v);
        }
        outward += static_cast<int>(expected.size());
        const MeshReport report = check_mesh(data);
        const MeshFinding* found = report.find(no_inward_direction);
        ASSERT_EQ(found == nullptr ? 0 : found->count, expected.size()) << "mesh " << m;
        if (found == nullptr) continue;
        expected.resize(std::min<std::size_t>(expected.size(), constants::finding_places));
        ASSERT_EQ(found->places, expected) << "mesh " << m;
    }
    EXPECT_GT(outward, 10);
}

/// Breaks one thing and says what must be found then.
MeshFinding inject(test::Random& random, MeshData& mesh) {
    const auto triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
    const auto vertex_count = static_cast<std::uint32_t>(mesh.positions.size());
    const auto t = static_cast<std::uint32_t>(
        random.integer(0, static_cast<int>(triangle_count) - 1));
    const Triangle triangle = mesh.triangles[t];
    const std::uint32_t v = triangle.vertex[random.integer(0, 2)];
    switch (random.integer(0, 10)) {
        case 0: {
            mesh.positions[v].x = nan;
            return {not_finite, 1, {v}};
        }
        case 1: {
            mesh.triangles[t].vertex[random.integer(0, 2)] = vertex_count +
                                                             static_cast<std::uint32_t>(
                                                                 random.integer(0, 5));
            return {bad_index, 1, {t}};
        }
        case 2: {
            mesh.triangles.erase(mesh.triangles.begin() + t);
            return {border_edge, 3, {}};
        }
        case 3: {
            std::swap(mesh.triangles[t].vertex[1], mesh.triangles[t].vertex[2]);
            return {flipped_edge, 3, {}};
        }
        case 4: {
            mesh.positions.push_back(to_float(random.in_box(1)));
            mesh.triangles.push_back({{triangle.vertex[0], triangle.vertex[1], vertex_count}});
            return {non_manifold_edge,
                    1,
                    {std::min(triangle.vertex[0], triangle.vertex[1]),
                     std::max(triangle.vertex[0], triangle.vertex[1])}};
        }
        case 5: {
            turn_around(mesh);
            return {inside_out, 1, {0}};
        }
        case 6: {
            const int k = random.integer(0, 2);
            mesh.triangles.push_back(
                {{triangle.vertex[k], triangle.vertex[(k + 1) % 3], triangle.vertex[(k + 2) % 3]}});
            return {duplicate_triangle, 1, {triangle_count}};
        }
        case 7: {
            const int k = random.integer(0, 2);
            mesh.triangles.push_back(
                {{triangle.vertex[k], triangle.vertex[(k + 2) % 3], triangle.vertex[(k + 1) % 3]}});
            return {opposite_triangle, 1, {triangle_count}};
        }
        case 8: {
            MeshData reflected = mesh;
            for (Vec3f& p : reflected.positions) p = 2.0f * mesh.positions[v] - p;
            turn_around(reflected);
            mesh = joined(mesh, reflected);
            replace_vertex(mesh, vertex_count + v, v);
            return {bowtie_vertex, 1, {v}};
        }
        case 9: {
            mesh.positions.push_back(to_float(random.in_box(1)));
            return {unused_vertex, 1, {vertex_count}};
        }
        default: {
            mesh.positions.push_back(mesh.positions[v]);
            std::ranges::replace(mesh.triangles[t].vertex, v, vertex_count);
            return {duplicate_vertex, 1, {vertex_count}};
        }
    }
}

TEST(MeshCheckTest, InjectedDefectsAreFound) {
    test::Random random(33);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::set<MeshDefect> kinds;
    for (int i = 0; i < 400; ++i) {
        MeshData mesh = test::random_closed_mesh(random);
        ASSERT_TRUE(check_mesh(mesh).closed);
        for (const MeshFinding& f : check_mesh(mesh).findings)
            ASSERT_EQ(f.kind, no_inward_direction) << "mesh " << i;
        const MeshFinding expected = inject(random, mesh);
        const MeshReport report = check_mesh(mesh, {.self_intersections = i % 10 == 0});
        const MeshFinding* found = report.find(expected.kind);
        ASSERT_NE(found, nullptr) << "mesh " << i << ": " << name(expected.kind);
        EXPECT_EQ(found->count, expected.count) << "mesh " << i << ": " << name(expected.kind);
        if (!expected.places.empty()) {
            EXPECT_EQ(found->places, expected.places) << "mesh " << i;
        }
        kinds.insert(expected.kind);
    }
    EXPECT_EQ(kinds.size(), 11u);
}

TEST(MeshCheckTest, NothingMakesItThrow) {
    test::Random random(34);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 300; ++i) {
        MeshData mesh;
        const int vertices = random.integer(0, 12);
        for (int v = 0; v < vertices; ++v) {
            mesh.positions.push_back(
                to_float(std::pow(10, random.uniform(-44, 40)) * random.in_box(1)));
            if (random.integer(0, 9) == 0) mesh.positions.back()[random.integer(0, 2)] = nan;
            if (random.integer(0, 4) == 0) mesh.positions.back() = mesh.positions.front();
        }
        const int triangles = random.integer(0, 30);
        const auto any = [&] {
            return static_cast<std::uint32_t>(random.integer(-1, vertices + vertices / 8));
        };
        for (int t = 0; t < triangles; ++t) mesh.triangles.push_back({{any(), any(), any()}});
        MeshReport report;
        ASSERT_NO_THROW(report = check_mesh(mesh, everything)) << "mesh " << i;
        for (const MeshFinding& f : report.findings)
            EXPECT_LE(f.places.size(), ids_per_place(element(f.kind)) * constants::finding_places);
    }
}

TEST(MeshDefectTest, EveryOneIsDescribed) {
    std::set<std::string_view> names;
    for (std::uint32_t i = 0; i < mesh_defect_count; ++i) {
        const auto defect = static_cast<MeshDefect>(i);
        EXPECT_FALSE(meaning(defect).empty());
        names.insert(name(defect));
    }
    EXPECT_EQ(names.size(), mesh_defect_count);
    EXPECT_EQ(element(border_edge), MeshElement::edge);
    EXPECT_EQ(element(self_intersection), MeshElement::triangle_pair);
}

}  // namespace
}  // namespace pierce
