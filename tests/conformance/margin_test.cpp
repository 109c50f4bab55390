// Solids nearer than the margin are in contact with a positive distance, against loops over all
// vertices, edges and triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/geometry/closest_point.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

constexpr double rounding = 1e-6;  ///< what rounding may decide [length, and weight]

class MarginTest : public testing::TestWithParam<test::NamedBackend> {};

/// A body's surface in the world.
struct Placed {
    const Mesh* mesh;
    std::vector<Vec3d> points;
    test::Solid solid;

    Vec3d normal(std::uint32_t t) const {
        const auto& v = mesh->triangles()[t].vertex;
        return normalized(cross(points[v[1]] - points[v[0]], points[v[2]] - points[v[0]]));
    }
};

Placed placed(const World& world, BodyId body) {
    Placed p{&world.mesh(world.mesh_of(body)), {}, {}};
    for (std::uint32_t v = 0; v < p.mesh->positions().size(); ++v)
        p.points.push_back(world.vertex_position(body, v));
    for (Vec3d q : p.points) p.solid.positions.push_back(test::exact(q));
    p.solid.triangles.assign(p.mesh->triangles().begin(), p.mesh->triangles().end());
    return p;
}

double distance_to(const Placed& body, Vec3d p) {
    double least = std::numeric_limits<double>::infinity();
    for (const Triangle& t : body.mesh->triangles())
        least = std::min(least, length(p - closest_on_triangle(p, body.points[t.vertex[0]],
                                                               body.points[t.vertex[1]],
                                                               body.points[t.vertex[2]])));
    return least;
}

enum class Answer { no, yes, unclear };

Answer both(Answer a, Answer b) {
    if (a == Answer::no || b == Answer::no) return Answer::no;
    return a == Answer::yes && b == Answer::yes ? Answer::yes : Answer::unclear;
}
Answer positive(double value) {
    return value > rounding ? Answer::yes : value < -rounding ? Answer::no : Answer::unclear;
}

/// Whether a direction from a point of an edge leads away from both of its triangles, which bend
/// away from each other. Zero counts as away.
Answer faces(const Placed& body, const Edge& edge, Vec3d direction) {
    if (edge.triangle[1] == no_triangle) return Answer::no;
    Answer answer = Answer::yes;
    Vec3d opposite[2];
    for (int k = 0; k < 2; ++k) {
        for (std::uint32_t v : body.mesh->triangles()[edge.triangle[k]].vertex)
            if (v != edge.vertex[0] && v != edge.vertex[1]) opposite[k] = body.points[v];
        const double towards = dot(direction, opposite[k] - body.points[edge.vertex[0]]);
        if (towards > rounding) return Answer::no;
        if (towards > 1e-9) answer = Answer::unclear;
    }
    const double bend = -dot(body.normal(edge.triangle[0]),
                             opposite[1] - body.points[edge.vertex[0]]);
    return bend < 1e-9 ? Answer::no : both(answer, bend < rounding ? Answer::unclear : Answer::yes);
}

/// Whether two edges are closest to each other between their ends, outside, nearer than the margin;
/// for a `sign` of -1, whether they have passed each other by less than it.
Answer are_near(const Placed& a, const Edge& e, const Placed& b, const Edge& f, double margin,
                double sign = 1) {
    const Vec3d p = a.points[e.vertex[0]], u = a.points[e.vertex[1]] - p, q = b.points[f.vertex[0]],
                v = b.points[f.vertex[1]] - q, n = cross(u, v);
    if (length_squared(n) < rounding * length_squared(u) * length_squared(v)) {
        return segment_distance(p, p + u, q, q + v) < margin + rounding ? Answer::unclear
                                                                        : Answer::no;
    }
    const double s = dot(cross(q - p, v), n) / length_squared(n),
                 t = dot(cross(q - p, u), n) / length_squared(n);
    Answer answer = Answer::yes;
    for (double place : {s, 1 - s, t, 1 - t}) answer = both(answer, positive(place));
    const Vec3d way = q + t * v - p - s * u;
    answer = both(answer, both(positive(length(way)), positive(margin - length(way))));
    if (answer == Answer::no) return answer;
    const Vec3d direction = sign * normalized(way);
    return both(answer, both(faces(a, e, direction), faces(b, f, -direction)));
}

