#pragma once

#include <cmath>
#include <utility>

#include "core/geometry/triangle.hpp"

/// Small ray-triangle tests to compare with the library's. Each says whether the ray meets the
/// closed triangle ahead. They work in float32, from the same rays. `fma` contracts products and
/// sums, as compilers do by default.
namespace pierce::leaks {

/// a b - c d.
template <bool fma, class T>
T difference(T a, T b, T c, T d) {
    return fma ? std::fma(a, b, -(c * d)) : a * b - c * d;
}

template <bool fma, class T>
Vec3<T> cross_of(Vec3<T> a, Vec3<T> b) {
    return {difference<fma>(a.y, b.z, a.z, b.y), difference<fma>(a.z, b.x, a.x, b.z),
            difference<fma>(a.x, b.y, a.y, b.x)};
}

template <bool fma, class T>
T dot_of(Vec3<T> a, Vec3<T> b) {
    return fma ? std::fma(a.z, b.z, std::fma(a.y, b.y, a.x * b.x)) : dot(a, b);
}

struct RayF {
    Vec3f origin, direction;
};

/// Moeller and Trumbore (1997).
template <bool fma>
bool moeller_trumbore(const RayF& ray, Vec3f a, Vec3f b, Vec3f c) {
    const Vec3f e1 = b - a, e2 = c - a, p = cross_of<fma>(ray.direction, e2);
    const float det = dot_of<fma>(e1, p);
    if (det == 0) return false;
    const Vec3f s = ray.origin - a, q = cross_of<fma>(s, e1);
    const float u = dot_of<fma>(s, p) / det, v = dot_of<fma>(ray.direction, q) / det;
    return u >= 0 && v >= 0 && u + v <= 1 && dot_of<fma>(e2, q) / det >= 0;
}

/// By Pluecker coordinates of the edges, relative to the ray's origin.
template <bool fma>
bool pluecker(const RayF& ray, Vec3f v0, Vec3f v1, Vec3f v2) {
    const Vec3f a = v0 - ray.origin, b = v1 - ray.origin, c = v2 - ray.origin;
    const float u = dot_of<fma>(cross_of<fma>(c - a, c + a), ray.direction);
    const float v = dot_of<fma>(cross_of<fma>(a - b, a + b), ray.direction);
    const float w = dot_of<fma>(cross_of<fma>(b - c, b + c), ray.direction);
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const Vec3f n = cross_of<fma>(a - b, c - a);
    const float det = dot_of<fma>(n, ray.direction);
    return det != 0 && dot_of<fma>(n, a) / det >= 0;
}

/// Woop, Benthin and Wald (2013). Edge functions in float32, again in double where one is zero; or,
/// with `all_double`, in double at once.
template <bool fma, bool all_double>
bool watertight(const RayF& ray, Vec3f v0, Vec3f v1, Vec3f v2) {
    const Vec3f d = ray.direction;
    const int z = std::fabs(d.x) > std::fabs(d.y) ? (std::fabs(d.x) > std::fabs(d.z) ? 0 : 2)
                                                  : (std::fabs(d.y) > std::fabs(d.z) ? 1 : 2);
    int x = (z + 1) % 3, y = (x + 1) % 3;
    if (d[z] < 0) std::swap(x, y);
    const float sx = d[x] / d[z], sy = d[y] / d[z], sz = 1 / d[z];
    const auto sheared = [&](Vec3f corner) {
        const Vec3f v = corner - ray.origin;
        return fma ? Vec3f{std::fma(-sx, v[z], v[x]), std::fma(-sy, v[z], v[y]), v[z]}
                   : Vec3f{v[x] - sx * v[z], v[y] - sy * v[z], v[z]};
    };
    const Vec3f a = sheared(v0), b = sheared(v1), c = sheared(v2);
    const auto edges = [&]<class T>(T) {
        const Vec3<T> p{a.x, a.y, a.z}, q{b.x, b.y, b.z}, r{c.x, c.y, c.z};
        return Vec3<T>{difference<fma>(r.x, q.y, r.y, q.x), difference<fma>(p.x, r.y, p.y, r.x),
                       difference<fma>(q.x, p.y, q.y, p.x)};
    };
    Vec3d e;
    if constexpr (all_double) {
        e = edges(double{});
    } else {
        const Vec3f quick = edges(float{});
        e = quick.x == 0 || quick.y == 0 || quick.z == 0 ? edges(double{}) : to_double(quick);
    }
    if ((e.x < 0 || e.y < 0 || e.z < 0) && (e.x > 0 || e.y > 0 || e.z > 0)) return false;
    const double det = e.x + e.y + e.z;
    if (det == 0) return false;
    return static_cast<double>(sz) * dot(e, to_double({a.z, b.z, c.z})) / det >= 0;
}

/// The library's own test.
inline bool pierce_test(const RayF& ray, Vec3f v0, Vec3f v1, Vec3f v2) {
    const Crossing crossing = cross_triangle({to_double(ray.origin), to_double(ray.direction)},
                                             to_double(v0), to_double(v1), to_double(v2));
    return crossing && crossing.t >= 0;
}

}  // namespace pierce::leaks
