// What a world plans for its bodies, and that a plan which is adapted is the one made anew.
#include "pierce/plan.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <iterator>
#include <string_view>
#include <vector>

#include "core/mesh/mesh_view.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

MeshData unit_box() { return scenes::box({0, 0, 0}, {1, 1, 1}); }

TEST(PlanTest, ThePlanFollowsTheBodies) {
    World world;
    const MeshId box = world.add_mesh("box", unit_box());
    const BodyId rigid = world.add_rigid_body(box);
    EXPECT_FALSE(world.plan().measures_deformation);
    EXPECT_FALSE(world.plan().traces_own_exits);
    const BodyId soft = world.add_deforming_body(box);
    EXPECT_TRUE(world.plan().measures_deformation);
    EXPECT_EQ(world.plan().deforming_bodies, 1u);
    world.remove_body(soft);
    EXPECT_FALSE(world.plan().measures_deformation);
    world.remove_body(rigid);
    EXPECT_EQ(world.plan().rigid_bodies, 0u);
}

/// What a plan tells without what tells it from others.
Plan without_revision(Plan plan) {
    plan.revision = 0;
    return plan;
}

// A plan is adapted where bodies get other meshes, and made anew where that changes what steps do.
TEST(PlanTest, APlanIsTheSameHoweverBodiesCameToTheirMeshes) {
    test::Random random(86);
    MeshData open = unit_box(), flat = unit_box();
    open.triangles.pop_back();
    open.triangles.pop_back();
    flat.triangles.push_back({{0, 1, 1}});
    const MeshData shapes[] = {unit_box(), scenes::sphere(1, 1), scenes::sphere(1, 2), open, flat};
    for (int round = 0; round < 10; ++round) {
        const bool deforms = round % 2 == 1;
        const std::size_t bodies = 4, all = std::size(shapes);
        std::vector<std::size_t> shape_of(bodies, 0);
        World world;
        std::vector<MeshId> meshes;
        std::vector<BodyId> ids;
        for (const MeshData& shape : shapes) meshes.push_back(world.add_mesh("shape", shape));
        for (std::size_t b = 0; b < bodies; ++b)
            ids.push_back(deforms ? world.add_deforming_body(meshes[0])
                                  : world.add_rigid_body(meshes[0]));
        world.detect();
        for (int change = 0; change < 6; ++change) {
            for (int k = random.integer(1, 3); k > 0; --k) {
                const auto b = static_cast<std::size_t>(random.integer(0, int{bodies} - 1));
                shape_of[b] = static_cast<std::size_t>(random.integer(0, int{all} - 1));
                if (deforms)
                    world.set_mesh(ids[b], meshes[shape_of[b]], shapes[shape_of[b]].positions);
                else
                    world.set_mesh(ids[b], meshes[shape_of[b]]);
            }
            if (random.integer(0, 2) == 0) world.plan();
            World fresh;
            for (const std::size_t shape : shape_of) {
                const MeshId mesh = fresh.add_mesh("shape", shapes[shape]);
                if (deforms)
                    fresh.add_deforming_body(mesh);
                else
                    fresh.add_rigid_body(mesh);
            }
            EXPECT_EQ(without_revision(world.plan()), without_revision(fresh.plan())) << round;
            world.detect();
            fresh.detect();
            EXPECT_EQ(contact_hash(world.contacts()), contact_hash(fresh.contacts())) << round;
        }
    }
}

// A callback that waited for the mesh would wait for itself.
TEST(PlanTest, AProgressCallbackCannotUseTheMesh) {
    const MeshData small = scenes::sphere(1, 1);
    World world(bvh_backend());
    MeshId mesh;
    BodyId body;
    int refused = 0;
    const auto expect_refused = [&](const auto& call) {
        try {
            call();
            ADD_FAILURE() << "it was not refused";
        } catch (const InputError&) {
            ++refused;
        }
    };
    bool is_added = false;
    mesh = world.add_mesh("large", scenes::sphere(1, 7),
                          {.threads = 1, .progress = [&](std::string_view, double share) {
                               if (!is_added || share == 1) return;
                               expect_refused([&] { world.detect(); });
                               expect_refused([&] { world.add_rigid_body(mesh); });
                               expect_refused([&] { world.remove_body(body); });
                               world.remove_mesh(world.add_mesh("small", small));
                               expect_refused([&] { world.mesh(mesh).view(); });
                               expect_refused([&] { Mesh("other", small, world.mesh(mesh)); });
                           }});
    is_added = true;
    for (const double x : {0.0, 1.5}) body = world.add_rigid_body(mesh, {{x, 0, 0}, {}});
    world.detect();
    EXPECT_GT(refused, 0);
    EXPECT_FALSE(world.contacts().empty());
}

}  // namespace
}  // namespace pierce