const MeshData crate = scenes::box({-0.7, -0.5, -0.6}, {0.5, 0.8, 0.4});

/// Places a second crate such that one of its edges crosses the same edge of a crate at rest:
/// apart, or past it by less than the share of the margin that is kept. Every other time they
/// cross beside an end of both, and either end is inside where they have passed each other.
Pose edge_over_edge(test::Random& random, double margin) {
    const Vec3d middle{0.5, 0.8, -0.1}, along{0, 0, 1}, out = normalized(Vec3d{1, 1, 0});
    // Half a turn about an axis across `out` turns the crate over and its edge aside.
    const double angle = random.uniform(0.3, 1.0);
    const Vec3d axis = std::cos(angle) * cross(out, along) + std::sin(angle) * along;
    const Quaternion half_turn{axis.x, axis.y, axis.z, 0};
    const double gap = random.uniform(-constants::passed_share, 0.1) * margin;
    const double to_end = random.uniform(0.1, 0.9) * std::fabs(gap);
    const double where = random.seed() % 2 == 0 ? random.uniform(-0.1, 0.1) : 0.5 - to_end;
    const Vec3d place = middle + where * along;
    return {place + gap * out - rotation_matrix(half_turn) * place, half_turn};
}

TEST_P(MarginTest, NothingWithinTheMarginIsMissed) {
    constexpr std::uint32_t of_any_shape = 24, crates_anywhere = 460, crates = 520;
    std::size_t vertices = 0, edges = 0, edges_past = 0, crossings_past = 0;
    for (std::uint32_t seed = 1; seed <= crates; ++seed) {
        test::Random random(seed);
        SCOPED_TRACE("seed " + std::to_string(random.seed()));
        const double margin = random.uniform(0.02, seed <= of_any_shape ? 0.4 : 0.9);
        Settings settings;
        settings.margin = seed % 2 == 0 ? margin : 0.0;
        World world(GetParam().make(), settings);
        std::vector<BodyId> ids;
        for (int k = 0; k < 2; ++k) {
            const MeshData mesh = seed <= of_any_shape ? test::random_closed_mesh(random) : crate;
            Pose pose;
            if (seed <= crates_anywhere) {
                if (k == 1)
                    pose.position = random.uniform(0.9, seed <= of_any_shape ? 1.8 : 2.2) *
                                    random.unit_vector();
                pose.rotation = random.rotation();
            } else if (k == 1) {
                pose = edge_over_edge(random, margin);
            }
            const MeshId id = world.add_mesh("mesh", mesh);
            ids.push_back(seed % 3 == 0 ? world.add_deforming_body(id, test::placed(mesh, pose))
                                        : world.add_rigid_body(id, pose));
        }
        if (seed % 2 == 1) world.set_collision(ids[seed % 4 == 1], {.margin = margin});
        world.detect();
        EXPECT_TRUE(world.plan().margins);

        const Placed bodies[2] = {placed(world, ids[0]), placed(world, ids[1])};
        std::map<std::pair<int, std::uint32_t>, const Contact*> of_vertices;
        std::set<std::pair<std::uint32_t, std::uint32_t>> of_edges;
        for (const Contact& c : world.contacts()) {
            EXPECT_NEAR(dot(c.point_b - c.point_a, c.normal), c.distance, 1e-9);
            EXPECT_NEAR(length(c.normal), 1, 1e-12);
            if (c.found != Found::near) continue;
            EXPECT_GE(c.distance, c.is_edge() ? -margin : 0);
            EXPECT_LT(c.distance, margin);
            EXPECT_NEAR(length(c.point_b - c.point_a), std::fabs(c.distance), 1e-9);
            if (c.is_edge()) {
                EXPECT_EQ(c.source, Side::a);
                EXPECT_TRUE(of_edges.emplace(c.edge, c.other_edge).second);
            } else {
                of_vertices[{static_cast<int>(c.source), c.vertex}] = &c;
            }
        }
        for (int side = 0; side < 2; ++side)
            for (std::uint32_t v = 0; v < bodies[side].points.size(); ++v) {
                const Vec3d p = bodies[side].points[v];
                const double distance = distance_to(bodies[1 - side], p);
                if (distance < rounding || std::fabs(distance - margin) < rounding) continue;
                const auto found = of_vertices.find({side, v});
                const bool expected = distance < margin &&
                                      !test::is_inside(test::exact(p), bodies[1 - side].solid);
                ASSERT_EQ(found != of_vertices.end(), expected) << side << " vertex " << v;
                if (!expected) continue;
                ++vertices;
                EXPECT_NEAR(found->second->distance, distance, 1e-9);
            }
        double deepest = 0;
        bool in_contact = false;
        for (const Contact& c : world.contacts())
            if (c.found != Found::near && c.found != Found::separation) {
                deepest = std::max(deepest, c.penetration_depth());
                in_contact = true;
            }
        const MeshView a = bodies[0].mesh->view(), b = bodies[1].mesh->view();
        // Touch tolerances decide between the two.
        const double share = constants::passed_share * margin,
                     as_deep = constants::passed_depths * deepest,
                     touches = 4 * constants::skin * constants::touch_tolerance *
                               std::max(a.box.extent(), b.box.extent());
        const bool may_pass = in_contact && deepest <= share;
        const double least = may_pass ? std::min(share, as_deep) : 0.0,
                     most = may_pass ? std::min(share, as_deep + touches) : 0.0;
        if (std::fabs(deepest - share) < rounding) continue;
        for (std::uint32_t e = 0; e < a.edges.size; ++e)
            for (std::uint32_t f = 0; f < b.edges.size; ++f) {
                const Answer near = are_near(bodies[0], a.edges[e], bodies[1], b.edges[f], margin),
                             past = are_near(bodies[0], a.edges[e], bodies[1], b.edges[f], least,
                                             -1);
                if (near == Answer::unclear || past == Answer::unclear ||
                    past != are_near(bodies[0], a.edges[e], bodies[1], b.edges[f], most, -1))
                    continue;
                const bool is_chord = past == Answer::yes &&
                                      std::ranges::any_of(world.contacts(), [&](const Contact& c) {
                                          return c.is_edge() && c.found != Found::near &&
                                                 c.edge == (c.source == Side::a ? e : f);
                                      });
                crossings_past += is_chord;
                if (is_chord) continue;
                ASSERT_EQ(of_edges.contains({e, f}), near == Answer::yes || past == Answer::yes)
                    << "edges " << e << " and " << f;
                edges += near == Answer::yes;
                edges_past += past == Answer::yes;
            }
    }
    EXPECT_GT(vertices, 300u);
    EXPECT_GT(edges, 30u);
    EXPECT_GT(edges_past, 10u);
    EXPECT_GT(crossings_past, 20u);
}

