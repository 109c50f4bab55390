// Solids inside themselves, against the winding number by definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "core/device/view.hpp"
#include "core/geometry/solid_angle.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

class SelfOverlapTest : public testing::TestWithParam<test::NamedBackend> {};

/// A torus whose two sides are pushed towards each other by `by`, and a little noise.
std::vector<Vec3f> pinched(const MeshData& torus, double by, test::Random& random) {
    std::vector<Vec3f> positions;
    for (Vec3f f : torus.positions) {
        Vec3d p = to_double(f);
        p.x -= by * std::tanh(p.x / 0.3);
        positions.push_back(to_float(p + random.in_box(0.004)));
    }
    return positions;
}

TEST_P(SelfOverlapTest, VerticesInsideAnotherPartOfTheirBodyAreInContactWithIt) {
    const MeshData torus = scenes::torus(1, 0.3, 32, 14);
    std::size_t contacts = 0;
    for (const double by : {0.0, 0.5, 0.75, 0.85, 0.95}) {
        test::Random random(static_cast<std::uint32_t>(100 * by) + 1);
        SCOPED_TRACE("pushed by " + std::to_string(by) + ", seed " + std::to_string(random.seed()));
        World world(GetParam().make());
        const BodyId body = world.add_deforming_body(world.add_mesh("torus", torus));
        world.set_collision(body, {.self = SelfCollision::on});
        const std::vector<Vec3f> positions = pinched(torus, by, random);
        world.set_positions(body, positions);
        world.detect();

        const Mesh& mesh = world.mesh(world.mesh_of(body));
        std::vector<test::SolidVec> inward;
        const View<const Vec3f> view{positions.data(),
                                     static_cast<std::uint32_t>(positions.size())};
        for (std::uint32_t v = 0; v < positions.size(); ++v)
            inward.push_back(test::exact(-vertex_normal(mesh.view(), view, v)));
        const test::Expected expected = test::expected_self_contacts(
            test::solid_of({positions, torus.triangles}, {}), inward, test::solid_of(torus, {}),
            static_cast<long double>(constants::self_distance * mesh.view().mean_edge_length));
        EXPECT_LT(expected.unclear.size(), positions.size() / 10);
        const auto unclear = [&](std::uint32_t v) {
            return std::ranges::count(expected.unclear, v) > 0;
        };
        std::size_t clear = 0;
        for (const Contact& c : world.contacts()) {
            EXPECT_EQ(c.a, body);
            EXPECT_EQ(c.b, body);
            EXPECT_EQ(c.found, Found::self);
            EXPECT_NEAR(dot(c.point_b - c.point_a, c.normal), c.distance, 1e-12);
            if (unclear(c.vertex)) continue;
            ++clear;
            const auto e = std::ranges::find(expected.contacts, c.vertex,
                                             &test::ExpectedContact::vertex);
            ASSERT_NE(e, expected.contacts.end()) << "false: vertex " << c.vertex;
            EXPECT_EQ(c.triangle, e->triangle);
            EXPECT_NEAR(c.penetration_depth(), static_cast<double>(e->depth), 1e-6);
        }
        EXPECT_EQ(clear,
                  static_cast<std::size_t>(std::ranges::count_if(
                      expected.contacts, [&](const auto& e) { return !unclear(e.vertex); })));
        contacts += clear;
        EXPECT_TRUE(by > 0 || world.contacts().empty());

        World reference(reference_backend());
        const BodyId same = reference.add_deforming_body(reference.add_mesh("torus", torus));
        reference.set_collision(same, {.self = SelfCollision::on});
        reference.set_positions(same, positions);
        reference.detect();
        EXPECT_EQ(contact_hash(world.contacts()), contact_hash(reference.contacts()));
    }
    EXPECT_GT(contacts, 60u);
}

