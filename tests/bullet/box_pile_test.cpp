// Boxes that fall into a pit under Pierce's contacts come to rest side by side, not in each other.
#include <gtest/gtest.h>

#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/bullet/install.hpp"
#include "pierce/reference_backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

constexpr Vec3d size{1, 0.8, 0.6};

/// A box around the origin with n x n squares a side.
MeshData box_of_squares(Vec3d edges, int n) {
    MeshData mesh;
    std::map<std::array<int, 3>, std::uint32_t> known;
    const auto corner = [&](std::array<int, 3> at) {
        const auto [place, is_new] = known.try_emplace(
            at, static_cast<std::uint32_t>(mesh.positions.size()));
        Vec3d p;
        for (std::size_t k = 0; k < 3; ++k)
            p[static_cast<int>(k)] = edges[static_cast<int>(k)] * (at[k] / double(n) - 0.5);
        if (is_new) mesh.positions.push_back(to_float(p));
        return place->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const int side : {0, n})
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) {
                    const auto at = [&](int u, int v) {
                        std::array<int, 3> place{};
                        place[axis] = side;
                        place[(axis + 1) % 3] = i + (side > 0 ? u : v);
                        place[(axis + 2) % 3] = j + (side > 0 ? v : u);
                        return corner(place);
                    };
                    mesh.triangles.push_back({{at(0, 0), at(1, 0), at(1, 1)}});
                    mesh.triangles.push_back({{at(0, 0), at(1, 1), at(0, 1)}});
                }
    return mesh;
}

/// A pit with a floor and four walls; all bodies are triangle meshes.
class Pit {
public:
    Pit() {
        world_.setGravity({0, 0, btScalar(-9.81)});
        bullet::install(world_, contacts_);
        add_fixed({8, 8, 2}, {0, 0, -1});
        for (const double side : {-1.0, 1.0}) {
            add_fixed({1, 8, 20}, {2.2 * side, 0, 9});
            add_fixed({8, 1, 20}, {0, 2.2 * side, 9});
        }
    }
    Pit(const Pit&) = delete;
    ~Pit() {
        bullet::uninstall(world_);
        for (const auto& body : bodies_) world_.removeRigidBody(body.get());
    }

    btRigidBody& add_box(int squares, const btTransform& place) {
        auto shape = std::make_unique<btGImpactMeshShape>(
            &triangles_of(box_of_squares(size, squares)));
        shape->setMargin(btScalar(0.01));
        shape->updateBound();
        shapes_.push_back(std::move(shape));
        const btVector3 edges = bullet::to_bullet(size), square = edges * edges;
        const btVector3 inertia = btVector3(square.y() + square.z(), square.z() + square.x(),
                                            square.x() + square.y()) /
                                  12;
        return add(1, inertia, place);
    }
    void step() { world_.stepSimulation(btScalar(1.0 / 60), 0); }

    /// How far some box has to go to leave another one.
    double deepest() const {
        World look(bvh_backend());
        const MeshId mesh = look.add_mesh("box", box_of_squares(size, 1));
        std::vector<BodyId> boxes;
        for (const auto& body : bodies_)
            if (!body->isStaticObject()) {
                boxes.push_back(look.add_rigid_body(mesh));
                look.set_pose(boxes.back(), bullet::from_bullet(body->getWorldTransform()));
            }
        look.detect();
        double deepest = 0;
        for (std::size_t a = 0; a < boxes.size(); ++a)
            for (std::size_t b = a + 1; b < boxes.size(); ++b)
                if (const auto way = look.parting(boxes[a], boxes[b]))
                    deepest = std::max(deepest, way->depth);
        return deepest;
    }

private:
    btTriangleMesh& triangles_of(const MeshData& mesh) {
        meshes_.push_back(std::make_unique<btTriangleMesh>());
        for (const Triangle& t : mesh.triangles)
            meshes_.back()->addTriangle(bullet::to_bullet(mesh.positions[t.vertex[0]]),
                                        bullet::to_bullet(mesh.positions[t.vertex[1]]),
                                        bullet::to_bullet(mesh.positions[t.vertex[2]]));
        return *meshes_.back();
    }
    void add_fixed(Vec3d edges, Vec3d place) {
        shapes_.push_back(std::make_unique<btBvhTriangleMeshShape>(
            &triangles_of(box_of_squares(edges, 1)), true));
        add(0, btVector3(0, 0, 0),
            btTransform(btQuaternion::getIdentity(), bullet::to_bullet(place)));
    }
    btRigidBody& add(btScalar mass, const btVector3& inertia, const btTransform& place) {
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shapes_.back().get(), inertia);
        info.m_startWorldTransform = place;
        bodies_.push_back(std::make_unique<btRigidBody>(info));
        world_.addRigidBody(bodies_.back().get());
        return *bodies_.back();
    }

    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broadphase_;
    btSequentialImpulseConstraintSolver solver_;
    btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
    World contacts_{bvh_backend()};
    std::vector<std::unique_ptr<btTriangleMesh>> meshes_;
    std::vector<std::unique_ptr<btCollisionShape>> shapes_;
    std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

class BoxPileTest : public testing::TestWithParam<int> {};

// Without the ways of edges and of convex pairs that are at odds, boxes of one square a side come
// to rest up to 0.7 in each other, and on the average 0.38.
TEST_P(BoxPileTest, ComesToRestSideBySide) {
    constexpr int piles = 4, boxes = 24, steps = 720;
    double sum = 0;
    for (int pile = 0; pile < piles; ++pile) {
        Pit pit;
        test::Random random(static_cast<std::uint32_t>(pile) + 1);
        for (int i = 0; i < boxes; ++i) {
            const Vec3d aside = random.in_box(0.9);
            pit.add_box(GetParam(),
                        bullet::to_bullet(Pose{.position = {aside.x, aside.y, 1 + 1.2 * i},
                                               .rotation = random.rotation()}));
        }
        for (int step = 0; step < steps; ++step) pit.step();
        const double deepest = pit.deepest();
        EXPECT_LT(deepest, 0.15) << "pile " << pile;
        sum += deepest;
    }
    EXPECT_LT(sum / piles, 0.05);
}

INSTANTIATE_TEST_SUITE_P(SquaresASide, BoxPileTest, testing::Values(1, 2));

// Boxes that are put deep into each other, and fall freely: their contacts may lead against each
// other, and then only the way apart of the whole pair takes one out of the other.
TEST(ConvexPairTest, DeepBoxesPart) {
    test::Random random(3);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int stuck = 0, deep = 0;
    for (int pair = 0; pair < 60; ++pair) {
        Pit pit;
        for (int k = 0; k < 2; ++k)
            pit.add_box(1, bullet::to_bullet(Pose{.position = Vec3d{0, 0, 12} + random.in_box(0.25),
                                                  .rotation = random.rotation()}));
        deep += pit.deepest() > 0.2;
        for (int step = 0; step < 60; ++step) pit.step();
        stuck += pit.deepest() > 0.05;
    }
    EXPECT_GT(deep, 50);
    EXPECT_EQ(stuck, 0);
}

}  // namespace
}  // namespace pierce
