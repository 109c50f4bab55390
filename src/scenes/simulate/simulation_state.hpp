#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <chrono>
#include <memory>
#include <vector>

#include "pierce/bullet/baseline_shapes.hpp"
#include "pierce/bullet/install.hpp"
#include "pierce/bullet/sheet_response.hpp"
#include "pierce/bullet/soft_solver.hpp"
#include "scenes/detect/bullet_result.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/detect/guided_nodes.hpp"
#include "scenes/detect/soft_sheet.hpp"
#include "scenes/simulate/simulation.hpp"
#include "scenes/simulate/tearing.hpp"

namespace pierce::scenes {

/// Bullet's world with a clock on collision detection.
class ClockedWorld : public btSoftRigidDynamicsWorld {
public:
    using btSoftRigidDynamicsWorld::btSoftRigidDynamicsWorld;

    void performDiscreteCollisionDetection() override {
        const auto begin = std::chrono::steady_clock::now();
        btSoftRigidDynamicsWorld::performDiscreteCollisionDetection();
        detection_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                                 begin)
                           .count();
    }

    double detection_ms = 0;
};

/// Where a soft body's nodes are.
std::vector<Vec3f> node_positions(const btSoftBody& soft);

/// The scene without its sheets, and without bodies whose whole motion is given.
SceneSetup solid_part(SceneSetup scene);

struct Simulation::State {
    SceneSetup scene;
    Method method;
    std::unique_ptr<SceneWorld> rays;    ///< null for Bullet's own methods
    std::unique_ptr<SceneWorld> solids;  ///< all that is no sheet; set where there are sheets and
                                         ///< solids that Bullet moves
    bullet::TimedConfiguration rigid_configuration;
    btSoftBodyRigidBodyCollisionConfiguration soft_configuration;
    std::unique_ptr<btCollisionDispatcher> dispatcher;
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    std::vector<bullet::BaselineShape> shapes;
    std::vector<std::unique_ptr<btRigidBody>> rigid;  ///< by body, null if soft
    std::vector<std::unique_ptr<btSoftBody>> soft;    ///< by body, null unless it is a solid that
                                                      ///< deforms
    std::vector<std::unique_ptr<SoftSheet>> sheets;   ///< by body, null if it is no sheet
    std::vector<std::unique_ptr<GuidedNodes>> led;    ///< by body, null unless it deforms
    std::vector<std::unique_ptr<Tearing>> torn;       ///< by body, null unless it can tear
    std::vector<std::vector<Vec3f>> given;            ///< by body, empty unless its motion is given
    std::unique_ptr<bullet::SheetResponse> apart;     ///< null if there are no sheets
    std::vector<std::vector<Vec3f>> tried;            ///< by body: where Bullet has put a sheet
    double time = 0;                                  ///< [s] since the start
    std::vector<double> mass;                         ///< by body
    bullet::SoftSolver soft_solver;
    std::unique_ptr<ClockedWorld> world;
    bullet::Installation* installed = nullptr;  ///< set if solids meet by rays in Bullet's world
    FrameResult result;

    State(const SceneSetup& s, Method m) : scene(s), method(m) {}

    void add_bodies();
    void add_rigid(std::uint32_t index);
    void add_soft(std::uint32_t index);
    void add_sheet(std::uint32_t index);
    void add_given(std::uint32_t index);
    void add_changes(std::uint32_t index, btSoftBody& made);
    void lead(double dt);
    BodyId solid_body(std::uint32_t index) const;
    void move_soft_obstacles();
    std::uint32_t tear();
    const MeshData& mesh_of(std::uint32_t index) const;
    void measure_sheets();
    void note_tried();
    void record(Recording& recording, bool as_tried) const;
    void record_seen(Recording& recording) const;
    void record_mesh(Recording& recording, std::uint32_t index) const;
    btSoftBody* soft_body(std::size_t index) const {
        return soft[index] ? soft[index].get() : sheets[index] ? &sheets[index]->soft() : nullptr;
    }
};

}  // namespace pierce::scenes
