// Complete coverage against overlap by definition, and re-projection against the closest point,
// both found again in long double by tests/support/brute_force.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>

#include "core/geometry/closest_point.hpp"
#include "core/geometry/closest_points_of_segments.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/world.hpp"
#include "scenes/named/scene.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"
#include "support/welded.hpp"

namespace pierce {
namespace {

using test::exact;
using test::Solid;
using test::solid_of;
using test::SolidVec;

Settings complete(bool reproject = false) {
    return {.coverage = Coverage::complete, .reproject = reproject};
}

SolidVec middle_of(SolidVec a, SolidVec b) {
    return {(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2};
}

bool edges_cross(const Solid& from, const Solid& into) {
    for (const Triangle& t : from.triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = t.vertex[k], b = t.vertex[(k + 1) % 3];
            if (a < b &&
                test::crossings_between(from.positions[a], from.positions[b], into, ~0u, 0) > 0)
                return true;
        }
    return false;
}

bool overlap_by_definition(const Solid& a, const Solid& b) {
    return edges_cross(a, b) || edges_cross(b, a) || test::is_inside(a.positions[0], b) ||
           test::is_inside(b.positions[0], a);
}

double distance_to_surface(Vec3d p, const MeshData& mesh, const Pose& pose) {
    const Frame frame = frame_of(pose);
    double best = INFINITY;
    for (const Triangle& t : mesh.triangles) {
        Vec3d c[3];
        for (int k = 0; k < 3; ++k) c[k] = frame.to_parent(to_double(mesh.positions[t.vertex[k]]));
        best = std::min(best, length(p - closest_on_triangle(p, c[0], c[1], c[2])));
    }
    return best;
}

/// [length] How far a contact of an edge is from the shortest way between that edge and an edge of
/// the target.
double off_ridges(const Contact& c, const MeshData& source, const Pose& source_pose,
                  const MeshData& target, const Pose& target_pose) {
    const auto place = [](const MeshData& mesh, const Pose& pose, std::uint32_t v) {
        return frame_of(pose).to_parent(to_double(mesh.positions[v]));
    };
    const bool from_a = c.source == Side::a;
    const Vec3d from = place(source, source_pose, c.vertex),
                to = place(source, source_pose, c.edge_end);
    double least = INFINITY;
    for (const Triangle& t : target.triangles)
        for (int k = 0; k < 3; ++k) {
            const Vec3d first = place(target, target_pose, t.vertex[k]),
                        last = place(target, target_pose, t.vertex[(k + 1) % 3]);
            const SegmentPlaces at = closest_points_of_segments(from, to, first, last);
            const Vec3d p = from + at.first * (to - from), q = first + at.second * (last - first);
            least = std::min(least, std::max({length(p - (from_a ? c.point_a : c.point_b)),
                                              length(q - (from_a ? c.point_b : c.point_a)),
                                              std::fabs(length(q - p) - c.penetration_depth())}));
        }
    return least;
}

/// Distances to a surface shorter than this are rounding.
double least_depth(const MeshData& mesh) {
    Box box;
    for (Vec3f p : mesh.positions) box.extend(to_double(p));
    return 10 * constants::touch_tolerance * box.extent();
}

struct Two {
    World world;
    std::array<MeshData, 2> data;
    std::array<Pose, 2> pose;
    std::array<BodyId, 2> body;
    std::array<Solid, 2> solid;

    Two(const test::NamedBackend& backend, const Settings& settings, MeshData a, Pose pose_a,
        MeshData b, Pose pose_b, bool deforming = false)
        : world(backend.make(), settings), data{std::move(a), std::move(b)}, pose{pose_a, pose_b} {
        for (std::size_t k = 0; k < 2; ++k) {
            const MeshId mesh = world.add_mesh("mesh", data[k]);
            if (deforming) {
                data[k].positions = test::placed(data[k], pose[k]);
                pose[k] = {};
                body[k] = world.add_deforming_body(mesh, data[k].positions);
            } else {
                body[k] = world.add_rigid_body(mesh, pose[k]);
            }
            solid[k] = solid_of(data[k], pose[k]);
        }
        world.detect();
    }

    /// Rigid bodies to where `solid` does not follow.
    void move(const Pose& a, const Pose& b) {
        pose = {a, b};
        for (std::size_t k = 0; k < 2; ++k) world.set_pose(body[k], pose[k]);
        world.detect();
    }
};

/// Of every vertex in contact: the contact's depth over the vertex's distance to the target's
/// surface.
void add_depth_ratios(const Two& two, std::vector<double>& ratios) {
    for (const Contact& c : two.world.contacts()) {
        const std::size_t source = c.source == Side::a ? 0 : 1, target = 1 - source;
        const Vec3d p = source == 0 ? c.point_a : c.point_b;
        const double distance = distance_to_surface(p, two.data[target], two.pose[target]);
        if (distance > least_depth(two.data[target]))
            ratios.push_back(c.penetration_depth() / distance);
    }
    std::ranges::sort(ratios);
}

/// Of a sorted list.
double quantile(const std::vector<double>& sorted, double part) {
    return sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
}

class CoverageTest : public testing::TestWithParam<test::NamedBackend> {};

TEST_P(CoverageTest, FindsEveryOverlapAndInventsNone) {
    test::Random random(505);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int overlapping = 0, by_vertices = 0, edge_contacts = 0, apart = 0, separated = 0;
    for (int i = 0; i < 150 && !HasFailure(); ++i) {
        SCOPED_TRACE("pair " + std::to_string(i));
        const double spread = random.uniform(0.2, 1.1);
        const Pose a{random.in_box(spread), random.rotation()},
            b{random.in_box(spread), random.rotation()};
        MeshData first = test::random_closed_mesh(random),
                 second = test::random_closed_mesh(random);
        const auto shrink = static_cast<float>(i % 5 == 0 ? random.uniform(0.05, 0.4) : 1);
        for (Vec3f& p : first.positions) p = shrink * p;
        Two two(GetParam(), complete(), first, a, second, b, i % 3 == 0);
        const bool expected = overlap_by_definition(two.solid[0], two.solid[1]);
        EXPECT_EQ(!two.world.contacts().empty(), expected);
        overlapping += expected;
        apart += !expected;
        separated += static_cast<int>(two.world.stats().separated_pairs);
        by_vertices += std::ranges::any_of(two.world.contacts(), [](const Contact& c) {
            return !c.is_edge() && c.found != Found::separation;
        });
        for (const Contact& c : two.world.contacts()) {
            const std::size_t source = c.source == Side::a ? 0 : 1, target = 1 - source;
            const Vec3d p = source == 0 ? c.point_a : c.point_b,
                        q = source == 0 ? c.point_b : c.point_a;
            if (c.penetration_depth() < 1e-3) continue;
            const SolidVec middle = middle_of(exact(p), exact(q));
            EXPECT_TRUE(test::is_inside(middle, two.solid[target]));
            EXPECT_NEAR(dot(c.point_b - c.point_a, c.normal), c.distance, 1e-6);
            EXPECT_LT(distance_to_surface(q, two.data[target], two.pose[target]), 1e-6);
            EXPECT_TRUE(c.found == Found::separation || test::is_inside(middle, two.solid[source]));
            if (!c.is_edge()) continue;
            ++edge_contacts;
            const Frame frame = frame_of(two.pose[source]);
            const Vec3d end[2] = {
                frame.to_parent(to_double(two.data[source].positions[c.vertex])),
                frame.to_parent(to_double(two.data[source].positions[c.edge_end]))};
            EXPECT_LT(length(c.source_weight(0) * end[0] + c.source_weight(1) * end[1] - p), 1e-6);
            EXPECT_TRUE(test::is_inside(exact(p), two.solid[target]));
        }
    }
    EXPECT_GT(apart, 10);
    EXPECT_GT(overlapping, by_vertices) << "some overlaps need edges";
    EXPECT_GT(edge_contacts, 500);
    EXPECT_GT(separated, 0);
}

// Every vertex of either is on the other one, to the touch tolerance, and every edge crosses once.
TEST_P(CoverageTest, ABodyAndItsCopyNextToItAreInContact) {
    const MeshData mesh{{{0.891187906f, 0.331624329f, 0.513450801f},
                         {0.435217828f, 0.311345071f, 0.476829171f},
                         {0.889005899f, 0.742870212f, 0.709132552f},
                         {0.674113095f, 0.971450388f, 0.296864271f}},
                        {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}};
    test::Random random(7);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (const Coverage coverage : {Coverage::overlaps, Coverage::complete}) {
        World world(GetParam().make(), {.coverage = coverage});
        const MeshId id = world.add_mesh("mesh", mesh);
        const double touch = constants::touch_tolerance * world.mesh(id).view({}).box.extent();
        world.add_fixed_body(id);
        const BodyId copy = world.add_rigid_body(id);
        for (int i = 0; i < 400; ++i) {
            world.set_pose(copy, {1.5 * touch * random.in_box(0.6), {}});
            world.detect();
            EXPECT_FALSE(world.contacts().empty()) << i;
        }
    }
}

TEST_P(CoverageTest, EveryChordWithinAnEdgeIsFoundAndEveryOtherOneWhereNothingElseIs) {
    test::Random random(9);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int without_contact = 0;
    for (int i = 0; i < 60; ++i) {
        MeshData first = test::random_closed_mesh(random);
        const auto shrink = static_cast<float>(i % 3 == 0 ? 0.1 : 1);
        for (Vec3f& p : first.positions) p = shrink * p;
        // Compilers evaluate arguments in different orders.
        const Pose second_pose{random.in_box(0.5), random.rotation()};
        const MeshData second = test::random_closed_mesh(random);
        const Pose first_pose{random.in_box(0.5), random.rotation()};
        Two two(GetParam(), complete(), first, first_pose, second, second_pose, i % 2 == 0);
        std::uint32_t within = 0, at_ends = 0;
        for (std::size_t k = 0; k < 2; ++k)
            for (const Edge& e : two.world.mesh(two.world.mesh_of(two.body[k])).view().edges) {
                const SolidVec a = two.solid[k].positions[e.vertex[0]],
                               b = two.solid[k].positions[e.vertex[1]];
                const int crossings = test::crossings_between(a, b, two.solid[1 - k], ~0u, 0);
                if (crossings == 0) continue;
                // A chord within the edge has two crossings, one at an end has one.
                const int ends = test::is_inside(a, two.solid[1 - k]) +
                                 test::is_inside(b, two.solid[1 - k]);
                at_ends += static_cast<std::uint32_t>(ends);
                within += static_cast<std::uint32_t>(crossings - ends) / 2;
            }
        const bool has_contact = std::ranges::any_of(two.world.contacts(), [](const Contact& c) {
            return c.found != Found::separation && c.penetration_depth() > 0;
        });
        without_contact += !has_contact && at_ends > 0;
        EXPECT_EQ(two.world.stats().chords, has_contact ? within : within + at_ends)
            << "pair " << i;
    }
    EXPECT_GT(without_contact, 0);
}

TEST_P(CoverageTest, EveryPartOfAnEdgeThatIsInsideIsInContact) {
    test::Random random(12);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::uint32_t contacts = 0;
    for (int i = 0; i < 60; ++i) {
        SCOPED_TRACE("pair " + std::to_string(i));
        Two two(GetParam(), complete(true), test::random_closed_mesh(random),
                {random.in_box(0.5), random.rotation()}, test::random_closed_mesh(random),
                {random.in_box(0.5), random.rotation()}, i % 2 == 0);
        for (std::size_t k = 0; k < 2; ++k) {
            const View<const Edge>
                edges = two.world.mesh(two.world.mesh_of(two.body[k])).view().edges;
            for (std::uint32_t e = 0; e < edges.size; ++e) {
                const SolidVec a = two.solid[k].positions[edges[e].vertex[0]],
                               b = two.solid[k].positions[edges[e].vertex[1]];
                const int crossings = test::crossings_between(a, b, two.solid[1 - k], ~0u, 0);
                if (crossings > 0 &&
                    (test::is_inside(a, two.solid[1 - k]) || test::is_inside(b, two.solid[1 - k])))
                    continue;
                const auto found = std::ranges::count_if(
                    two.world.contacts(), [&](const Contact& c) {
                        return c.is_edge() && c.edge == e && c.found != Found::separation &&
                               c.source == (two.body[k] == c.a ? Side::a : Side::b);
                    });
                EXPECT_EQ(found, crossings / 2) << "edge " << e << " of body " << k;
                contacts += static_cast<std::uint32_t>(found);
            }
        }
    }
    EXPECT_GT(contacts, 300u);
}

/// What a contact is about: the bodies' parts, how it was found, and its points and normal.
bool are_same(const Contact& x, const Contact& y) {
    return x.source == y.source && x.vertex == y.vertex && x.edge_end == y.edge_end &&
           x.chord == y.chord && x.found == y.found && x.triangle == y.triangle &&
           x.point_a == y.point_a && x.point_b == y.point_b && x.normal == y.normal &&
           x.distance == y.distance;
}

/// The outward direction of a vertex: the normals of its triangles, weighted by their angles.
Vec3d outward_at(const MeshData& mesh, const Pose& pose, std::uint32_t v) {
    const auto at = [&](std::uint32_t w) { return to_double(mesh.positions[w]); };
    Vec3d sum;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            if (t.vertex[k] != v) continue;
            const Vec3d a = at(t.vertex[(k + 1) % 3]) - at(v),
                        b = at(t.vertex[(k + 2) % 3]) - at(v);
            sum += std::acos(dot(normalized(a), normalized(b))) * normalized(cross(a, b));
        }
    return frame_of(pose).rotation * normalized(sum);
}

std::size_t edge_count(const MeshData& mesh) { return mesh.triangles.size() * 3 / 2; }

/// By docs/step.md: whether the edges of a pair are left alone with Coverage::overlaps.
bool vertices_show_a_way_out(const Two& two, bool reproject) {
    bool shown = false;
    std::size_t inside = 0;
    for (const Contact& c : two.world.contacts()) {
        if (c.is_edge() || c.found == Found::separation || !(c.penetration_depth() > 0)) continue;
        ++inside;
        const std::size_t side = c.source == Side::a ? 0 : 1;
        const Vec3d way = c.target_point() - c.source_point();
        shown = shown || !reproject ||
                dot(way, outward_at(two.data[side], two.pose[side], c.vertex)) < 0;
    }
    const bool coarse = std::max(edge_count(two.data[0]), edge_count(two.data[1])) <=
                        constants::coarse_edges;
    return shown && !(reproject && coarse && inside < 3);
}

TEST_P(CoverageTest, OverlapsAreThoseOfCompleteCoverageWithoutEdgesBesideVertices) {
    test::Random random(77);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int by_vertices = 0, by_edges = 0, fewer = 0, separated = 0, astray = 0;
    for (int i = 0; i < 180 && !HasFailure(); ++i) {
        SCOPED_TRACE("pair " + std::to_string(i));
        const double spread = random.uniform(0.2, 1.1);
        MeshData first = test::random_closed_mesh(random),
                 second = test::random_closed_mesh(random);
        const auto shrink = static_cast<float>(i % 3 == 0 ? random.uniform(0.05, 0.4) : 1);
        for (Vec3f& p : first.positions) p = shrink * p;
        const Pose a{random.in_box(spread), random.rotation()},
            b{random.in_box(spread), random.rotation()};
        Settings all = complete(i % 2 == 0), some = all;
        some.coverage = Coverage::overlaps;
        const Two two(GetParam(), all, first, a, second, b, i % 4 == 0),
            other(GetParam(), some, first, a, second, b, i % 4 == 0);
        std::vector<Contact> expected(two.world.contacts().begin(), two.world.contacts().end());
        if (vertices_show_a_way_out(two, all.reproject)) {
            ++by_vertices;
            fewer += std::erase_if(expected, [](const Contact& c) { return c.is_edge(); }) > 0;
        } else {
            astray += std::ranges::any_of(expected, [](const Contact& c) {
                return !c.is_edge() && c.penetration_depth() > 0 && c.found != Found::separation;
            });
            by_edges += std::ranges::any_of(expected, [](const Contact& c) {
                return c.is_edge() && c.found != Found::separation;
            });
            separated += std::ranges::any_of(
                expected, [](const Contact& c) { return c.found == Found::separation; });
        }
        const auto found = other.world.contacts();
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t k = 0; k < expected.size(); ++k)
            EXPECT_TRUE(are_same(found[k], expected[k])) << "contact " << k;
    }
    EXPECT_GT(by_vertices, 20);
    EXPECT_GT(fewer, 10);
    EXPECT_GT(by_edges, 2);
    EXPECT_GT(separated, 0);
    EXPECT_GT(astray, 5);
}

/// Corners that are a hair behind the sides of the other box do not hide what carries it.
TEST_P(CoverageTest, CornersAHairInsideDoNotHideTheWayOut) {
    for (const double x : {0.1, 0.3})
        for (const double hair : {1e-5, 1e-4, 1e-3}) {
            const MeshData cube = scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
            const double turn = std::sqrt(0.5);  // the faces' diagonals cross
            const Two two(GetParam(), {}, cube, {{0, 0, 0}, {0, 0, turn, turn}}, cube,
                          {{x, hair, 0.98}, {0, 0, 0, 1}});
            double deepest = 0;
            for (const Contact& c : two.world.contacts())
                if (std::fabs(c.normal.z) > 0.99)
                    deepest = std::max(deepest, c.penetration_depth());
            EXPECT_NEAR(deepest, 0.02, 1e-5) << x << " " << hair;
        }
}

TEST_P(CoverageTest, BarsThatCrossWithoutAVertexInside) {
    const MeshData a = scenes::box({-2, -0.1, -0.1}, {2, 0.1, 0.1}),
                   b = scenes::box({-0.1, -2, 0}, {0.1, 2, 0.2});
    EXPECT_TRUE(Two(GetParam(), vertex_rays, a, {}, b, {}).world.contacts().empty())
        << "vertices see nothing";
    Two two(GetParam(), complete(), a, {}, b, {});
    Vec3d sum;
    int ridges = 0;
    for (const Contact& c : two.world.contacts()) {
        EXPECT_TRUE(c.is_edge());
        EXPECT_EQ(c.found, Found::full);
        sum += c.penetration_depth() * c.normal;
        const Vec3d p = c.source == Side::a ? c.point_a : c.point_b;
        if (std::abs(c.penetration_depth() - 0.1 * std::sqrt(2.0)) < 1e-6 && c.source == Side::a) {
            EXPECT_LT(length(Vec3d{p.x, std::abs(p.y), p.z} - Vec3d{0, 0.1, 0.1}), 1e-6);
            ++ridges;
        }
    }
    EXPECT_EQ(ridges, 2);
    EXPECT_LT(std::hypot(sum.x, sum.y), 1e-6 * sum.z)
        << "a lies below b, and the normal points from a to b";
}

/// Of two convex bodies with whole coordinates: true if no plane lies between them, nor touches
/// both. Exact.
bool convex_bodies_overlap(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b,
                           const std::vector<Triangle>& of_a, const std::vector<Triangle>& of_b) {
    std::vector<Vec3d> axes, edges[2];
    const std::vector<Vec3d>* points[] = {&a, &b};
    const std::vector<Triangle>* triangles[] = {&of_a, &of_b};
    for (int k = 0; k < 2; ++k)
        for (const Triangle& t : *triangles[k]) {
            const Vec3d p = (*points[k])[t.vertex[0]], q = (*points[k])[t.vertex[1]],
                        r = (*points[k])[t.vertex[2]];
            axes.push_back(cross(q - p, r - p));
            edges[k].insert(edges[k].end(), {q - p, r - q, p - r});
        }
    for (const Vec3d& e : edges[0])
        for (const Vec3d& f : edges[1]) axes.push_back(cross(e, f));
    return std::ranges::none_of(axes, [&](Vec3d axis) {
        if (length_squared(axis) == 0) return false;
        const auto along = [&](Vec3d p) { return dot(axis, p); };
        const auto [low_a, high_a] = std::ranges::minmax(a, {}, along);
        const auto [low_b, high_b] = std::ranges::minmax(b, {}, along);
        return along(high_a) <= along(low_b) || along(high_b) <= along(low_a);
    });
}

std::vector<Vec3d> placed_at_whole_numbers(const MeshData& mesh, const Pose& pose) {
    std::vector<Vec3d> points;
    for (Vec3f p : mesh.positions) {
        const Vec3d q = frame_of(pose).to_parent(to_double(p));
        points.push_back({std::round(q.x), std::round(q.y), std::round(q.z)});
    }
    return points;
}

/// Their corners lie on each other's edges and faces in every way there is.
TEST_P(CoverageTest, AlignedBodiesOfWholeNumbersHaveAContactExactlyIfTheyOverlap) {
    MeshData box, tetrahedron, octahedron;
    for (int k = 0; k < 8; ++k)
        box.positions.push_back({k & 1 ? 2.f : 0.f, k & 2 ? 2.f : 0.f, k & 4 ? 2.f : 0.f});
    box.triangles = {{{0, 2, 3}}, {{0, 3, 1}}, {{4, 5, 7}}, {{4, 7, 6}}, {{0, 1, 5}}, {{0, 5, 4}},
                     {{2, 6, 7}}, {{2, 7, 3}}, {{0, 4, 6}}, {{0, 6, 2}}, {{1, 3, 7}}, {{1, 7, 5}}};
    tetrahedron.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
    tetrahedron.triangles = {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}};
    octahedron.positions = {{2, 0, 0}, {-2, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 2}, {0, 0, -2}};
    octahedron.triangles = {{{0, 2, 4}}, {{2, 1, 4}}, {{1, 3, 4}}, {{3, 0, 4}},
                            {{2, 0, 5}}, {{1, 2, 5}}, {{3, 1, 5}}, {{0, 3, 5}}};
    const MeshData regular{{{0, 0, 0}, {2, 0, 2}, {2, 2, 0}, {0, 2, 2}},
                           {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}};
    const MeshData* shapes[] = {&box, &tetrahedron, &octahedron, &regular};
    const double half = std::sqrt(0.5);
    constexpr int reach = 5;
    for (const MeshData* first : shapes)
        for (const MeshData* second : shapes) {
            World world(GetParam().make(), complete());
            world.add_fixed_body(world.add_mesh("first", *first));
            const BodyId moving = world.add_rigid_body(world.add_mesh("second", *second));
            const std::vector<Vec3d> still = placed_at_whole_numbers(*first, {});
            int wrong = 0;
            // Quarter and half turns about an axis, and none.
            for (const Quaternion& turn : {Quaternion{0, 0, 0, 1},
                                           {1, 0, 0, 0},
                                           {0, 1, 0, 0},
                                           {0, 0, 1, 0},
                                           {half, 0, 0, half},
                                           {0, half, 0, half},
                                           {0, 0, half, half},
                                           {1, 1, 1, 1}})
                for (int x = -reach; x <= reach; ++x)
                    for (int y = -reach; y <= reach; ++y)
                        for (int z = -reach; z <= reach; ++z) {
                            const Pose pose{{double(x), double(y), double(z)}, turn};
                            const bool overlap = convex_bodies_overlap(
                                still, placed_at_whole_numbers(*second, pose), first->triangles,
                                second->triangles);
                            world.set_pose(moving, pose);
                            world.detect();
                            const bool deep = std::ranges::any_of(
                                world.contacts(), [](const Contact& c) { return c.distance < 0; });
                            if (deep == overlap || wrong++ > 0) continue;
                            ADD_FAILURE()
                                << first->positions.size() << " and " << second->positions.size()
                                << " vertices, overlap " << overlap << ", at " << x << ' ' << y
                                << ' ' << z << ", turned by " << turn.x << ' ' << turn.y << ' '
                                << turn.z << ' ' << turn.w;
                        }
            EXPECT_EQ(wrong, 0);
        }
}

