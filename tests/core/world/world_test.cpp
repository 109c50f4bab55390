// The public World: what it refuses, what it survives, what it remembers.
#include "pierce/world.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>

#include "pierce/backend.hpp"
#include "pierce/error.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/reference_backends.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

MeshData unit_box() { return scenes::box({0, 0, 0}, {1, 1, 1}); }

Pose at(double x, double y, double z) { return {{x, y, z}, {}}; }

/// Two boxes of which the second stands `overlap` deep in the first one's top.
struct TwoBoxes {
    World world;
    BodyId below, above;

    explicit TwoBoxes(double overlap) {
        const MeshId big = world.add_mesh("big", scenes::box({-5, -5, -1}, {5, 5, 0}));
        const MeshId small = world.add_mesh("small", unit_box());
        below = world.add_fixed_body(big);
        above = world.add_rigid_body(small, at(0.2, 0.3, -overlap));
    }
};

TEST(WorldTest, FindsTheFourCornersOfABoxOnATable) {
    TwoBoxes scene(0.02);
    scene.world.detect();
    ASSERT_EQ(scene.world.contacts().size(), 4u);
    for (const Contact& c : scene.world.contacts()) {
        EXPECT_EQ(c.a, scene.below);
        EXPECT_EQ(c.b, scene.above);
        EXPECT_EQ(c.source, Side::b);
        EXPECT_NEAR(c.penetration_depth(), 0.02, 1e-6);
        EXPECT_NEAR(c.normal.z, 1, 1e-6);
        EXPECT_NEAR(c.face_normal.z, 1, 1e-12);
        EXPECT_NEAR(length(c.normal), 1, 1e-12);
        EXPECT_NEAR(dot(c.point_b - c.point_a, c.normal), c.distance, 1e-12);
        EXPECT_NEAR(c.barycentric[0] + c.barycentric[1] + c.barycentric[2], 1, 1e-6);
    }
}

TEST(WorldTest, SaysWhereBodiesAre) {
    TwoBoxes scene(0.02);
    const MeshId mesh = scene.world.mesh_of(scene.above);
    const Pose turned{{1, 2, 3}, {0.5, 0.1, 0, 0.7}};
    scene.world.set_pose(scene.above, turned);
    EXPECT_EQ(scene.world.pose_of(scene.above), turned);
    std::vector<Vec3f> moved(unit_box().positions);
    for (Vec3f& p : moved) p.x += 0.25f;
    const BodyId soft = scene.world.add_deforming_body(mesh, moved);
    EXPECT_THAT([&] { (void)scene.world.pose_of(soft); },
                ThrowsMessage<InputError>(HasSubstr("deforms")));
    for (BodyId body : {scene.above, soft}) {
        const std::vector<Vec3d> all = scene.world.vertex_positions(body);
        ASSERT_EQ(all.size(), moved.size());
        for (std::uint32_t v = 0; v < all.size(); ++v)
            EXPECT_EQ(all[v], scene.world.vertex_position(body, v));
    }
    scene.world.remove_body(soft);
    EXPECT_THROW((void)scene.world.vertex_positions(soft), InputError);
}

TEST(WorldTest, ContactsAgeWhileTheyLast) {
    TwoBoxes scene(0.02);
    for (std::uint32_t step = 0; step < 3; ++step) {
        scene.world.detect();
        for (const Contact& c : scene.world.contacts()) EXPECT_EQ(c.age, step);
    }
    scene.world.set_pose(scene.above, at(0.2, 0.3, 1));
    scene.world.detect();
    EXPECT_TRUE(scene.world.contacts().empty());
    scene.world.set_pose(scene.above, at(0.2, 0.3, -0.02));
    scene.world.detect();
    ASSERT_FALSE(scene.world.contacts().empty());
    EXPECT_EQ(scene.world.contacts().front().age, 0u);
}

TEST(WorldTest, TouchingIsAContactOfDepthZero) {
    TwoBoxes scene(0);
    scene.world.detect();
    // The corners, and what may be inside by rounding of the edges that lie in the other's face.
    EXPECT_EQ(std::ranges::count_if(scene.world.contacts(),
                                    [](const Contact& c) { return !c.is_edge(); }),
              4);
    for (const Contact& c : scene.world.contacts()) EXPECT_EQ(c.distance, 0);
    scene.world.set_pose(scene.above, at(0.2, 0.3, 0.001));
    scene.world.detect();
    EXPECT_TRUE(scene.world.contacts().empty());
}