TEST_P(MarginTest, StatisticsForgetAMarginThatIsGone) {
    test::Random random(1);
    World world(GetParam().make());
    const MeshId mesh = world.add_mesh("crate", crate);
    const BodyId body = world.add_rigid_body(mesh);
    Pose above = edge_over_edge(random, 0.2);
    above.position += Vec3d{0.1, 0.1, 0};
    world.add_rigid_body(mesh, above);
    world.set_collision(body, {.margin = 0.4});
    EXPECT_EQ(world.detect().chords, 0u);
    EXPECT_TRUE(std::ranges::any_of(world.contacts(), &Contact::is_edge));
    world.set_collision(body, {});
    EXPECT_EQ(world.detect().chords, 0u);
    EXPECT_EQ(world.stats().contacts, 0u);
}

/// Its ridge runs along y, and its sides go down.
MeshData roof() {
    return {{{0, -2, 0}, {0, 2, 0}, {0.5, -2, -1}, {0.5, 2, -1}, {-0.5, -2, -1}, {-0.5, 2, -1}},
            {{{0, 2, 3}},
             {{0, 3, 1}},
             {{0, 1, 5}},
             {{0, 5, 4}},
             {{2, 4, 5}},
             {{2, 5, 3}},
             {{0, 4, 2}},
             {{1, 3, 5}}}};
}

