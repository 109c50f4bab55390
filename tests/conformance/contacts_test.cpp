// Contacts against their definition, found again in long double by tests/support/brute_force.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>

#include "pierce/contact_hash.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using test::exact;
using test::Solid;
using test::solid_of;
using test::SolidVec;

std::vector<SolidVec> inward_of(const Mesh& mesh, const Pose& pose) {
    const Frame frame = frame_of(pose);
    std::vector<SolidVec> inward;
    for (Vec3f n : mesh.normals())
        inward.push_back(exact(-1.0 * normalized(frame.rotation * to_double(n))));
    return inward;
}

class ContactsTest : public testing::TestWithParam<test::NamedBackend> {};

/// Both directions of one pair against the definition.
void expect_defined_contacts(World& world, BodyId a, BodyId b, const std::array<Solid, 2>& solid,
                             const std::array<std::vector<SolidVec>, 2>& inward) {
    for (int side = 0; side < 2; ++side) {
        const test::Expected expected = test::expected_contacts(solid[side], inward[side],
                                                                solid[1 - side]);
        std::vector<Contact> found;
        for (const Contact& c : world.contacts())
            if (static_cast<int>(c.source) == side) found.push_back(c);
        const auto unclear = [&](std::uint32_t v) {
            return std::ranges::binary_search(expected.unclear, v);
        };
        for (const test::ExpectedContact& e : expected.contacts) {
            const auto it = std::ranges::find(found, e.vertex, &Contact::vertex);
            ASSERT_NE(it, found.end()) << "missing: side " << side << " vertex " << e.vertex
                                       << " depth " << (double)e.depth;
            EXPECT_EQ(it->triangle, e.triangle);
            EXPECT_NEAR(it->penetration_depth(), static_cast<double>(e.depth), 1e-6);
        }
        for (const Contact& c : found) {
            EXPECT_EQ(c.a, a);
            EXPECT_EQ(c.b, b);
            EXPECT_TRUE(unclear(c.vertex) ||
                        std::ranges::any_of(expected.contacts,
                                            [&](const auto& e) { return e.vertex == c.vertex; }))
                << "false: side " << side << " vertex " << c.vertex;
            // The segment lies in both bodies and ends on the target.
            if (unclear(c.vertex)) continue;
            const SolidVec p = exact(side == 0 ? c.point_a : c.point_b),
                           q = exact(side == 0 ? c.point_b : c.point_a);
            const long double margin = std::min(
                0.4L, 1e-4L / std::max(static_cast<long double>(c.penetration_depth()), 1e-9L));
            EXPECT_EQ(test::crossings_between(p, q, solid[1 - side], ~0u, margin), 0);
            EXPECT_EQ(test::crossings_between(p, q, solid[side], c.vertex, margin), 0);
            if (c.penetration_depth() > 1e-3) {
                const SolidVec middle{(p.x + q.x) / 2, (p.y + q.y) / 2, (p.z + q.z) / 2};
                EXPECT_TRUE(test::is_inside(middle, solid[0]));
                EXPECT_TRUE(test::is_inside(middle, solid[1]));
            }
            EXPECT_NEAR(dot(c.point_b - c.point_a, c.normal), c.distance, 1e-6);
        }
    }
}

TEST_P(ContactsTest, RandomRigidPairsMatchTheDefinition) {
    test::Random random(20240501);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t contacts = 0;
    for (int i = 0; i < 60 && !HasFailure(); ++i) {
        SCOPED_TRACE("pair " + std::to_string(i));
        World world(GetParam().make(), vertex_rays);
        const MeshData data[2] = {test::random_closed_mesh(random),
                                  test::random_closed_mesh(random)};
        const Pose pose[2] = {{random.in_box(0.6), random.rotation()},
                              {random.in_box(0.6), random.rotation()}};
        const MeshId mesh[2] = {world.add_mesh("first", data[0]),
                                world.add_mesh("second", data[1])};
        const BodyId a = world.add_rigid_body(mesh[0], pose[0]),
                     b = world.add_rigid_body(mesh[1], pose[1]);
        world.detect();
        contacts += world.contacts().size();
        expect_defined_contacts(
            world, a, b, {solid_of(data[0], pose[0]), solid_of(data[1], pose[1])},
            {inward_of(world.mesh(mesh[0]), pose[0]), inward_of(world.mesh(mesh[1]), pose[1])});
    }
    EXPECT_GT(contacts, 1000u);
}

