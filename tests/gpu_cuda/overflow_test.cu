// Bodies that are apart until steps are captured, and then all meet at once: lists of every stage
// outgrow their room, and the step is taken once more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/cuda_backend.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

class OverflowTest : public testing::Test {
protected:
    static constexpr int steps_apart = 8;

    void SetUp() override {
        if (!cuda_problem().empty()) GTEST_SKIP() << cuda_problem();
    }

    /// Steps both worlds with bodies far apart, then close together, then apart again.
    void play(int bodies, const Settings& settings, const MeshData& shape, bool deforms,
              const Collision& collision, std::size_t least) {
        World there(cuda_backend(), settings), here(bvh_backend(), settings);
        std::vector<BodyId> ids[2];
        for (World* world : {&there, &here})
            for (int b = 0; b < bodies; ++b) {
                const MeshId mesh = world->add_mesh("shape", shape);
                const BodyId body = deforms ? world->add_deforming_body(mesh)
                                            : world->add_rigid_body(mesh);
                if (deforms) world->set_collision(body, collision);
                ids[world == &here].push_back(body);
            }
        test::Random random(17);
        std::size_t most = 0;
        for (int step = 0; step < steps_apart + 5; ++step) {
            const bool together = step >= steps_apart && step < steps_apart + 3;
            const double spread = together ? 0.6 : 8;
            for (int b = 0; b < bodies; ++b) {
                const Pose pose{spread * Vec3d{double(b % 3), double(b / 3 % 3), double(b / 9)} +
                                    random.in_box(0.05),
                                random.rotation()};
                for (World* world : {&there, &here}) {
                    const BodyId body = ids[world == &here][static_cast<std::size_t>(b)];
                    if (!deforms) {
                        world->set_pose(body, pose);
                        continue;
                    }
                    std::vector<Vec3f> positions = test::placed(shape, pose);
                    // Solids are folded into themselves, too.
                    if (together && collision.self == SelfCollision::on && !collision.sheet)
                        for (Vec3f& p : positions)
                            p.x = static_cast<float>(0.3 * std::fabs(static_cast<double>(p.x)));
                    world->set_positions(body, positions);
                }
            }
            there.detect();
            here.detect();
            ASSERT_EQ(there.contacts().size(), here.contacts().size()) << "step " << step;
            ASSERT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts()))
                << "step " << step;
            most = std::max(most, here.contacts().size());
        }
        EXPECT_GT(most, least) << "more than a list has room for at first";
    }

    const MeshData ring = scenes::torus(1, 0.4, 18, 10);
};

TEST_F(OverflowTest, RigidBodiesAndMargins) {
    play(18, {.coverage = Coverage::complete, .margin = 0.1}, ring, false, {}, 8000);
}

TEST_F(OverflowTest, RigidBodiesAndTheirMemory) {
    play(18, {.temporal = Temporal::paper}, ring, false, {}, 4000);
}

TEST_F(OverflowTest, SoftBodiesAndThemselves) {
    play(18, {.coverage = Coverage::complete}, ring, true, {.self = SelfCollision::on}, 6000);
}

TEST_F(OverflowTest, Sheets) {
    play(8, {}, scenes::grid(2, 2, 8, 8), true,
         {.self = SelfCollision::on, .sheet = true, .thickness = 0.02}, 4000);
}

// A ray that leaves many layers of its own body is followed for as many rounds.
TEST_F(OverflowTest, ASolidOfManyLayers) {
    constexpr int layers = 120;
    MeshData stack;
    for (int k = 0; k < layers; ++k) {
        MeshData lens = scenes::geodesic_sphere(1, 4);
        for (Vec3f& p : lens.positions) p.z = 0.25f * p.z + static_cast<float>(2 * k);
        stack = scenes::joined(std::move(stack), lens);
    }
    const std::size_t of_layer = stack.positions.size() / layers;
    World there(cuda_backend()), here(bvh_backend());
    std::vector<BodyId> ids;
    for (World* world : {&there, &here}) {
        ids.push_back(world->add_deforming_body(world->add_mesh("stack", stack)));
        world->set_collision(ids.back(), {.self = SelfCollision::on});
    }
    std::size_t most = 0;
    for (int step = 0; step < 16; ++step) {
        std::vector<Vec3f> positions = stack.positions;
        // The lowest lens rises into the one above it, and stays there until steps are captured.
        for (std::size_t v = 0; v < of_layer; ++v)
            positions[v].z += 0.25f * static_cast<float>(std::min(step, 7));
        there.set_positions(ids[0], positions);
        here.set_positions(ids[1], positions);
        there.detect();
        here.detect();
        ASSERT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts())) << "step " << step;
        most = std::max(most, here.contacts().size());
    }
    EXPECT_GT(most, 0u);
}

}  // namespace
}  // namespace pierce
