// What the host asks about bodies whose places are in device memory, which is the host's here.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/explain.hpp"
#include "pierce/overlap.hpp"
#include "pierce/parting.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/device_backend.hpp"

namespace pierce {
namespace {

/// A ring with its pose and a soft one with its positions in memory, and the same on the host.
class HostPlacesTest : public testing::Test {
protected:
    HostPlacesTest() {
        for (World* w : {&there, &here}) {
            const MeshId mesh = w->add_mesh("ring", ring);
            rigid = w->add_rigid_body(mesh);
            soft = w->add_deforming_body(mesh);
            Filter filter;
            filter.world = 3;
            w->set_filter(rigid, filter);
            w->set_filter(soft, filter);
        }
        put(0);
        there.set_device_poses({&rigid, 1}, pose_there.data());
        there.set_device_positions(soft, soft_there.data());
    }

    void put(int step) {
        const double t = 0.1 * step;
        pose_there = {0.2 * t, 0.1, 0, 0, 0, std::sin(t), std::cos(t)};
        soft_there.clear();
        for (const Vec3f p : ring.positions)
            soft_there.push_back(
                {p.x + 0.7f, p.y * (1 + 0.1f * static_cast<float>(t)), p.z + 0.2f});
        here.set_pose(rigid, {{0.2 * t, 0.1, 0}, {0, 0, std::sin(t), std::cos(t)}});
        here.set_positions(soft, soft_there);
    }
    static std::string bytes_of(const World& world) {
        std::ostringstream out(std::ios::binary);
        world.save(out);
        return out.str();
    }

    MeshData ring = scenes::torus(1, 0.35, 20, 10);
    World there{std::make_unique<test::DeviceBackend>()}, here{bvh_backend()};
    BodyId rigid, soft;
    std::vector<double> pose_there = std::vector<double>(7);
    std::vector<Vec3f> soft_there{ring.positions};
};

TEST_F(HostPlacesTest, AreThoseOfDeviceMemory) {
    for (int step = 0; step < 4; ++step) {
        put(step);
        for (World* w : {&there, &here}) w->detect();
        ASSERT_FALSE(here.contacts().empty());
        EXPECT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts()));
        EXPECT_EQ(there.pose_of(rigid).position, here.pose_of(rigid).position);
        EXPECT_EQ(there.vertex_positions(rigid), here.vertex_positions(rigid));
        EXPECT_EQ(there.vertex_positions(soft), here.vertex_positions(soft));
        EXPECT_EQ(there.vertex_position(soft, 7), here.vertex_position(soft, 7));
        ASSERT_TRUE(here.parting(rigid, soft) && here.overlap(rigid, soft));
        EXPECT_EQ(there.parting(rigid, soft)->translation(),
                  here.parting(rigid, soft)->translation());
        EXPECT_EQ(there.overlap(rigid, soft)->volume, here.overlap(rigid, soft)->volume);
        const std::vector<Vec3d> directions{{0, 0, -1}, {0.2, 0, -1}, {0.3, 0.9, -1}};
        const auto hits = there.cast_rays({0.9, 0, 3}, directions),
                   expected = here.cast_rays({0.9, 0, 3}, directions);
        std::size_t found = 0;
        for (std::size_t k = 0; k < directions.size(); ++k) {
            ASSERT_EQ(hits[k].has_value(), expected[k].has_value());
            if (!hits[k]) continue;
            ++found;
            EXPECT_EQ(hits[k]->t, expected[k]->t);
            EXPECT_EQ(hits[k]->triangle, expected[k]->triangle);
        }
        EXPECT_GT(found, 0u);
    }
    // Trees of the host are those of the places that were brought last, also without a step.
    const std::vector<Vec3d> down{{0, 0, -1}};
    const auto before = there.cast_rays({1.7, 0.01, 3}, down)[0];
    for (Vec3f& p : soft_there) p = p + Vec3f{-0.25f, 0, 0};
    const auto after = there.cast_rays({1.7, 0.01, 3}, down)[0];
    ASSERT_TRUE(before && after && before->body == soft && after->body == soft);
    EXPECT_GT(after->t, before->t + 0.05) << "it has moved to the side";
    // Steps go on reading device memory.
    put(9);
    for (World* w : {&there, &here}) w->detect();
    EXPECT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts()));
}

TEST_F(HostPlacesTest, AreSavedAndCopied) {
    put(1);
    for (World* w : {&there, &here}) w->detect();
    std::istringstream saved(bytes_of(there), std::ios::binary);
    World restored = World::restore(saved, bvh_backend());
    for (int step = 2; step < 5; ++step) {
        put(step);
        here.detect();
        restored.set_pose(rigid, here.pose_of(rigid));
        restored.set_positions(soft, soft_there);
        restored.detect();
        EXPECT_EQ(contact_hash(restored.contacts()), contact_hash(here.contacts())) << step;
    }
    for (World* w : {&there, &here}) {
        EXPECT_EQ(w->replicate(3, 2), 4);
        w->copy_places(3, 5);
        w->detect();
    }
    EXPECT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts()));
}

