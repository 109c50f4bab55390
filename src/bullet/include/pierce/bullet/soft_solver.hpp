#pragma once

#include <BulletSoftBody/btDefaultSoftBodySolver.h>

#include <memory>

namespace pierce::bullet {

/// A solver for Bullet's soft bodies in which piles come to rest: give it to
/// btSoftRigidDynamicsWorld. Bodies are solved together, friction holds on to places, and islands
/// that are calm sleep. It knows links, anchors and shape matching.
class SoftSolver : public btDefaultSoftBodySolver {
public:
    SoftSolver();
    ~SoftSolver() override;

    /// Called by Bullet before it looks for contacts.
    void predictMotion(btScalar dt) override;
    /// Called by Bullet when contacts are known.
    void solveConstraints(btScalar dt) override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::bullet
