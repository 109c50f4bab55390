#pragma once

#include <BulletSoftBody/btSoftBody.h>

#include <vector>

#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// The nodes of a soft body whose motion is given.
class GuidedNodes {
public:
    /// `soft` is at its start, and must outlive this object.
    GuidedNodes(btSoftBody& soft, const std::vector<Guide>& guides);

    /// Gives the nodes that are led the velocity to reach their places at `time`, the end of the
    /// next step of `dt` [s].
    void lead(double time, double dt);

private:
    struct Node {
        int index = 0;
        Vec3d start;
        btScalar inverse_mass = 0;  ///< when it is let go
    };
    struct Led {
        Guide guide;
        std::vector<Node> nodes;
    };

    btSoftBody& soft_;
    std::vector<Led> led_;
};

}  // namespace pierce::scenes
