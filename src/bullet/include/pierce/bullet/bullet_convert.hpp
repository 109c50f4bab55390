#pragma once

#include <LinearMath/btTransform.h>

#include "pierce/pose.hpp"

/// Between Bullet's vectors and ours. Bullet may be built with float or double scalars.
namespace pierce::bullet {

inline btVector3 to_bullet(Vec3d v) {
    return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}
inline btVector3 to_bullet(Vec3f v) { return to_bullet(to_double(v)); }

inline Vec3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3f from_bullet_float(const btVector3& v) { return to_float(from_bullet(v)); }

inline btTransform to_bullet(const Pose& pose) {
    const Quaternion& q = pose.rotation;
    btQuaternion rotation(static_cast<btScalar>(q.x), static_cast<btScalar>(q.y),
                          static_cast<btScalar>(q.z), static_cast<btScalar>(q.w));
    rotation.normalize();
    return btTransform(rotation, to_bullet(pose.position));
}

inline Pose from_bullet(const btTransform& transform) {
    const btQuaternion q = transform.getRotation();
    return {from_bullet(transform.getOrigin()), {q.x(), q.y(), q.z(), q.w()}};
}

}  // namespace pierce::bullet
