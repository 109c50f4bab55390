// What a world plans for its bodies, and that a plan which is adapted is the one made anew.
#include "pierce/plan.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <iterator>
#include <stdexcept>
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
    BodyId first, body;
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
                               expect_refused([&] { world.set_collision(body, {.margin = 1}); });
                               expect_refused([&] { world.set_filter(body, {.world = 3}); });
                               expect_refused([&] { world.exclude(body, first); });
                               expect_refused([&] { world.include(body, first); });
                               expect_refused([&] { world.set_pair_filter({}); });
                               world.remove_mesh(world.add_mesh("small", small));
                               expect_refused([&] { world.mesh(mesh).view(); });
                               expect_refused([&] { Mesh("other", small, world.mesh(mesh)); });
                           }});
    is_added = true;
    first = world.add_rigid_body(mesh);
    body = world.add_rigid_body(mesh, {{1.5, 0, 0}, {}});
    world.detect();
    EXPECT_GT(refused, 0);
    EXPECT_FALSE(world.contacts().empty());
    EXPECT_EQ(world.collision_of(body).margin, Collision{}.margin);
    EXPECT_EQ(world.filter_of(body).world, all_worlds);
    EXPECT_TRUE(world.excluded_pairs().empty());
}

// A callback should not throw; here it stands for memory that runs out.
TEST(PlanTest, MeasuringThatFailsLeavesWhatWasMade) {
    const MeshData large = scenes::sphere(1, 7);
    World world(bvh_backend()), fresh(bvh_backend());
    int thrown = 0;
    const auto progress = [&](std::string_view what, double) {
        if (what == "slabs" && thrown++ == 0) throw std::runtime_error("enough");
    };
    const MeshId mesh = world.add_mesh("large", large, {.threads = 1, .progress = progress});
    const std::vector<BodyId> rigid{world.add_rigid_body(mesh),
                                    world.add_rigid_body(mesh, {{1.5, 0, 0}, {}})};
    EXPECT_THROW(world.detect(), std::runtime_error);
    EXPECT_GT(thrown, 0);
    for (const BodyId body : rigid) world.remove_body(body);
    // These need what was made before, and no slabs.
    MeshData moved = large;
    for (Vec3f& p : moved.positions) p.x += 1.5f;
    const MeshId same = fresh.add_mesh("large", large);
    world.add_deforming_body(mesh);
    world.add_deforming_body(mesh, moved.positions);
    fresh.add_deforming_body(same);
    fresh.add_deforming_body(same, moved.positions);
    world.detect();
    fresh.detect();
    EXPECT_FALSE(world.contacts().empty());
    EXPECT_EQ(world.contacts().size(), fresh.contacts().size());
}

}  // namespace
}  // namespace pierce
