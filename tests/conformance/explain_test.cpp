// Explanations against the contact list and against inside and outside by definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/geometry/closest_point.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

class ExplainTest : public testing::TestWithParam<test::NamedBackend> {};

bool has_contact(const World& world, BodyId of, std::uint32_t vertex) {
    return std::ranges::any_of(world.contacts(), [&](const Contact& c) {
        return !c.is_edge() && c.vertex == vertex && (c.source == Side::a ? c.a : c.b) == of;
    });
}

bool says_inside(Reason reason) {
    return reason == Reason::contact || reason == Reason::own_exit_first ||
           reason == Reason::not_inside_own;
}

TEST_P(ExplainTest, AgreesWithContactsAndWithInsideAndOutside) {
    test::Random random(31);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::map<Reason, int> seen;
    std::map<Certificate::Kind, int> certificates;
    for (int i = 0; i < 24 && !HasFailure(); ++i) {
        Settings settings;
        settings.temporal = i % 4 == 0 ? Temporal::off : Temporal::certified;
        settings.coverage = i % 3 == 0 ? Coverage::complete : Coverage::vertices;
        settings.reproject = i % 5 != 0;
        World world(GetParam().make(), settings);
        MeshData shape[2];
        Pose pose[2];
        BodyId body[2];
        const bool deforms = i % 2 == 0;
        for (int k = 0; k < 2; ++k) {
            shape[k] = test::random_closed_mesh(random);
            pose[k] = {random.in_box(0.7), random.rotation()};
            const MeshId mesh = world.add_mesh("shape", shape[k]);
            body[k] = deforms && k == 0
                          ? world.add_deforming_body(mesh, test::placed(shape[k], pose[k]))
                          : world.add_rigid_body(mesh, pose[k]);
        }
        for (int step = 0; step < 3; ++step) {
            pose[0].position += 0.003 * random.in_box(1);
            if (deforms)
                world.set_positions(body[0], test::placed(shape[0], pose[0]));
            else
                world.set_pose(body[0], pose[0]);
            world.detect();
        }
        for (int k = 0; k < 2; ++k) {
            test::Solid other{{}, shape[1 - k].triangles};
            for (std::uint32_t v = 0; v < shape[1 - k].positions.size(); ++v) {
                const Vec3d p = world.vertex_position(body[1 - k], v);
                other.positions.push_back({p.x, p.y, p.z});
            }
            for (std::uint32_t v = 0; v < shape[k].positions.size(); ++v) {
                const Explanation e = world.explain(body[k], body[1 - k], v);
                SCOPED_TRACE("pair " + std::to_string(i) + " side " + std::to_string(k) +
                             " vertex " + std::to_string(v) + ": " + e.text());
                ASSERT_EQ(e.contact.has_value(), has_contact(world, body[k], v));
                ASSERT_EQ(e.reason == Reason::contact, e.contact.has_value());
                ++seen[e.reason];
                ++certificates[e.certificate.kind];
                const Vec3d p = world.vertex_position(body[k], v);
                const bool clear = e.t > 1e-5 || e.distance > 1e-5;
                ASSERT_TRUE(!clear ||
                            says_inside(e.reason) == test::is_inside({p.x, p.y, p.z}, other));
                ASSERT_FALSE(e.certificate.kind != Certificate::none && e.contact);
            }
        }
    }
    for (Reason reason : {Reason::contact, Reason::outside_box, Reason::outside_solid,
                          Reason::entry_first, Reason::nothing_ahead, Reason::own_exit_first})
        EXPECT_GT(seen[reason], 0) << static_cast<int>(reason);
    if (!GetParam().make()->certificates_pay()) return;
    for (Certificate::Kind kind :
         {Certificate::patch, Certificate::patch_rest, Certificate::vertex})
        EXPECT_GT(certificates[kind], 0) << static_cast<int>(kind);
}

TEST_P(ExplainTest, SaysWhyAPairIsNone) {
    World world(GetParam().make());
    const MeshId box = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    const MeshId sheet = world.add_mesh("sheet",
                                        {{{0, 0, 0.5}, {1, 0, 0.5}, {0, 1, 0.5}}, {{{0, 1, 2}}}});
    const BodyId first = world.add_fixed_body(box), second = world.add_fixed_body(box),
                 open = world.add_rigid_body(sheet),
                 far = world.add_rigid_body(box, {{4, 0, 0}, {}});
    const BodyId turned = world.add_rigid_body(
        box, {{1.6, 0.6, 0}, {0, 0, std::sin(M_PI / 8), std::cos(M_PI / 8)}});
    world.detect();
    EXPECT_EQ(world.explain(first, second, 0).reason, Reason::both_fixed);
    EXPECT_EQ(world.explain(first, open, 0).reason, Reason::open_target);
    EXPECT_EQ(world.explain(first, far, 0).reason, Reason::boxes_apart);
    EXPECT_NEAR(world.explain(first, far, 0).distance, 3, 1e-6);
    EXPECT_EQ(world.explain(first, turned, 0).reason, Reason::boxes_apart);
    EXPECT_EQ(world.explain(first, turned, 0).distance, 0) << "only the turned boxes are apart";
    EXPECT_EQ(world.explain(open, first, 0).reason, Reason::contact)
        << "on the box's edge: touching";
    world.set_pose(far, {{std::nan(""), 0, 0}, {}});
    world.detect();
    EXPECT_EQ(world.explain(first, far, 0).reason, Reason::excluded);
    for (const auto& text :
         {world.explain(first, second, 0).text(), world.explain(open, first, 0).text()})
        EXPECT_FALSE(text.empty());
}