TEST_P(MarginTest, AContactGoesThroughTouchWithoutAJump) {
    // A tetrahedron's tip comes down on a face, and then an edge on an edge.
    const MeshData box = scenes::box({-1, -1, -1}, {1, 1, 0});
    MeshData tip{{{0, 0, 0}, {-0.25f, 0.25f, 1}, {0.25f, 0.25f, 1}, {0, -0.25f, 1}},
                 {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 1, 3}}, {{1, 2, 3}}}};
    MeshData blade{
        {{-2, 0, 0}, {2, 0, 0}, {-2, -0.25f, 1}, {2, -0.25f, 1}, {-2, 0.25f, 1}, {2, 0.25f, 1}},
        {{{0, 2, 3}},
         {{0, 3, 1}},
         {{0, 1, 5}},
         {{0, 5, 4}},
         {{2, 4, 5}},
         {{2, 5, 3}},
         {{0, 4, 2}},
         {{1, 3, 5}}}};
    for (MeshData* mesh : {&tip, &blade})
        for (Triangle& t : mesh->triangles) std::swap(t.vertex[1], t.vertex[2]);
    const Pose across{{0, 0, 0}, {0, 0, 0.25f, 1}};
    for (const bool edges : {false, true}) {
        Settings settings;
        settings.margin = 0.1;
        World world(GetParam().make(), settings);
        world.add_fixed_body(world.add_mesh("below", edges ? roof() : box));
        const BodyId above = world.add_rigid_body(world.add_mesh("above", edges ? blade : tip));
        std::vector<Contact> last;
        for (int step = 0; step <= 40; ++step) {
            const double height = 0.02 - 0.001 * step;
            world.set_pose(above, {{0.1, 0.05, height}, across.rotation});
            world.detect();
            const auto deepest = std::ranges::min_element(world.contacts(), {}, &Contact::distance);
            ASSERT_NE(deepest, world.contacts().end()) << "step " << step;
            EXPECT_EQ(deepest->is_edge(), edges);
            EXPECT_NEAR(deepest->distance, height, 1e-6) << "step " << step;
            if (!last.empty()) {
                EXPECT_LT(length(deepest->normal - last[0].normal), 1e-6);
                EXPECT_LT(length(deepest->point_a - last[0].point_a), 0.0025);
                EXPECT_LT(length(deepest->point_b - last[0].point_b), 0.0025);
                EXPECT_TRUE(edges || deepest->feature() == last[0].feature());
            }
            last = {*deepest};
        }
    }
}

TEST_P(MarginTest, BackendsAndMemoriesAgree) {
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
        test::Random random(seed);
        SCOPED_TRACE("seed " + std::to_string(random.seed()));
        std::vector<MeshData> meshes;
        std::vector<Pose> poses;
        for (int k = 0; k < 6; ++k) {
            meshes.push_back(k % 2 == 0 ? scenes::box({-0.5, -0.4, -0.3}, {0.5, 0.4, 0.3})
                                        : scenes::torus(0.5, 0.2, 10, 6));
            poses.push_back({random.in_box(1), random.rotation()});
        }
        for (const Coverage coverage :
             {Coverage::vertices, Coverage::overlaps, Coverage::complete}) {
            Settings settings;
            settings.coverage = coverage;
            settings.margin = 0.1;
            Settings forgetful = settings;
            forgetful.temporal = Temporal::off;
            World worlds[2] = {World(GetParam().make(), settings),
                               World(reference_backend(), forgetful)};
            std::vector<BodyId> bodies;
            for (World& world : worlds) {
                bodies.clear();
                for (std::size_t k = 0; k < meshes.size(); ++k) {
                    const MeshId id = world.add_mesh("mesh", meshes[k]);
                    bodies.push_back(
                        k < 2 ? world.add_deforming_body(id, test::placed(meshes[k], poses[k]))
                              : world.add_rigid_body(id, poses[k]));
                }
            }
            std::vector<Pose> now = poses;
            std::size_t near = 0;
            for (int step = 0; step < 5; ++step) {
                for (World& world : worlds) world.detect();
                ASSERT_EQ(contact_hash(worlds[0].contacts()), contact_hash(worlds[1].contacts()))
                    << "step " << step << ", coverage " << static_cast<int>(coverage);
                for (const Contact& c : worlds[0].contacts()) near += c.found == Found::near;
                std::set<std::tuple<BodyId, BodyId, std::uint64_t>> features;
                for (const Contact& c : worlds[0].contacts())
                    EXPECT_TRUE(features.emplace(c.a, c.b, c.feature()).second);
                // Nothing moves in the last step.
                for (std::size_t k = 1; k < now.size() && step < 3; ++k) {
                    now[k].position += random.in_box(0.02);
                    for (World& world : worlds)
                        if (k < 2)
                            world.set_positions(bodies[k], test::placed(meshes[k], now[k]));
                        else
                            world.set_pose(bodies[k], now[k]);
                }
            }
            EXPECT_GT(near, 50u);
        }
    }
}