TEST_P(CoverageTest, APlateInsideABlock) {
    const MeshData plate = scenes::box({-1, -1, 0}, {1, 1, 0.01}),
                   block = scenes::box({-2, -2, -2}, {2, 2, 2});
    for (bool deforming : {false, true}) {
        EXPECT_TRUE(
            Two(GetParam(), vertex_rays, plate, {}, block, {}, deforming).world.contacts().empty());
        Two two(GetParam(), complete(), plate, {}, block, {}, deforming);
        EXPECT_EQ(two.world.stats().separated_pairs, 1u);
        double deepest = 0;
        for (const Contact& c : two.world.contacts()) {
            EXPECT_EQ(c.found, Found::separation);
            EXPECT_NEAR(c.normal.z, -1, 1e-9) << "the plate, a, leaves upward";
            deepest = std::max(deepest, c.penetration_depth());
        }
        EXPECT_NEAR(deepest, 2, 1e-6);
        EXPECT_GE(two.world.contacts().size(), 4u);
    }
}

TEST_P(CoverageTest, APlateThroughABlock) {
    // Surfaces cross, but every inward ray leaves the thin plate first, or the block's side before
    // the plate's far end.
    const MeshData plate = scenes::box({-3, -3, 0}, {3, 3, 0.01}),
                   block = scenes::box({-2, -2, -2}, {2, 2, 2});
    EXPECT_TRUE(Two(GetParam(), vertex_rays, plate, {}, block, {}).world.contacts().empty());
    Two two(GetParam(), complete(), plate, {}, block, {});
    EXPECT_EQ(two.world.stats().separated_pairs, 1u);
    ASSERT_FALSE(two.world.contacts().empty());
    for (const Contact& c : two.world.contacts()) EXPECT_NEAR(std::abs(c.normal.z), 1, 1e-9);
}