TEST(WorldTest, RefusesUnusableMeshesAndNamesThem) {
    World world;
    MeshData none{unit_box().positions, {}};
    EXPECT_THAT([&] { world.add_mesh("hollow", none); },
                ThrowsMessage<InputError>(HasSubstr("'hollow' has no triangles")));
    MeshData outside = unit_box();
    outside.triangles[3].vertex[1] = 8;
    EXPECT_THAT([&] { world.add_mesh("crate", outside); },
                ThrowsMessage<InputError>(
                    HasSubstr("'crate': triangle 3 names vertex 8, but there are 8")));
    for (float bad : {nan, std::numeric_limits<float>::infinity()}) {
        MeshData broken = unit_box();
        broken.positions[5].y = bad;
        EXPECT_THAT([&] { world.add_mesh("crate", broken); },
                    ThrowsMessage<InputError>(HasSubstr("'crate': vertex 5 is not finite")));
    }
}

TEST(WorldTest, WorldsShareAMeshThatOutlivesThem) {
    std::shared_ptr<const Mesh> mesh = std::make_shared<const Mesh>("box", unit_box());
    World second;
    {
        World first;
        EXPECT_EQ(&first.mesh(first.add_mesh(mesh)), mesh.get());
        second.add_fixed_body(second.add_mesh(mesh));
        mesh.reset();
    }
    second.add_rigid_body(second.add_mesh("own", unit_box()), at(0.5, 0.5, 0.5));
    EXPECT_GT(second.detect().contacts, 0u);
    EXPECT_THROW(second.add_mesh(mesh), InputError);
}

TEST(WorldTest, RefusedCallsChangeNothing) {
    TwoBoxes scene(0.02);
    const MeshId box = scene.world.mesh_of(scene.above);
    const BodyId soft = scene.world.add_deforming_body(box);
    scene.world.detect();
    const std::size_t before = scene.world.contacts().size();
    const std::vector<Vec3f> few(7);
    EXPECT_THROW(scene.world.set_positions(soft, few), InputError);
    EXPECT_THROW(scene.world.set_positions(scene.above, unit_box().positions), InputError);
    EXPECT_THROW(scene.world.set_pose(soft, {}), InputError);
    EXPECT_THROW(scene.world.set_mesh(soft, box, few), InputError);
    EXPECT_THROW(scene.world.add_deforming_body(box, few), InputError);
    EXPECT_THROW(scene.world.add_rigid_body(box, {{nan, 0, 0}, {}}), InputError);
    EXPECT_THROW(scene.world.add_rigid_body(box, {{}, {0, 0, 0, 0}}), InputError);
    EXPECT_THROW(scene.world.add_rigid_body(MeshId{}), InputError);
    EXPECT_THROW(scene.world.remove_mesh(box), InputError);
    EXPECT_THROW(scene.world.remove_body(BodyId{}), InputError);
    scene.world.detect();
    EXPECT_EQ(scene.world.contacts().size(), before);
}

TEST(WorldTest, ABodyThatIsNotFiniteIsLeftOutAndComesBack) {
    TwoBoxes scene(0.02);
    const MeshId box = scene.world.mesh_of(scene.above);
    const BodyId other = scene.world.add_rigid_body(box, at(3, 3, -0.02));
    const BodyId soft = scene.world.add_deforming_body(box);
    scene.world.set_pose(scene.above, {{0, std::nan(""), 0}, {}});
    std::vector<Vec3f> broken = unit_box().positions;
    broken[2].x = nan;
    scene.world.set_positions(soft, broken);
    const StepStats& stats = scene.world.detect();
    EXPECT_EQ(stats.status, static_cast<std::uint32_t>(body_excluded));
    EXPECT_EQ(stats.excluded_bodies, 2u);
    ASSERT_EQ(scene.world.contacts().size(), 4u);
    for (const Contact& c : scene.world.contacts()) EXPECT_EQ(c.b, other);

    scene.world.set_pose(scene.above, at(0.2, 0.3, -0.02));
    std::vector<Vec3f> sound = unit_box().positions;
    for (Vec3f& p : sound) p = p + Vec3f{-3, -3, -0.02f};
    scene.world.set_positions(soft, sound);
    EXPECT_EQ(scene.world.detect().status, static_cast<std::uint32_t>(step_ok));
    EXPECT_EQ(scene.world.contacts().size(), 12u);
}

