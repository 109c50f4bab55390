// Steps that run out of memory.
#include <gtest/gtest.h>

#include <cstdint>
#include <new>
#include <string>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/executor_backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

/// Two squares, one above the other.
MeshData sheet() {
    MeshData mesh;
    for (const float z : {3.0f, 3.2f}) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const float y : {-1.0f, 1.0f})
            for (const float x : {-1.0f, 1.0f}) mesh.positions.push_back({x, y, z});
        mesh.triangles.push_back({{first, first + 1, first + 3}});
        mesh.triangles.push_back({{first, first + 3, first + 2}});
    }
    return mesh;
}

BodyId add_sheet(World& world, const MeshData& mesh) {
    // Where it is, they are nearer than the thickness.
    std::vector<Vec3f> positions = mesh.positions;
    for (std::size_t v = 4; v < positions.size(); ++v) positions[v].z -= 0.19f;
    const BodyId body = world.add_deforming_body(
        world.add_mesh("sheet", mesh, {.inside = Inside::none}), positions);
    world.set_collision(body, {.self = SelfCollision::on, .sheet = true, .thickness = 0.02});
    return body;
}

/// A step that runs out of memory anywhere has no contacts, and the next one is a first one.
TEST(LittleMemoryTest, AStepThatRunsOutOfMemoryIsForgotten) {
    test::Random random(5);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (const Temporal temporal : {Temporal::certified, Temporal::paper}) {
        std::uint32_t lists_left = ~0u;
        const Settings settings{.temporal = temporal};
        World world(test::backend_with_little_memory(lists_left), settings);
        const MeshData cloth = sheet();
        add_sheet(world, cloth);
        const MeshId mesh = world.add_mesh("torus", scenes::torus(1, 0.4, 12, 8));
        const MeshId other = world.add_mesh("ring", scenes::torus(1, 0.3, 30, 12));
        std::vector<BodyId> bodies(6);
        for (BodyId& body : bodies) body = world.add_rigid_body(mesh);
        std::vector<Pose> poses(bodies.size());
        for (Pose& p : poses) p = {random.in_box(1.5), random.rotation()};
        // When a step fails, a body has got another mesh, whose tree is missing.
        const BodyId soft = world.add_deforming_body(mesh);
        int failed = 0;
        for (int step = 0; step < 90; ++step) {
            for (Pose& p : poses) p.position += random.in_box(0.02);
            world.set_poses(bodies, poses);
            const bool has_little = step % 3 == 2;
            if (has_little) {
                const MeshId next = step % 2 == 0 ? mesh : other;
                world.set_mesh(soft, next, world.mesh(next).positions());
            }
            lists_left = has_little ? static_cast<std::uint32_t>(random.integer(0, 35)) : ~0u;
            try {
                world.detect();
            } catch (const std::bad_alloc&) {
                ++failed;
                EXPECT_TRUE(world.contacts().empty());
                lists_left = ~0u;
                if (failed % 2 == 0) {
                    for (Pose& p : poses) p.position += random.in_box(0.02);
                    world.set_poses(bodies, poses);
                }
                world.detect();
                World fresh(settings);
                add_sheet(fresh, cloth);
                const MeshId same = fresh.add_mesh("torus", scenes::torus(1, 0.4, 12, 8));
                for (const Pose& p : poses) fresh.add_rigid_body(same, p);
                fresh.add_deforming_body(
                    fresh.add_mesh("copy", world.mesh(world.mesh_of(soft)).data()));
                fresh.detect();
                ASSERT_EQ(world.contacts().size(), fresh.contacts().size()) << step;
                ASSERT_EQ(contact_hash(world.contacts()), contact_hash(fresh.contacts())) << step;
                for (const Contact& c : world.contacts()) ASSERT_EQ(c.age, 0u);
            }
        }
        EXPECT_GT(failed, 5);
    }
}

}  // namespace
}  // namespace pierce