// The lower apex of a bipyramid has gone through the upper one: its ray leaves no triangle of its
// own, and ends with the body's box.
TEST_P(ExplainTest, ARayOfABodyThatCrossesItselfEndsWithItsBox) {
    MeshData pyramids;
    for (int i = 0; i < 6; ++i)
        pyramids.positions.push_back(
            to_float(Vec3d{std::cos(i * M_PI / 3), std::sin(i * M_PI / 3), 0}));
    pyramids.positions.push_back({0, 0, 1});
    pyramids.positions.push_back({0, 0, -1});
    for (std::uint32_t i = 0; i < 6; ++i) {
        pyramids.triangles.push_back({{i, (i + 1) % 6, 6}});
        pyramids.triangles.push_back({{(i + 1) % 6, i, 7}});
    }
    World world(GetParam().make(), {.coverage = Coverage::vertices, .reproject = false});
    const BodyId box = world.add_fixed_body(
        world.add_mesh("box", scenes::box({-10.3f, -10.2f, -5}, {9.7f, 9.8f, 15})));
    std::vector<Vec3f> through = pyramids.positions;
    through[7].z = 3;
    const BodyId body = world.add_deforming_body(world.add_mesh("pyramids", pyramids), through);
    world.detect();
    for (std::uint32_t v = 0; v < 8; ++v) {
        const Explanation e = world.explain(body, box, v);
        EXPECT_NE(e.reason, Reason::unexplained) << v;
        EXPECT_TRUE(std::isfinite(e.own_exit)) << v;
    }
    EXPECT_EQ(world.explain(body, box, 6).reason, Reason::own_exit_first);
}

// The numbers of vertices fill a block of patches, or do not.
TEST_P(ExplainTest, AVertexWithoutTrianglesIsNoPartOfItsBody) {
    for (const std::uint32_t around : {16u, 17u}) {
        MeshData ring = scenes::torus(1, 0.4, around, 16);
        ring.positions.push_back(ring.positions[0]);
        World world(GetParam().make());
        const MeshId mesh = world.add_mesh("ring", ring);
        const BodyId a = world.add_rigid_body(mesh),
                     b = world.add_rigid_body(mesh, {{0.9, 0.1, 0.2}, {}});
        world.detect();
        ASSERT_FALSE(world.contacts().empty());
        const auto unused = static_cast<std::uint32_t>(ring.positions.size()) - 1;
        for (const auto& [of, other] : {std::pair{a, b}, std::pair{b, a}}) {
            const Explanation why = world.explain(of, other, unused);
            EXPECT_EQ(why.reason, Reason::no_triangle_names_it) << why.text();
            EXPECT_EQ(why.certificate.kind, Certificate::none);
        }
    }
}

TEST_P(ExplainTest, OpenBodiesRaysAreShort) {
    World world(GetParam().make(), vertex_rays);
    const BodyId block = world.add_fixed_body(
        world.add_mesh("block", scenes::box({-9, -9, -9}, {9, 9, 0})));
    const MeshId sheet = world.add_mesh("sheet",
                                        {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 2, 1}}}});
    const BodyId cloth = world.add_rigid_body(sheet, {{0.3, 0.2, -6}, {}});
    world.detect();
    EXPECT_EQ(world.explain(cloth, block, 0).reason, Reason::beyond_range);
    world.set_pose(cloth, {{0.3, 0.2, -1}, {}});
    world.detect();
    EXPECT_EQ(world.explain(cloth, block, 0).reason, Reason::contact);
}

TEST_P(ExplainTest, AVertexLeftAloneByThePapersModeIsNamed) {
    Settings settings;
    settings.temporal = Temporal::paper;
    settings.predict = false;
    settings.full_every = 1000;
    World world(GetParam().make(), settings);
    const BodyId floor = world.add_fixed_body(
        world.add_mesh("floor", scenes::box({-3, -3, -1}, {3, 3, 0})));
    const BodyId ball = world.add_rigid_body(world.add_mesh("ball", scenes::sphere(1, 3)),
                                             {{0, 0, 0.99}, {}});
    world.detect();
    world.set_pose(ball, {{0, 0, 0.95}, {}});
    world.detect();
    int left_alone = 0;
    for (std::uint32_t v = 0; v < 642; ++v)
        left_alone += world.explain(ball, floor, v).reason == Reason::not_looked_at;
    EXPECT_GT(left_alone, 0);
}