TEST(WorldTest, RemovedThingsStayRemoved) {
    TwoBoxes scene(0.02);
    const MeshId box = scene.world.mesh_of(scene.above);
    scene.world.detect();
    scene.world.remove_body(scene.above);
    EXPECT_THROW(scene.world.set_pose(scene.above, {}), InputError);
    scene.world.detect();
    EXPECT_TRUE(scene.world.contacts().empty());
    const BodyId again = scene.world.add_rigid_body(box, at(0.2, 0.3, -0.02));
    EXPECT_EQ(again.index, scene.above.index);
    EXPECT_NE(again, scene.above);
    scene.world.detect();
    ASSERT_EQ(scene.world.contacts().size(), 4u);
    EXPECT_EQ(scene.world.contacts()[0].age, 0u) << "a new body in an old slot has no past";
    scene.world.remove_body(again);
    scene.world.remove_mesh(box);
    EXPECT_THROW(scene.world.mesh(box), InputError);
}

TEST(WorldTest, FixedBodiesAreNoPair) {
    World world;
    const MeshId box = world.add_mesh("box", unit_box());
    world.add_fixed_body(box);
    const BodyId other = world.add_fixed_body(box, at(0.5, 0.5, 0.5));
    world.detect();
    EXPECT_EQ(world.stats().pairs, 0u);
    world.set_pose(other, at(3, 0, 0));
    world.detect();
    world.set_pose(other, at(-3, 0, 0));
    EXPECT_TRUE(world.impacts().empty());
}

TEST(WorldTest, RefusesWhatItCannotBeMadeOf) {
    EXPECT_THROW(World(std::unique_ptr<Backend>()), InputError);
    std::stringstream saved;
    World().save(saved);
    EXPECT_THROW(World::restore(saved, nullptr), InputError);
    EXPECT_THROW(World(Settings{.coverage = static_cast<Coverage>(7)}), InputError);
    EXPECT_THROW(World(Settings{.temporal = static_cast<Temporal>(7)}), InputError);
    for (const std::uint32_t parts : {0u, most_parts + 1})
        EXPECT_THROW(partitioned_backend(parts, 1, [](int) { return reference_backend(); }),
                     InputError);
}

TEST(WorldTest, ADeformingBodyMayChangeItsTriangles) {
    World world;
    const MeshId ground = world.add_mesh("ground", scenes::box({-5, -5, -1}, {5, 5, 0}));
    world.add_fixed_body(ground);
    const MeshId coarse = world.add_mesh("coarse", scenes::sphere(1, 1)),
                 fine = world.add_mesh("fine", scenes::sphere(1, 3));
    const BodyId body = world.add_deforming_body(coarse);
    world.detect();
    const std::size_t before = world.contacts().size();
    world.set_mesh(body, fine, scenes::sphere(1, 3).positions);
    world.detect();
    EXPECT_GT(world.contacts().size(), 4 * before);
    EXPECT_EQ(world.mesh_of(body), fine);
}

TEST(WorldTest, AnOpenBodyIsASourceButNoTarget) {
    World world;
    MeshData sheet;
    sheet.positions = {{0.25f, 0.25f, 0.98f}, {0.75f, 0.25f, 0.98f}, {0.5f, 0.75f, 0.98f}};
    sheet.triangles = {{{0, 2, 1}}};  // faces down: its inward rays go up and out of the box
    const BodyId box = world.add_rigid_body(world.add_mesh("box", unit_box()));
    world.add_rigid_body(world.add_mesh("sheet", sheet));
    world.detect();
    ASSERT_EQ(world.contacts().size(), 3u);
    for (const Contact& c : world.contacts()) {
        EXPECT_EQ(c.a, box);
        EXPECT_EQ(c.source, Side::b);
        EXPECT_NEAR(c.penetration_depth(), 0.02, 1e-6);
    }
    ASSERT_EQ(world.plan().notes.size(), 1u);
    EXPECT_THAT(world.plan().notes[0], HasSubstr("'sheet': open"));
}