TEST_P(ContactsTest, RandomDeformingPairsMatchTheDefinition) {
    test::Random random(77);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t contacts = 0;
    for (int i = 0; i < 60 && !HasFailure(); ++i) {
        SCOPED_TRACE("pair " + std::to_string(i));
        World world(GetParam().make(), vertex_rays);
        std::array<Solid, 2> solid;
        std::array<std::vector<SolidVec>, 2> inward;
        BodyId body[2];
        for (int k = 0; k < 2; ++k) {
            MeshData data = test::random_closed_mesh(random);
            const MeshId rest = world.add_mesh("rest", data);
            // Stretch, then place, so that the body is far from its rest shape.
            const double stretch = random.uniform(0.6, 1.6);
            for (Vec3f& p : data.positions) p.x *= static_cast<float>(stretch);
            data.positions = test::placed(data, {random.in_box(0.6), random.rotation()});
            body[k] = world.add_deforming_body(rest, data.positions);
            solid[k] = solid_of(data, {});
            inward[k] = inward_of(Mesh("now", data), {});
        }
        world.detect();
        contacts += world.contacts().size();
        expect_defined_contacts(world, body[0], body[1], solid, inward);
    }
    EXPECT_GT(contacts, 1000u);
}

/// A pyramid over a U-shaped base with its apex above the gap: straight down from the apex is
/// outside, although all normals around it point up. With `floor`, the same mesh has a box below
/// that this ray enters.
MeshData u_pyramid(bool floor) {
    MeshData mesh{{{0, 1, 0},
                   {-5, -5, -1},
                   {5, -5, -1},
                   {5, 5, -1},
                   {1, 5, -1},
                   {1, -1, -1},
                   {-1, -1, -1},
                   {-1, 5, -1},
                   {-5, 5, -1}},
                  {}};
    for (std::uint32_t k = 1; k <= 8; ++k) mesh.triangles.push_back({{0, k, k % 8 + 1}});
    for (Triangle t :
         {Triangle{{1, 5, 2}}, {{1, 6, 5}}, {{2, 4, 3}}, {{2, 5, 4}}, {{1, 7, 6}}, {{1, 8, 7}}})
        mesh.triangles.push_back(t);
    if (!floor) return mesh;
    const MeshData below = scenes::box({-4, -4, -3}, {4, 4.5, -2});
    for (Triangle t : below.triangles)
        mesh.triangles.push_back({{t.vertex[0] + 9, t.vertex[1] + 9, t.vertex[2] + 9}});
    mesh.positions.insert(mesh.positions.end(), below.positions.begin(), below.positions.end());
    return mesh;
}

TEST_P(ContactsTest, ARayThatStartsOutsideItsOwnBodyIsNoContact) {
    const MeshData slab = scenes::box({-9, -9.5, -0.3}, {9, 8.7, 0.4});
    for (bool floor : {false, true}) {
        const MeshData pyramid = u_pyramid(floor);
        ASSERT_TRUE(Mesh("pyramid", pyramid).traits().closed());
        ASSERT_GT(Mesh("pyramid", pyramid).traits().volume, 0);
        for (bool deforming : {false, true}) {
            World world(GetParam().make(), vertex_rays);
            const MeshId a = world.add_mesh("pyramid", pyramid), b = world.add_mesh("slab", slab);
            const BodyId first = deforming ? world.add_deforming_body(a) : world.add_rigid_body(a);
            const BodyId second = world.add_fixed_body(b);
            world.detect();
            EXPECT_TRUE(world.contacts().empty()) << "only the apex is inside the slab";
            expect_defined_contacts(world, first, second,
                                    {solid_of(pyramid, {}), solid_of(slab, {})},
                                    {inward_of(world.mesh(a), {}), inward_of(world.mesh(b), {})});
        }
    }
}