TEST_P(CoverageTest, BodiesInsideEachOther) {
    // A ball in a ball, both parts of a body in a ball, and a ball in a hollow: the last one is
    // outside.
    const MeshData small = scenes::sphere(0.2, 2), large = scenes::sphere(1, 3);
    EXPECT_FALSE(Two(GetParam(), complete(), small, {{0.3, 0.2, 0.1}, {}}, large, {})
                     .world.contacts()
                     .empty());
    MeshData two_parts = small;
    const auto first = static_cast<std::uint32_t>(small.positions.size());
    for (Vec3f p : small.positions) two_parts.positions.push_back(p + Vec3f{5, 0, 0});
    for (Triangle t : small.triangles)
        two_parts.triangles.push_back(
            {{t.vertex[0] + first, t.vertex[1] + first, t.vertex[2] + first}});
    for (double x : {0.0, -5.0})
        EXPECT_FALSE(Two(GetParam(), complete(), two_parts, {{x, 0, 0}, {}}, large, {})
                         .world.contacts()
                         .empty())
            << "whichever part is inside";
    MeshData hollow = large;
    const auto inner = static_cast<std::uint32_t>(hollow.positions.size());
    for (Vec3f p : large.positions) hollow.positions.push_back(0.9f * p);
    for (Triangle t : large.triangles)
        hollow.triangles.push_back(
            {{t.vertex[0] + inner, t.vertex[2] + inner, t.vertex[1] + inner}});
    EXPECT_TRUE(Two(GetParam(), complete(), small, {}, hollow, {}).world.contacts().empty());
    EXPECT_FALSE(
        Two(GetParam(), complete(), scenes::sphere(0.02, 1), {{0.95, 0, 0}, {}}, hollow, {})
            .world.contacts()
            .empty());
}