TEST_P(ExplainTest, RefusesWhatThereIsNot) {
    World world(GetParam().make());
    const MeshId box = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    const BodyId a = world.add_rigid_body(box), b = world.add_rigid_body(box);
    EXPECT_THROW(world.explain(a, b, 0), InputError) << "before the first step";
    world.detect();
    EXPECT_THROW(world.explain(a, b, 8), InputError);
    EXPECT_THROW(world.explain(a, a, 0), InputError) << "a solid and itself";
    EXPECT_THROW(world.explain(a, BodyId{}, 0), InputError);
}

/// Two crumpled sheets and a ball: every answer against the contact list and the distance to all
/// triangles.
TEST_P(ExplainTest, OfSheetsAgreesWithContactsAndDistances) {
    test::Random random(33);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    constexpr double thickness = 0.08;
    std::map<Reason, int> seen;
    std::map<Found, int> found;
    const MeshData grid = scenes::grid(1, 1, 8, 8), ball = scenes::sphere(0.3, 2);
    World world(GetParam().make());
    const MeshId mesh = world.add_mesh("sheet", grid);
    std::vector<std::vector<Vec3f>> at;
    std::vector<BodyId> bodies;
    for (int s = 0; s < 2; ++s) {
        at.push_back(test::placed(grid, {{0, 0, 0.32 + 0.1 * s}, {}}));
        bodies.push_back(world.add_deforming_body(mesh, at.back()));
        world.set_collision(bodies.back(),
                            {s == 0 ? SelfCollision::on : SelfCollision::off, true, thickness});
    }
    bodies.push_back(world.add_fixed_body(world.add_mesh("ball", ball)));
    for (int step = 0; step < 8; ++step) {
        for (int s = 0; s < 2; ++s) {
            const std::vector<Vec3f> start = at[static_cast<std::size_t>(s)];
            for (Vec3f& p : at[static_cast<std::size_t>(s)]) p = p + to_float(random.in_box(0.06));
            world.set_motion(bodies[static_cast<std::size_t>(s)], start,
                             at[static_cast<std::size_t>(s)]);
        }
        world.detect();
        for (std::size_t b = 0; b < bodies.size(); ++b)
            for (std::size_t o = 0; o < bodies.size(); ++o) {
                if (b == 2 && o == 2) continue;
                const MeshData& other = o == 2 ? ball : grid;
                for (std::uint32_t v = 0;
                     v < world.mesh(world.mesh_of(bodies[b])).positions().size(); ++v) {
                    const Explanation e = world.explain(bodies[b], bodies[o], v);
                    ++seen[e.reason];
                    const bool has = std::ranges::any_of(world.contacts(), [&](const Contact& c) {
                        return !c.is_edge() && c.vertex == v &&
                               (c.source == Side::a ? c.a : c.b) == bodies[b] &&
                               (c.source == Side::a ? c.b : c.a) == bodies[o];
                    });
                    ASSERT_EQ(e.reason == Reason::contact, has) << e.text();
                    ASSERT_FALSE(e.text().empty());
                    if (has) {
                        ++found[e.contact->found];
                        continue;
                    }
                    ASSERT_EQ(e.reason == Reason::not_looked_for, b == o && b == 1);
                    if (e.reason == Reason::not_looked_for) continue;
                    const Vec3d p = world.vertex_position(bodies[b], v);
                    double distance = 9;
                    for (const Triangle& t : other.triangles) {
                        if (b == o && has_vertex(t, v)) continue;
                        Vec3d c[3];
                        for (int k = 0; k < 3; ++k)
                            c[k] = world.vertex_position(bodies[o], t.vertex[k]);
                        distance = std::min(distance,
                                            length(p - closest_on_triangle(p, c[0], c[1], c[2])));
                    }
                    ASSERT_NEAR(e.distance, distance, 1e-12);
                    ASSERT_EQ(e.reason == Reason::apart, distance >= thickness) << e.text();
                }
            }
    }
    for (Reason r : {Reason::contact, Reason::apart, Reason::beside, Reason::not_looked_for,
                     Reason::close_at_rest})
        EXPECT_GT(seen[r], 0) << static_cast<int>(r);
    for (Found f : {Found::near, Found::crossing, Found::remembered})
        EXPECT_GT(found[f], 0) << static_cast<int>(f);
}

INSTANTIATE_TEST_SUITE_P(Backends, ExplainTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
