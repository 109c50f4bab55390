#pragma once

#include "pierce/contact.hpp"
#include "pierce/min_max.hpp"
#include "pierce/parting.hpp"

namespace pierce::bullet {

/// A contact in the form that Bullet's rigid solver needs: the normal points from B to A, and the
/// two points lie one depth apart along it, so that equal and opposite impulses at the points
/// conserve angular momentum.
struct FramedContact {
    Vec3d point_a, point_b;
    Vec3d normal_on_b;
    double distance = 0;  ///< negative where the bodies overlap
    std::uint64_t feature = 0;
    std::uint32_t age = 0;
};

/// Uses the target's face normal instead of the ray's direction. A flat target then pushes straight
/// out, not along the vertex normal of the body that stands on it. The depth becomes the vertex's
/// depth below the face's plane, and the target point becomes the vertex's projection onto that
/// plane. A contact along a direction of separation keeps that direction, as the face that its ray
/// leaves through says nothing about the way out. So does one that is only near, as an edge or a
/// corner may be nearest, and one of an edge over a ridge, whose way out is across both.
inline FramedContact face_frame(const Contact& contact) {
    if (contact.found == Found::separation || contact.found == Found::near ||
        (contact.reprojected && contact.is_edge()))
        return {.point_a = contact.point_a,
                .point_b = contact.point_b,
                .normal_on_b = -contact.normal,
                .distance = contact.distance,
                .feature = contact.feature(),
                .age = contact.age};
    const bool from_a = contact.source == Side::a;
    const Vec3d vertex = from_a ? contact.point_a : contact.point_b;
    const Vec3d on_target = from_a ? contact.point_b : contact.point_a;
    const double depth = max_of(dot(on_target - vertex, contact.face_normal), 0.0);
    const Vec3d foot = vertex + depth * contact.face_normal;
    if (from_a)
        return {.point_a = vertex,
                .point_b = foot,
                .normal_on_b = contact.face_normal,
                .distance = -depth,
                .feature = contact.feature(),
                .age = contact.age};
    return {.point_a = foot,
            .point_b = vertex,
            .normal_on_b = -contact.face_normal,
            .distance = -depth,
            .feature = contact.feature(),
            .age = contact.age};
}

/// Lets the whole way apart of a pair act at a contact, whose own way out is against others.
inline FramedContact parting_frame(const Contact& contact, const Parting& parting) {
    const Vec3d middle = 0.5 * (contact.point_a + contact.point_b),
                half = 0.5 * parting.translation();
    return {.point_a = middle + half,
            .point_b = middle - half,
            .normal_on_b = -parting.direction,
            .distance = -parting.depth,
            .feature = contact.feature(),
            .age = contact.age};
}

}  // namespace pierce::bullet