TEST_P(CoverageTest, ReprojectionEndsAtTheClosestPointOrTheRidge) {
    test::Random random(77);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t moved = 0, ridges = 0, compared = 0, past_ridges = 0;
    for (int i = 0; i < 60 && !HasFailure(); ++i) {
        SCOPED_TRACE("pair " + std::to_string(i));
        const Pose a{random.in_box(0.5), random.rotation()},
            b{random.in_box(0.5), random.rotation()};
        const MeshData first = test::random_closed_mesh(random),
                       second = test::random_closed_mesh(random);
        Two plain(GetParam(), complete(), first, a, second, b, i % 2 == 0);
        Two two(GetParam(), complete(true), first, a, second, b, i % 2 == 0);
        std::map<std::uint64_t, double> depth_of_ray;
        for (const Contact& c : plain.world.contacts())
            if (c.found != Found::separation) depth_of_ray[c.feature()] = c.penetration_depth();
        for (const Contact& c : two.world.contacts()) {
            if (!c.reprojected) continue;
            ++moved;
            const std::size_t source = c.source == Side::a ? 0 : 1, target = 1 - source;
            if (c.is_edge() && off_ridges(c, two.data[source], two.pose[source], two.data[target],
                                          two.pose[target]) < 1e-6) {
                ++ridges;
                continue;
            }
            if (const auto before = depth_of_ray.find(c.feature()); before != depth_of_ray.end()) {
                ++compared;
                EXPECT_LE(c.penetration_depth(), before->second);
            }
            const Vec3d p = source == 0 ? c.point_a : c.point_b,
                        q = source == 0 ? c.point_b : c.point_a;
            const double closest = distance_to_surface(p, two.data[target], two.pose[target]);
            // An edge over a ridge may leave through a face that is nearer than the ridge, where
            // the closest point is on a face beside it.
            if (c.is_edge() && c.penetration_depth() > closest + 1e-6)
                ++past_ridges;
            else
                EXPECT_NEAR(c.penetration_depth(), closest, 1e-6);
            EXPECT_LT(distance_to_surface(q, two.data[target], two.pose[target]), 1e-6);
            if (c.penetration_depth() < 1e-3) continue;
            EXPECT_TRUE(test::is_inside(middle_of(exact(p), exact(q)), two.solid[target]));
        }
    }
    EXPECT_GT(moved, 1000u);
    EXPECT_GT(compared, 500u);
    EXPECT_GT(ridges, 100u);
    EXPECT_LT(past_ridges, ridges / 20);
    EXPECT_GT(moved, 2 * ridges) << "not every contact may be one to a ridge";
}

