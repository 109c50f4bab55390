#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pierce/host_device.hpp"

namespace pierce {

/// Three coordinates.
template <class T>
struct Vec3 {
    T x{}, y{}, z{};

    PIERCE_HD constexpr T operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
    PIERCE_HD constexpr T& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }

    PIERCE_HD friend constexpr Vec3 operator+(Vec3 a, Vec3 b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    PIERCE_HD friend constexpr Vec3 operator-(Vec3 a, Vec3 b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    PIERCE_HD friend constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
    PIERCE_HD friend constexpr Vec3 operator*(T s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
    PIERCE_HD friend constexpr Vec3 operator*(Vec3 a, T s) { return s * a; }
    PIERCE_HD constexpr Vec3& operator+=(Vec3 b) { return *this = *this + b; }
    PIERCE_HD constexpr Vec3& operator-=(Vec3 b) { return *this = *this - b; }
    friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <class T>
PIERCE_HD constexpr T dot(Vec3<T> a, Vec3<T> b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class T>
PIERCE_HD constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class T>
PIERCE_HD constexpr T length_squared(Vec3<T> a) {
    return dot(a, a);
}

template <class T>
PIERCE_HD T length(Vec3<T> a) {
    return std::sqrt(dot(a, a));
}

/// The unit vector along `a`; the zero vector stays zero.
template <class T>
PIERCE_HD Vec3<T> normalized(Vec3<T> a) {
    const T l = length(a);
    return l > T(0) ? Vec3<T>{a.x / l, a.y / l, a.z / l} : Vec3<T>{};
}

PIERCE_HD constexpr Vec3d to_double(Vec3f a) { return {a.x, a.y, a.z}; }
PIERCE_HD constexpr Vec3f to_float(Vec3d a) {
    return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

/// True if no coordinate is NaN or infinite.
template <class T>
PIERCE_HD constexpr bool is_finite(Vec3<T> a) {
    // x - x is NaN for both NaN and infinity, and only then.
    return (a.x - a.x) == T(0) && (a.y - a.y) == T(0) && (a.z - a.z) == T(0);
}

/// True if two vectors are the same, bit for bit: 0 is not -0.
PIERCE_HD constexpr bool are_identical(Vec3d a, Vec3d b) {
    bool same = true;
    for (int k = 0; k < 3; ++k)
        same = same && std::bit_cast<std::uint64_t>(a[k]) == std::bit_cast<std::uint64_t>(b[k]);
    return same;
}

}  // namespace pierce