TEST_F(HostPlacesTest, MayBeNone) {
    there.detect();
    pose_there[2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(there.parting(rigid, soft));
    EXPECT_FALSE(there.overlap(rigid, soft));
    std::istringstream saved(bytes_of(there), std::ios::binary);
    World restored = World::restore(saved, bvh_backend());
    EXPECT_EQ(restored.detect().excluded_bodies, 1u);
    pose_there[2] = 0;
    EXPECT_TRUE(there.parting(rigid, soft));
}

TEST_F(HostPlacesTest, AreRefusedWhereAStepWouldHaveToTell) {
    there.detect();
    EXPECT_THROW(there.explain(soft, rigid, 0), InputError);
    EXPECT_THROW(there.impacts(), InputError);
}

/// A sheet above a box, in device memory and the same on the host.
struct Sheet {
    MeshData plane;
    World there{std::make_unique<test::DeviceBackend>()}, here{bvh_backend()};
    BodyId box, sheet;
    std::vector<Vec3f> start, end;  ///< in device memory

    Sheet() {
        plane.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        plane.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
        for (World* w : {&there, &here}) {
            box = w->add_fixed_body(w->add_mesh("box", scenes::box({-2, -2, -1}, {2, 2, 0})));
            sheet = w->add_deforming_body(w->add_mesh("plane", plane), at(3));
            w->set_collision(sheet, {.sheet = true});
        }
    }
    std::vector<Vec3f> at(float height) const {
        std::vector<Vec3f> positions = plane.positions;
        for (Vec3f& p : positions) p.z = height;
        return positions;
    }
    /// A step in which the sheet moves; its place stays in device memory.
    void step(float from, float to) {
        start = at(from);
        end = at(to);
        there.set_device_motion(sheet, start.data(), end.data());
        here.set_motion(sheet, start, end);
        detect("in device memory");
    }
    void detect(const char* what) {
        for (World* w : {&there, &here}) w->detect();
        EXPECT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts())) << what;
    }
};

TEST(HostPlacesSheetTest, AMotionBeginsWhereTheLastStepHasEnded) {
    Sheet s;
    s.step(3, 2);
    s.step(2, 0.5f);
    for (World* w : {&s.there, &s.here}) w->set_positions(s.sheet, s.at(0.25f));
    s.detect("above the box");
    EXPECT_TRUE(s.there.contacts().empty());
    s.step(0.25f, 0.125f);
    for (World* w : {&s.there, &s.here}) w->set_positions(s.sheet, s.at(-0.25f));
    s.detect("into the box");
    EXPECT_FALSE(s.there.contacts().empty());
}

TEST(HostPlacesSheetTest, AMotionBeginsWhereTheBodyIsPutIfItsLastPlaceIsUnknown) {
    Sheet s;
    s.step(3, 0.5f);
    const std::vector<Vec3f> others = s.at(0.4f);
    s.there.set_device_motion(s.sheet, others.data(), others.data());
    s.there.set_positions(s.sheet, s.at(-0.25f));
    s.here.set_motion(s.sheet, s.at(-0.25f), s.at(-0.25f));
    s.detect("put there");

    std::vector<Vec3f> unusable = s.at(1);
    unusable[2].x = std::numeric_limits<float>::quiet_NaN();
    for (World* w : {&s.there, &s.here}) w->set_positions(s.sheet, unusable);
    s.detect("left out");
    s.there.set_device_motion(s.sheet, others.data(), others.data());
    for (World* w : {&s.there, &s.here}) w->set_positions(s.sheet, s.at(-0.25f));
    s.detect("put there again");
}

TEST(HostPlacesSheetTest, AMotionThatIsRefusedChangesNothing) {
    Sheet s;
    s.step(3, 0.5f);
    const std::vector<Vec3f> too_few(3);
    EXPECT_THROW(s.there.set_motion(s.sheet, s.at(1), too_few), InputError);
    for (World* w : {&s.there, &s.here}) w->set_positions(s.sheet, s.at(-0.25f));
    s.detect("into the box");
    EXPECT_FALSE(s.there.contacts().empty());
}

// Nobody reads the start once the step is over, nor the end where set_motion() follows.
TEST(HostPlacesSheetTest, WhatIsNeededNoMoreMayBeFreed) {
    Sheet s;
    s.step(3, 2);
    s.start = {};  // its memory is given back
    for (World* w : {&s.there, &s.here}) w->set_positions(s.sheet, s.at(0.5f));
    s.detect("the start is gone");
    s.step(0.5f, 0.25f);
    s.start = s.end = {};
    for (World* w : {&s.there, &s.here}) w->set_motion(s.sheet, s.at(0.25f), s.at(-0.25f));
    s.detect("both are gone");
    EXPECT_FALSE(s.there.contacts().empty());
}

TEST(HostPlacesSheetTest, ARigidBodyThatComesBackBeginsWhereItIsPut) {
    World world{std::make_unique<test::DeviceBackend>()};
    const MeshId mesh = world.add_mesh("box", scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}));
    const BodyId rigid = world.add_rigid_body(mesh, {{0, 0, 5}, {}});
    const std::vector<double> pose{0, 0, -5, 0, 0, 0, 1};
    world.set_device_poses({&rigid, 1}, pose.data());
    world.detect();
    const BodyId sheet = world.add_deforming_body(world.add_mesh("plane", Sheet().plane));
    world.set_collision(sheet, {.sheet = true});
    world.set_pose(rigid, {{0, 0, -4}, {}});
    world.detect();
    EXPECT_TRUE(world.contacts().empty()) << "it has not been above the sheet";
}

TEST(HostPlacesSheetTest, PosesInDeviceMemoryAreRefusedAtOnce) {
    Sheet s;
    const BodyId rigid = s.there.add_rigid_body(s.there.mesh_of(s.box));
    const std::vector<double> pose{0, 0, 9, 0, 0, 0, 1};
    s.there.detect();
    EXPECT_THROW(s.there.set_device_poses({&rigid, 1}, pose.data()), InputError);
    EXPECT_NO_THROW(s.there.detect());
}

}  // namespace
}  // namespace pierce