/// A box turned on a box: no vertex is inside, and every edge is over an upright ridge, although
/// the face between the two is much nearer.
TEST_P(CoverageTest, BoxesThatAreStackedAreNotPushedAside) {
    const MeshData box = scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
    constexpr double overlap = 0.001;
    for (const Coverage coverage : {Coverage::overlaps, Coverage::complete}) {
        Settings settings = complete(true);
        settings.coverage = coverage;
        for (double turn : {0.1, 0.3, 0.785398163}) {
            const Pose above{{0.03, 0.01, 1 - overlap},
                             {0, 0, std::sin(turn / 2), std::cos(turn / 2)}};
            Two two(GetParam(), settings, box, {}, box, above);
            EXPECT_GT(two.world.contacts().size(), 2u);
            for (const Contact& c : two.world.contacts()) {
                EXPECT_LT(c.penetration_depth(), 1.01 * overlap) << "turned by " << turn;
                EXPECT_GT(c.normal.z, 0.99) << "turned by " << turn;
            }
        }
    }
}

TEST_P(CoverageTest, EdgesAreHardlyDeeperThanTheirPair) {
    const MeshData box = scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
    test::Random random(5);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    World world(GetParam().make(), complete(true));
    const MeshId mesh = world.add_mesh("box", box);
    const BodyId a = world.add_rigid_body(mesh), b = world.add_rigid_body(mesh);
    int pairs = 0, deeper = 0;
    for (int i = 0; i < 200; ++i) {
        world.set_pose(a, {{}, random.rotation()});
        world.set_pose(b, {random.in_box(0.8), random.rotation()});
        world.detect();
        double deepest = 0;
        for (const Contact& c : world.contacts())
            if (c.is_edge()) deepest = std::max(deepest, c.penetration_depth());
        const auto parting = deepest > 0 ? world.parting(a, b) : std::nullopt;
        if (!parting) continue;
        ++pairs;
        deeper += deepest > 1.01 * parting->depth;
        EXPECT_LT(deepest, 2 * parting->depth) << "pair " << i;
    }
    EXPECT_GT(pairs, 100);
    EXPECT_LE(deeper, pairs / 20) << "of " << pairs;
}