// Whether a plan was made between is no matter.
TEST(WorldTest, AnEmptiedWorldBeginsAnew) {
    for (const bool plans : {false, true})
        for (const bool replicates : {false, true}) {
            World world;
            const MeshId mesh = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
            world.add_fixed_body(mesh);
            const BodyId first = world.add_rigid_body(mesh, {{0.2, 0.3, 0.9}, {}}),
                         second = world.add_rigid_body(mesh, {{0.2, 0.3, 0.9}, {}});
            world.set_filter(first, {.world = 0});
            world.set_filter(second, {.world = 1});
            world.set_world_active(1, false);
            world.detect();
            const std::size_t of_one = world.contacts().size();
            EXPECT_GT(of_one, 0u);
            world.remove_world(1);
            if (plans) world.plan();
            if (replicates) {
                EXPECT_EQ(world.replicate(0, 1), 1);
            } else {
                world.set_filter(world.add_rigid_body(mesh, {{0.2, 0.3, 0.9}, {}}), {.world = 1});
            }
            world.detect();
            EXPECT_EQ(world.contacts().size(), 2 * of_one) << plans << replicates;
        }
}

TEST(WorldTest, BoxesAreThoseOfTheLastStep) {
    World world;
    const MeshId mesh = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    const BodyId body = world.add_rigid_body(mesh);
    EXPECT_THROW(world.body_boxes(), InputError);
    world.detect();
    ASSERT_EQ(world.body_boxes().size(), 1u);
    EXPECT_EQ(world.body_boxes()[0].body, body);
    world.plan();
    EXPECT_EQ(world.body_boxes().size(), 1u);
    world.add_rigid_body(mesh);
    EXPECT_THROW(world.body_boxes(), InputError);
}

TEST(WorldTest, SheetsAloneCastNoRays) {
    World world;
    const MeshId grid = world.add_mesh("sheet", scenes::grid(1, 1, 4, 4));
    const BodyId sheet = world.add_deforming_body(grid);
    world.set_collision(sheet, {SelfCollision::on, true, 0.1});
    const BodyId box = world.add_rigid_body(world.add_mesh("box", unit_box()), at(0, 0, -0.05));
    world.detect();
    EXPECT_TRUE(world.plan().casts_rays);
    EXPECT_GT(world.stats().rays, 0u);
    EXPECT_GT(world.contacts().size(), 0u);

    world.remove_body(box);
    EXPECT_FALSE(world.plan().casts_rays);
    EXPECT_THAT(world.plan().stages, testing::ElementsAre(StageId::bounds, StageId::pairs,
                                                          StageId::sheets, StageId::statistics));
    world.detect();
    EXPECT_EQ(world.contacts().size(), 0u) << "nothing is left of the rays before";
    EXPECT_EQ(world.stats().rays, 0u);
    EXPECT_EQ(world.stats().hits, 0u);

    world.set_collision(sheet, {SelfCollision::rays, true, 0.1});
    EXPECT_TRUE(world.plan().casts_rays);
}

TEST(WorldTest, CastsRaysAtBodies) {
    TwoBoxes scene(0);
    scene.world.detect();
    const std::vector<Vec3d> directions{{0, 0, -2}, {0, 0, 1}, {0, 0, 0}};
    const auto hits = scene.world.cast_rays({0.5, 0.6, 3}, directions);
    ASSERT_TRUE(hits[0]);
    EXPECT_EQ(hits[0]->body, scene.above);
    EXPECT_NEAR(hits[0]->t, 2, 1e-6);
    EXPECT_NEAR(hits[0]->normal.z, 1, 1e-12);
    EXPECT_FALSE(hits[1]);
    EXPECT_FALSE(hits[2]);
    const auto table = scene.world.cast_rays({-3, -3, 3}, std::span(directions).first(1));
    ASSERT_TRUE(table[0]);
    EXPECT_EQ(table[0]->body, scene.below);
    EXPECT_NEAR(table[0]->normal.z, 1, 1e-12);
    // Of any length, and from any distance.
    const std::vector<Vec3d> tiny_and_huge{{0, 0, -1e-200}, {0, 0, -1e200}};
    for (const double height : {3.0, 1e12})
        for (const auto& hit : scene.world.cast_rays({0.5, 0.6, height}, tiny_and_huge)) {
            ASSERT_TRUE(hit) << height;
            EXPECT_NEAR(hit->t, height - 1, 1e-6 * height);
            EXPECT_NEAR(hit->normal.z, 1, 1e-12);
        }
}

}  // namespace
}  // namespace pierce