TEST_P(MarginTest, WhatTouchesHasTheNormalOfTheSurface) {
    const MeshData plate = scenes::box({-2, -2, -1}, {2, 2, 0}),
                   cube = scenes::box({-0.5, -0.5, 0}, {0.5, 0.5, 1});
    for (const double margin : {0.0, 0.1})
        for (const Coverage coverage : {Coverage::vertices, Coverage::overlaps, Coverage::complete})
            for (const bool equal : {false, true}) {
                Settings settings;
                settings.margin = margin;
                settings.coverage = coverage;
                World world(GetParam().make(), settings);
                world.add_fixed_body(world.add_mesh(
                    "below", equal ? scenes::box({-0.5, -0.5, -1}, {0.5, 0.5, 0}) : plate));
                const BodyId above = world.add_rigid_body(world.add_mesh("cube", cube));
                for (const double height : {1e-6, 1e-7, 0.0, -1e-7, -1e-6}) {
                    SCOPED_TRACE(testing::Message() << "margin " << margin << ", height " << height
                                                    << (equal ? ", equal boxes" : ""));
                    world.set_pose(above, {{0, 0, height}, {}});
                    world.detect();
                    if (margin > 0 || (height <= 0 && !equal)) {
                        EXPECT_GE(world.contacts().size(), 4u);
                    }
                    // A vertex of one box that has gone into the other one touches its sides, too.
                    for (const Contact& c : world.contacts()) {
                        const bool is_side = equal && height < 0 && !(c.distance < 0);
                        EXPECT_NEAR(is_side ? 1 : std::fabs(c.normal.z), 1, 1e-6) << c.vertex;
                    }
                }
            }
}

TEST_P(MarginTest, EdgesThatTouchAreInContact) {
    // Two roofs, the ridge of one across that of the other.
    for (const double size : {1.0, 1024.0}) {
        Settings settings;
        settings.margin = 0.1 * size;
        settings.coverage = Coverage::complete;
        World world(GetParam().make(), settings);
        MeshData below = roof(), above;
        for (Vec3f& p : below.positions) p = static_cast<float>(size) * p;
        above = below;
        for (Vec3f& p : above.positions) p = {p.y, p.x, -p.z};
        world.add_fixed_body(world.add_mesh("below", below));
        const BodyId body = world.add_rigid_body(world.add_mesh("above", above));
        std::uint32_t age = 0;
        for (const double gap : {1e-4, 4e-6, 2e-6, 1e-6, 1e-7, 0.0, -1e-7, -1e-6}) {
            SCOPED_TRACE(testing::Message() << "size " << size << ", gap " << gap);
            world.set_pose(body, {{0.25 * size, 0.125 * size, gap * size}, {}});
            world.detect();
            ASSERT_EQ(world.contacts().size(), 1u);
            const Contact& c = world.contacts()[0];
            EXPECT_TRUE(c.is_edge());
            EXPECT_NEAR(c.distance, gap * size, 5e-6 * size);
            EXPECT_NEAR(c.normal.z, 1, 1e-6);
            EXPECT_EQ(c.age, age++);
        }
    }
}