TEST_P(CoverageTest, ReprojectedDepthsOfSpheresAreDistancesToTheSurface) {
    test::Random random(31);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const MeshData ball = scenes::sphere(1, 4);
    ASSERT_EQ(ball.triangles.size(), 5120u);
    for (double overlap : {0.025, 0.25}) {
        SCOPED_TRACE("overlap of " + std::to_string(overlap) + " diameters");
        const Pose a{{}, random.rotation()},
            b{(2 - 2 * overlap) * random.unit_vector(), random.rotation()};
        std::vector<double> rays, moved;
        add_depth_ratios(Two(GetParam(), vertex_rays, ball, a, ball, b), rays);
        add_depth_ratios(Two(GetParam(), {.coverage = Coverage::vertices}, ball, a, ball, b),
                         moved);
        ASSERT_GT(moved.size(), 50u);
        EXPECT_EQ(moved.size(), rays.size());
        EXPECT_GT(quantile(rays, 0.5), 1 + overlap) << "inward rays are longer";
        EXPECT_GT(moved.front(), 1 - 1e-6);
        EXPECT_LT(moved.back(), 1.001);
    }
}

/// Two unit cubes that have an edge in common, and four triangles there.
MeshData cubes_at_an_edge() {
    return test::welded(
        scenes::joined(scenes::box({0, 0, 0}, {1, 1, 1}), scenes::box({1, 1, 0}, {2, 2, 1})));
}

