#pragma once

#include <BulletSoftBody/btDefaultSoftBodySolver.h>

#include <memory>

namespace pierce::bullet {

/// A solver for Bullet's soft bodies with which piles come to rest; give it to
/// btSoftRigidDynamicsWorld. Bodies are solved together, friction holds nodes at places, and calm
/// islands sleep. It handles links, anchors and shape matching.
class SoftSolver : public btDefaultSoftBodySolver {
public:
    SoftSolver();
    ~SoftSolver() override;

    /// Bullet calls this before it looks for contacts.
    void predictMotion(btScalar dt) override;
    /// Bullet calls this when contacts are known.
    void solveConstraints(btScalar dt) override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::bullet
