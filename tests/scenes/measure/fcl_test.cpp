// FCL as a peer, where this build has it: triangles of two boxes that overlap by a corner cross,
// and bodies that are apart have no contact.
#include <gtest/gtest.h>

#include "pierce/error.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/named/scene.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

SceneSetup two_boxes(Motion motion) {
    SceneSetup scene;
    SceneMesh mesh;
    mesh.name = "box";
    mesh.data = box({-1, -1, -1}, {1, 1, 1});
    scene.meshes.push_back(mesh);
    for (const double at : {0.0, 1.5}) {
        SceneBody body;
        body.pose.position = {at, at, at};
        body.motion = motion;
        scene.bodies.push_back(body);
    }
    return scene;
}

TEST(FclTest, FindsTrianglesThatCross) {
    std::unique_ptr<Detector> detector;
    for (const Motion motion : {Motion::rigid, Motion::deforming}) {
        const SceneSetup scene = two_boxes(motion);
        try {
            detector = make_detector(scene, Method::fcl);
        } catch (const InputError& error) {
            GTEST_SKIP() << error.what();
        }
        const auto move = [&](double at) {
            if (motion == Motion::rigid) return detector->set_pose(1, {{at, at, at}, {}});
            const auto low = at - 1, high = at + 1;
            detector->set_positions(1, box({low, low, low}, {high, high, high}).positions);
        };
        if (motion == Motion::deforming) detector->set_positions(0, scene.meshes[0].data.positions);
        move(1.5);
        const FrameResult found = detector->detect();
        EXPECT_EQ(found.pairs, 1u);
        EXPECT_EQ(found.touching, (std::vector<std::pair<std::uint32_t, std::uint32_t>>{{0, 1}}));
        EXPECT_EQ(detector->contacts().size(), found.contacts);
        for (const MethodContact& c : detector->contacts()) {
            EXPECT_EQ(c.a, 0u);
            EXPECT_EQ(c.b, 1u);
            EXPECT_NEAR(length(c.normal), 1, 1e-6);
        }
        move(2.5);
        EXPECT_EQ(detector->detect().contacts, 0u);
        EXPECT_TRUE(detector->contacts().empty());
    }
}

}  // namespace
}  // namespace pierce::scenes