/// Two boxes that rest on each other corner over edge: two vertices and two crossings of edges hold
/// the upper one, before they touch and after.
TEST_P(MarginTest, CrossingsOfEdgesStayInContactAsTheyPass) {
    const MeshData cube = scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
    for (const bool deforms : {false, true})
        for (const double slope : {0.0, 0.002}) {
            World world(GetParam().make(), {.margin = 0.05});
            const MeshId mesh = world.add_mesh("cube", cube);
            world.add_fixed_body(mesh);
            const BodyId above = deforms ? world.add_deforming_body(mesh)
                                         : world.add_rigid_body(mesh);
            std::uint32_t age = 0;
            for (const double height : {1.03, 1.01, 1.004, 1.0, 0.9999, 0.997, 0.993, 0.991}) {
                SCOPED_TRACE(testing::Message() << "slope " << slope << ", height " << height);
                const Pose pose{{0.3, 0.2, height}, {slope, slope, 0, 1}};
                if (deforms)
                    world.set_positions(above, test::placed(cube, pose));
                else
                    world.set_pose(above, pose);
                world.detect();
                // A box that leans meets one of the two edges along its face. Where no vertex is
                // inside, the other body's edge has a contact there, too.
                std::size_t vertices = 0, crossings = 0;
                for (const Contact& c : world.contacts()) {
                    EXPECT_GT(c.normal.z, 0.99);
                    EXPECT_NEAR(c.distance, height - 1, 0.006);
                    if (c.is_edge() && c.source == Side::b) continue;
                    EXPECT_EQ(c.age, age);
                    ++(c.is_edge() ? crossings : vertices);
                }
                EXPECT_EQ(vertices, 2u);
                EXPECT_EQ(crossings, slope > 0 ? 1u : 2u);
                ++age;
            }
        }
}

TEST_P(MarginTest, BodiesThatTouchAreInContactOnce) {
    const MeshData box = scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
    Settings settings;
    settings.margin = 0.1;
    World world(GetParam().make(), settings);
    const MeshId mesh = world.add_mesh("box", box);
    const BodyId a = world.add_rigid_body(mesh), b = world.add_rigid_body(mesh, {{1, 0, 0}, {}});
    world.detect();
    std::set<std::uint64_t> features;
    for (const Contact& c : world.contacts())
        EXPECT_TRUE(features.insert(c.feature()).second) << "vertex " << c.vertex;
    EXPECT_GE(world.contacts().size(), 4u);

    // Margins change: what is remembered is not taken over.
    world.set_pose(b, {{1.05, 0, 0}, {}});
    world.detect();
    EXPECT_GE(world.contacts().size(), 8u);
    for (BodyId body : {a, b}) world.set_collision(body, {.margin = 0.02});
    world.detect();
    EXPECT_TRUE(world.contacts().empty());
    world.set_collision(a, {.margin = 0.06});
    world.detect();
    EXPECT_GE(world.contacts().size(), 8u);
    EXPECT_NE(world.explain(a, b, world.contacts()[0].vertex).text().find("closer than the margin"),
              std::string::npos);

    std::stringstream file;
    world.save(file);
    World restored = World::restore(file, GetParam().make());
    world.detect();
    restored.detect();
    EXPECT_EQ(contact_hash(world.contacts()), contact_hash(restored.contacts()));

    EXPECT_THROW(world.set_collision(a, {.margin = NAN}), InputError);
    settings.margin = -1;
    EXPECT_THROW(World(GetParam().make(), settings), InputError);
}

TEST_P(MarginTest, WithoutOneNothingIsLookedFor) {
    World world(GetParam().make());
    const MeshId mesh = world.add_mesh("box", scenes::box({-1, -1, -1}, {1, 1, 1}));
    world.add_rigid_body(mesh);
    world.add_rigid_body(mesh, {{2.001, 0, 0}, {}});
    world.detect();
    EXPECT_TRUE(world.contacts().empty());
    EXPECT_FALSE(world.plan().needs(StageId::margin));
}

INSTANTIATE_TEST_SUITE_P(Backends, MarginTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