TEST_P(SelfOverlapTest, OthersAreFoundAsBeforeAndOverSteps) {
    const MeshData torus = scenes::torus(1, 0.3, 32, 14);
    for (const Temporal temporal : {Temporal::off, Temporal::certified, Temporal::paper}) {
        for (const Coverage coverage : {Coverage::vertices, Coverage::complete}) {
            const Settings settings{.coverage = coverage, .temporal = temporal};
            World with(GetParam().make(), settings), without(GetParam().make(), settings);
            std::vector<BodyId> bodies;
            for (World* world : {&with, &without}) {
                const MeshId mesh = world->add_mesh("torus", torus);
                for (int k = 0; k < 2; ++k) bodies.push_back(world->add_deforming_body(mesh));
            }
            with.set_collision(bodies[0], {.self = SelfCollision::on});
            std::size_t self = 0;
            for (std::uint32_t frame = 0; frame < 8; ++frame) {
                test::Random random(frame + 1);
                const std::vector<Vec3f> first = pinched(torus, 0.6 + 0.04 * frame, random);
                std::vector<Vec3f> second = pinched(torus, 0, random);
                for (Vec3f& p : second) p.z += 0.5f - 0.02f * static_cast<float>(frame);
                for (World* world : {&with, &without}) {
                    world->set_positions(bodies[0], first);
                    world->set_positions(bodies[1], second);
                    world->detect();
                }
                std::vector<Contact> others;
                for (const Contact& c : with.contacts())
                    if (c.a != c.b) others.push_back(c);
                EXPECT_EQ(contact_hash(others), contact_hash(without.contacts()));
                EXPECT_EQ(with.stats().self_contacts, with.contacts().size() - others.size());
                self += with.stats().self_contacts;
            }
            EXPECT_GT(self, 20u);
        }
    }
}

/// The sum of the solid angles of triangles, as a winding number.
double winding(const std::vector<Vec3f>& positions, std::span<const Triangle> triangles, Vec3d p) {
    double angle = 0;
    for (const Triangle& t : triangles) {
        const auto to = [&](int k) { return to_double(positions[t.vertex[k]]) - p; };
        angle += solid_angle(to(0), to(1), to(2));
    }
    return angle / (4 * std::numbers::pi);
}

TEST_P(SelfOverlapTest, WhereThreePartsOverlapNoVertexIsMissed) {
    const MeshData ball = scenes::sphere(1, 2);
    MeshData mesh = scenes::joined(ball,
                                   {scenes::moved(ball.positions, {10, 0, 0}), ball.triangles});
    mesh = scenes::joined(mesh, {scenes::moved(ball.positions, {20, 0, 0}), ball.triangles});
    const std::size_t vertices = ball.positions.size(), triangles = ball.triangles.size();
    test::Random random(12);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int inside = 0;
    for (int i = 0; i < 20; ++i) {
        std::vector<Vec3f> positions = mesh.positions;
        const Vec3d third = random.in_box(0.9);
        for (std::size_t v = 0; v < vertices; ++v) {
            positions[vertices + v].x -= 10 - 1.2f;
            positions[2 * vertices + v].x -= 20;
            positions[2 * vertices + v] = to_float(to_double(positions[2 * vertices + v]) + third);
        }
        World world(GetParam().make());
        const BodyId body = world.add_deforming_body(world.add_mesh("balls", mesh), positions);
        world.set_collision(body, {.self = SelfCollision::on});
        world.detect();
        std::vector<bool> has_contact(positions.size(), false);
        for (const Contact& c : world.contacts()) {
            has_contact[c.vertex] = true;
            EXPECT_GT(c.penetration_depth(), 0);
        }
        for (std::size_t v = 0; v < positions.size(); ++v) {
            const std::size_t part = v / vertices;
            const Vec3d p = to_double(positions[v]);
            double deepest = 0;
            for (std::size_t other = 0; other < 3; ++other)
                if (other != part)
                    deepest = std::max(
                        winding(positions,
                                std::span(mesh.triangles).subspan(other * triangles, triangles), p),
                        deepest);
            if (deepest > 0.9) ++inside;
            if (deepest > 0.9 || deepest < 0.1) {
                EXPECT_EQ(has_contact[v], deepest > 0.9) << i << " " << v;
            }
        }
    }
    EXPECT_GT(inside, 500);
}

INSTANTIATE_TEST_SUITE_P(Backends, SelfOverlapTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