TEST_P(CoverageTest, CubesAtAnEdgeThatOnlyTouchAnotherOneHaveNoDepth) {
    const MeshData cube = scenes::box({0, 0, 0}, {1, 1, 1}), two = cubes_at_an_edge();
    int touching = 0, overlapping = 0;
    for (int turn = 0; turn < 3; ++turn)
        for (int i = 0; i < 6 * 6 * 6; ++i) {
            Vec3d by{0.5 * (i % 6) - 1.0, 0.5 * (i / 6 % 6) - 1.0, 0.5 * (i / 36) - 1.0};
            MeshData turned = two;
            for (Vec3f& p : turned.positions) {
                const Vec3f before = p;
                for (int k = 0; k < 3; ++k) p[(k + turn) % 3] = before[k];
            }
            double most = -1;  // of two axes each, how far cubes reach into each other
            for (const Vec3d first : {Vec3d{0, 0, 0}, Vec3d{1, 1, 0}}) {
                double least = 1;
                for (int k = 0; k < 3; ++k) {
                    const int axis = (k + turn) % 3;
                    least = std::min(1 - std::fabs(by[axis] - first[k]), least);
                }
                most = std::max(least, most);
            }
            World world(GetParam().make());
            const BodyId a = world.add_rigid_body(world.add_mesh("two", turned)),
                         b = world.add_rigid_body(world.add_mesh("cube", cube), {by, {}});
            world.detect();
            double deepest = 0;
            for (const Contact& c : world.contacts())
                deepest = std::max(c.penetration_depth(), deepest);
            if (most > 0) {
                EXPECT_GT(deepest, 0.3) << i << " " << turn;
                ++overlapping;
            } else {
                EXPECT_LT(deepest, 1e-5) << i << " " << turn;
                EXPECT_FALSE(world.parting(a, b)) << i << " " << turn;
                ++touching;
            }
        }
    EXPECT_GT(touching, 100);
    EXPECT_GT(overlapping, 50);
}

