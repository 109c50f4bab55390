#pragma once

#include "pierce/vec3.hpp"

namespace pierce {

/// A rotation as a quaternion, vector part first. It need not be of unit length; its squared length
/// is from constants::smallest_rotation to constants::largest_rotation, or the body is left out.
struct Quaternion {
    double x = 0, y = 0, z = 0, w = 1;

    friend bool operator==(const Quaternion&, const Quaternion&) = default;
};

/// Places a rigid body: a point x of its mesh stands at rotation * x + position.
struct Pose {
    Vec3d position;
    Quaternion rotation;

    friend bool operator==(const Pose&, const Pose&) = default;
};

/// True if two poses are the same, bit for bit.
PIERCE_HD constexpr bool are_identical(const Pose& a, const Pose& b) {
    const Quaternion &q = a.rotation, &r = b.rotation;
    return are_identical(a.position, b.position) &&
           are_identical(Vec3d{q.x, q.y, q.z}, Vec3d{r.x, r.y, r.z}) &&
           are_identical(Vec3d{q.w, 0, 0}, Vec3d{r.w, 0, 0});
}

/// A matrix of three rows of three.
struct Matrix3 {
    Vec3d row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

    PIERCE_HD Vec3d operator*(Vec3d v) const {
        return {dot(row[0], v), dot(row[1], v), dot(row[2], v)};
    }

    PIERCE_HD Matrix3 transposed() const {
        return {{{row[0].x, row[1].x, row[2].x},
                 {row[0].y, row[1].y, row[2].y},
                 {row[0].z, row[1].z, row[2].z}}};
    }

    PIERCE_HD Matrix3 operator*(const Matrix3& b) const {
        const Matrix3 t = b.transposed();
        return {{t * row[0], t * row[1], t * row[2]}};
    }
};

/// An orthonormal coordinate frame: takes a local point to rotation * x + origin.
struct Frame {
    Matrix3 rotation;
    Vec3d origin;

    PIERCE_HD Vec3d to_parent(Vec3d local) const { return rotation * local + origin; }
    PIERCE_HD Vec3d to_local(Vec3d point) const { return rotation.transposed() * (point - origin); }

    PIERCE_HD Frame inverse() const {
        const Matrix3 back = rotation.transposed();
        return {back, -(back * origin)};
    }
};

/// True if two frames are the same, bit for bit.
PIERCE_HD inline bool are_identical(const Frame& a, const Frame& b) {
    bool same = are_identical(a.origin, b.origin);
    for (int r = 0; r < 3; ++r) same = same && are_identical(a.rotation.row[r], b.rotation.row[r]);
    return same;
}

/// The rotation matrix of a quaternion of any length but zero.
PIERCE_HD inline Matrix3 rotation_matrix(Quaternion q) {
    const double s = 2.0 / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    const double xx = s * q.x * q.x, yy = s * q.y * q.y, zz = s * q.z * q.z;
    const double xy = s * q.x * q.y, xz = s * q.x * q.z, yz = s * q.y * q.z;
    const double wx = s * q.w * q.x, wy = s * q.w * q.y, wz = s * q.w * q.z;
    return {{{1 - yy - zz, xy - wz, xz + wy},
             {xy + wz, 1 - xx - zz, yz - wx},
             {xz - wy, yz + wx, 1 - xx - yy}}};
}

PIERCE_HD inline Frame frame_of(const Pose& pose) {
    return {rotation_matrix(pose.rotation), pose.position};
}

/// The map from frame `from` into frame `to`, as a frame. Identity frames give the exact identity.
PIERCE_HD inline Frame relative_frame(const Frame& from, const Frame& to) {
    const Matrix3 inverse = to.rotation.transposed();
    return {inverse * from.rotation, inverse * (from.origin - to.origin)};
}

}  // namespace pierce