TEST_P(ContactsTest, ASmallBodyAtACornerOfAHugeOne) {
    // The huge body's vertices share a patch whose centre is half a million units away from each of
    // them.
    const MeshData huge = scenes::box({0, 0, 0}, {0x1p20, 0x1p20, 0x1p20}),
                   small = scenes::sphere(0.1, 2);
    for (bool deforming : {false, true})
        for (int i = 0; i < 8; ++i) {
            // The corner is just inside the ball, at a place where float32 far from it sees it a
            // few hundredths off.
            const Vec3d inward = normalized(Vec3d{1.0, 1.0 + 0.1 * i, 1.0});
            const Pose pose{-0.095 * inward, {}};
            World world(GetParam().make(), vertex_rays);
            const MeshId mesh = world.add_mesh("huge", huge);
            const BodyId a = deforming ? world.add_deforming_body(mesh)
                                       : world.add_rigid_body(mesh);
            const BodyId b = world.add_rigid_body(world.add_mesh("small", small), pose);
            world.detect();
            EXPECT_TRUE(std::ranges::any_of(world.contacts(),
                                            [](const Contact& c) { return c.source == Side::a; }));
            expect_defined_contacts(
                world, a, b, {solid_of(huge, {}), solid_of(small, pose)},
                {inward_of(world.mesh(mesh), {}), inward_of(world.mesh(world.mesh_of(b)), pose)});
        }
}

TEST_P(ContactsTest, AFlattenedBodyIsSeenAsThinAsItIs) {
    MeshData ball = scenes::sphere(1, 3);
    World world(GetParam().make(), vertex_rays);
    const MeshId rest = world.add_mesh("ball", ball);
    const MeshData block = scenes::box({-2, -2, -1.03}, {2, 2, 1.1});
    const BodyId fixed = world.add_fixed_body(world.add_mesh("block", block));
    // Thinner than it is deep inside the block: most rays leave it before they leave the block.
    for (Vec3f& p : ball.positions) p.z *= 0.02f;
    const BodyId flat = world.add_deforming_body(rest, ball.positions);
    for (float height : {0.0f, -1.02f}) {
        for (Vec3f& p : ball.positions) p.z += height;
        world.set_positions(flat, ball.positions);
        world.detect();
        expect_defined_contacts(
            world, fixed, flat, {solid_of(block, {}), solid_of(ball, {})},
            {inward_of(world.mesh(world.mesh_of(fixed)), {}), inward_of(Mesh("now", ball), {})});
    }
    EXPECT_GT(world.contacts().size(), 20u) << "down at the block's face";
    EXPECT_LT(world.contacts().size(), ball.positions.size());
}

TEST_P(ContactsTest, WhatTheyAddUpToIsSaid) {
    test::Random random(31);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    World world(GetParam().make(), vertex_rays);
    const MeshId mesh = world.add_mesh("torus", scenes::torus(0.6, 0.3, 20, 12));
    std::vector<BodyId> bodies;
    for (int b = 0; b < 12; ++b)
        bodies.push_back(world.add_rigid_body(mesh, {random.in_box(0.8), random.rotation()}));
    std::size_t touching = 0;
    // Now and then nothing moves, and contacts may be kept as they are.
    for (int step = 0; step < 12; ++step) {
        SCOPED_TRACE("step " + std::to_string(step));
        if (step % 3 != 2)
            for (BodyId body : bodies)
                world.set_pose(body, {random.in_box(0.8), random.rotation()});
        world.detect();
        std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
        double deepest = 0, sum = 0;
        for (const Contact& c : world.contacts()) {
            pairs.insert({c.a.index, c.b.index});
            deepest = std::max(c.penetration_depth(), deepest);
            sum += c.penetration_depth();
        }
        const StepStats& stats = world.stats();
        ASSERT_EQ(stats.contacts, world.contacts().size());
        ASSERT_EQ(stats.touching_pairs, pairs.size());
        ASSERT_EQ(stats.penetration_max, deepest);
        ASSERT_NEAR(stats.penetration_mean, sum / static_cast<double>(world.contacts().size()),
                    1e-12);
        touching += pairs.size();
    }
    EXPECT_GT(touching, 100u);
}

INSTANTIATE_TEST_SUITE_P(Backends, ContactsTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
