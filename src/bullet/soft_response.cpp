#include "bullet/soft_response.hpp"

#include <BulletSoftBody/btSoftBodyInternals.h>

#include <vector>

#include "pierce/bullet/bullet_convert.hpp"

namespace pierce::bullet {
namespace {

/// A node that carries a contact's source point.
struct SourceNode {
    btSoftBody::Node* node;
    btScalar weight;
    Vec3d offset;  ///< of the node from the source point
};

std::vector<SourceNode> source_nodes(btSoftBody& source, const Contact& c) {
    std::vector<SourceNode> nodes;
    const std::uint32_t vertex[2] = {c.vertex, c.edge_end};
    for (int k = 0; k < (c.is_edge() ? 2 : 1); ++k) {
        btSoftBody::Node& node = source.m_nodes[static_cast<int>(vertex[k])];
        nodes.push_back({&node, static_cast<btScalar>(c.source_weight(k)),
                         c.is_edge() ? from_bullet(node.m_x) - c.source_point() : Vec3d{}});
    }
    return nodes;
}

/// How easily a place of a face moves: not at all if one of its nodes is held, as in Bullet, whose
/// solver moves all three.
btScalar share_of(const btSoftBody::Face& face, const btVector3& weights) {
    btScalar share = 0;
    for (int k = 0; k < 3; ++k) {
        if (face.m_n[k]->m_im <= 0) return 0;
        share += face.m_n[k]->m_im * weights[k];
    }
    return share;
}

/// Pushes `node` out of the half space below the plane through the point `through` with unit normal
/// `normal`.
void add_plane_contact(btSoftBody& soft, btSoftBody::Node& node, const btCollisionObject& object,
                       Vec3d normal, Vec3d through, Vec3d anchor, btScalar rigid_share) {
    if (node.m_im <= 0) return;
    const btRigidBody* rigid = btRigidBody::upcast(&object);
    const btScalar rigid_mass_inverse = rigid != nullptr ? rigid->getInvMass() * rigid_share
                                                         : btScalar(0);
    const btMatrix3x3 no_inertia(0, 0, 0, 0, 0, 0, 0, 0, 0);
    const btScalar friction = soft.m_cfg.kDF * object.getFriction();
    const btVector3 arm = to_bullet(anchor) - object.getWorldTransform().getOrigin();
    // Bullet's model: a tangential motion within the friction cone is stopped, and a faster one
    // loses the part that friction takes.
    const btVector3 out = to_bullet(normal);
    const btVector3 carried = rigid != nullptr
                                  ? rigid->getVelocityInLocalPoint(arm) * soft.m_sst.sdt
                                  : btVector3(0, 0, 0);
    const btVector3 motion = node.m_x - node.m_q - carried;
    const btScalar inward = motion.dot(out);
    const bool sticks = (motion - inward * out).length2() < inward * inward * friction * friction;

    btSoftBody::RContact contact{};
    contact.t1.setZero();
    contact.t2.setZero();
    contact.m_cti.m_colObj = &object;
    contact.m_cti.m_normal = out;
    contact.m_cti.m_offset = static_cast<btScalar>(-dot(normal, through));
    contact.m_node = &node;
    contact.m_c0 = ImpulseMatrix(soft.m_sst.sdt, node.m_im, rigid_mass_inverse,
                                 rigid != nullptr ? rigid->getInvInertiaTensorWorld() : no_inertia,
                                 arm);
    contact.m_c1 = arm;
    contact.m_c2 = node.m_im * soft.m_sst.sdt;
    contact.m_c3 = sticks ? btScalar(0) : btScalar(1) - btMin(friction, btScalar(1));
    contact.m_c4 = object.isStaticOrKinematicObject() ? soft.m_cfg.kKHR : soft.m_cfg.kCHR;
    soft.m_rcontacts.push_back(contact);
}

}  // namespace

void add_soft_soft(btSoftBody& source, btSoftBody::Face& face, const btSoftBody& target,
                   const Contact& contact) {
    const btVector3 w = to_bullet(
        Vec3d{contact.barycentric[0], contact.barycentric[1], contact.barycentric[2]});
    for (const SourceNode& from : source_nodes(source, contact)) {
        btSoftBody::Node& node = *from.node;
        const btScalar node_share = node.m_im;
        const btScalar face_share = share_of(face, w);
        const btScalar both = node_share + face_share;
        if (both <= 0) continue;
        btSoftBody::SContact soft{};
        soft.m_node = &node;
        soft.m_face = &face;
        soft.m_weights = w;
        // The contact acts along the ray: force and counterforce lie on one line, so angular
        // momentum is kept, too.
        soft.m_normal = to_bullet(contact.source == Side::a ? -contact.normal : contact.normal);
        soft.m_margin = static_cast<btScalar>(dot(from_bullet(soft.m_normal), from.offset));
        soft.m_friction = btMax(source.m_cfg.kDF, target.m_cfg.kDF);
        soft.m_cfm[0] = from.weight * node_share / both * source.m_cfg.kSHR;
        soft.m_cfm[1] = from.weight * face_share / both * target.m_cfg.kSHR;
        source.m_scontacts.push_back(soft);
    }
}

void add_soft_rigid(btSoftBody& source, const btCollisionObject& target, const Contact& contact) {
    const Vec3d hit = contact.target_point();
    const Vec3d normal = contact.found != Found::separation ? contact.face_normal
                         : contact.source == Side::a        ? -contact.normal
                                                            : contact.normal;
    for (const SourceNode& from : source_nodes(source, contact))
        add_plane_contact(source, *from.node, target, normal, hit + from.offset, hit, from.weight);
}

void add_rigid_soft(const btCollisionObject& source, btSoftBody::Face& face, btSoftBody& target,
                    const Contact& contact) {
    const Vec3d way = contact.source_point() - contact.target_point();
    for (int k = 0; k < 3; ++k) {
        if (contact.barycentric[k] <= 0) continue;
        const Vec3d goal = from_bullet(face.m_n[k]->m_x) + way;
        add_plane_contact(target, *face.m_n[k], source, -contact.face_normal, goal,
                          contact.source_point(), static_cast<btScalar>(contact.barycentric[k]));
    }
}

}  // namespace pierce::bullet