TEST_P(CoverageTest, ReprojectedDepthsOfToriAndBunniesAreDistancesToTheSurface) {
    // In bands of distance between the bodies' middles, as parts of the diameter of the ball around
    // them.
    test::Random random(32);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (const char* scene : {"tori", "bunnies"}) {
        const MeshData mesh = scenes::make_scene(scene, {1}).meshes[1].data;
        double diameter = 0;
        for (Vec3f p : mesh.positions) diameter = std::max(diameter, 2 * length(to_double(p)));
        Two plain(GetParam(), vertex_rays, mesh, {}, mesh, {}),
            reprojecting(GetParam(), {.coverage = Coverage::vertices}, mesh, {}, mesh, {});
        for (const auto& [nearest, farthest] : {std::pair{0.05, 0.5}, {0.5, 1.0}}) {
            SCOPED_TRACE(scene + (" at " + std::to_string(nearest)));
            std::vector<double> rays, moved;
            for (int i = 0; i < 200 && moved.size() < 100; ++i) {
                const double apart = random.uniform(nearest, farthest) * diameter;
                const Pose a{{}, random.rotation()},
                    b{apart * random.unit_vector(), random.rotation()};
                for (Two* two : {&plain, &reprojecting}) two->move(a, b);
                add_depth_ratios(plain, rays);
                add_depth_ratios(reprojecting, moved);
            }
            ASSERT_GE(moved.size(), 100u);
            EXPECT_GT(moved.size(), rays.size()) << "some rays leave their own body first";
            EXPECT_GT(quantile(rays, 0.5), 1.02) << "inward rays are longer";
            EXPECT_GT(moved.front(), 1 - 1e-4);
            EXPECT_LT(moved.back(), 1 + 1e-4);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, CoverageTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
