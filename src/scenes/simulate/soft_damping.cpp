#include "scenes/simulate/soft_damping.hpp"

namespace pierce::scenes {

void damp_vibration(btSoftBody& soft, btScalar share) {
    auto& nodes = soft.m_nodes;
    btScalar mass = 0;
    btVector3 center(0, 0, 0), momentum(0, 0, 0);
    for (int i = 0; i < nodes.size(); ++i) {
        if (nodes[i].m_im <= 0) return;  // pinned bodies have no motion as a whole
        const btScalar m = 1 / nodes[i].m_im;
        mass += m;
        center += m * nodes[i].m_x;
        momentum += m * nodes[i].m_v;
    }
    center /= mass;
    const btVector3 velocity = momentum / mass;
    btVector3 angular_momentum(0, 0, 0);
    btMatrix3x3 inertia(0, 0, 0, 0, 0, 0, 0, 0, 0);
    for (int i = 0; i < nodes.size(); ++i) {
        const btScalar m = 1 / nodes[i].m_im;
        const btVector3 r = nodes[i].m_x - center;
        angular_momentum += m * r.cross(nodes[i].m_v - velocity);
        for (int row = 0; row < 3; ++row) {
            inertia[row] -= m * r[row] * r;
            inertia[row][row] += m * r.length2();
        }
    }
    if (inertia.determinant() <= 0) return;
    const btVector3 spin = inertia.inverse() * angular_momentum;
    for (int i = 0; i < nodes.size(); ++i) {
        const btVector3 whole = velocity + spin.cross(nodes[i].m_x - center);
        nodes[i].m_v += share * (whole - nodes[i].m_v);
    }
}

}  // namespace pierce::scenes
