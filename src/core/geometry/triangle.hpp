#pragma once

#include "core/geometry/float_rules.hpp"
#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// True if the triangle is too thin to have a normal.
PIERCE_HD inline bool is_degenerate(Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d ab = b - a, bc = c - b, ca = a - c;
    const double longest = max_of(length_squared(ab),
                                  max_of(length_squared(bc), length_squared(ca)));
    const double least = constants::degenerate_area * longest;
    return !(length_squared(cross(ab, ca)) > least * least);
}

/// A ray prepared for the triangle test: the axis it runs along most becomes the third, and a shear
/// makes it run along that axis alone.
struct ShearedRay {
    Vec3d origin;
    Vec3d direction;
    int axis = 2;
    double shear_x = 0, shear_y = 0;
    double facing = 1;  ///< -1 if the ray runs against its axis

    ShearedRay() = default;
    PIERCE_HD ShearedRay(Vec3d ray_origin, Vec3d ray_direction)
        : origin(ray_origin), direction(ray_direction) {
        const double x = std::fabs(direction.x), y = std::fabs(direction.y),
                     z = std::fabs(direction.z);
        axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
        const Vec3d d = turned(direction);
        shear_x = d.x / d.z;
        shear_y = d.y / d.z;
        facing = d.z < 0 ? -1.0 : 1.0;
    }

    /// The coordinates in cyclic order with the ray's axis last.
    PIERCE_HD Vec3d turned(Vec3d v) const {
        if (axis == 2) return v;
        return axis == 1 ? Vec3d{v.z, v.x, v.y} : Vec3d{v.y, v.z, v.x};
    }

    /// The place of a point as seen along the ray; the point is given relative to the origin, and
    /// the shear keeps its third coordinate.
    PIERCE_HD Vec3d sheared(Vec3d relative) const {
        const Vec3d v = turned(relative);
        return {v.x - shear_x * v.z, v.y - shear_y * v.z, v.z};
    }
};

/// How a line meets a triangle.
struct Crossing {
    enum Kind : std::uint8_t {
        none,
        transversal,  ///< the line passes through the closed triangle
        coplanar,     ///< the line lies in the triangle's plane
    };
    Kind kind = none;
    double t = 0;     ///< along the ray's direction; negative behind the origin
    double sign = 0;  ///< +1: leaves through the back (exit), -1: comes in from the front (entry)
    double weight[3] = {};  ///< barycentric coordinates of the point hit

    PIERCE_HD explicit operator bool() const { return kind == transversal; }
};

/// The one geometric truth of the library: the watertight line-triangle test of Woop, Benthin and
/// Wald (JCGT 2(1), 2013) in double. Neighbouring triangles compute their shared edge function from
/// the same sheared vertices with the operands swapped, so it differs in sign only and no line
/// passes between them.
PIERCE_HD inline Crossing cross_triangle(const ShearedRay& ray, Vec3d v0, Vec3d v1, Vec3d v2) {
    const Vec3d a = v0 - ray.origin, b = v1 - ray.origin, c = v2 - ray.origin;
    const Vec3d p = ray.sheared(a), q = ray.sheared(b), r = ray.sheared(c);
    const double u = r.x * q.y - r.y * q.x;
    const double v = p.x * r.y - p.y * r.x;
    const double w = q.x * p.y - q.y * p.x;

    Crossing crossing;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return crossing;
    if (is_degenerate(v0, v1, v2)) return crossing;
    const double reach = length_squared(a) + length_squared(b) + length_squared(c);
    if (std::fabs(u) + std::fabs(v) + std::fabs(w) <= constants::coplanar_tolerance * reach) {
        crossing.kind = Crossing::coplanar;
        return crossing;
    }
    const double det = u + v + w;
    crossing.kind = Crossing::transversal;
    crossing.sign = det < 0 ? ray.facing : -ray.facing;
    crossing.weight[0] = u / det;
    crossing.weight[1] = v / det;
    crossing.weight[2] = w / det;
    crossing.t = dot(crossing.weight[0] * a + crossing.weight[1] * b + crossing.weight[2] * c,
                     ray.direction);
    return crossing;
}

/// The part of the full turn around the line that the triangle covers; half a turn is
/// constants::half_turn units. The part is two half turns if the line passes through the inside,
/// one through an edge, and the triangle's angle through a vertex. Signed shares of all triangles
/// that the line meets at one point of a closed surface add up to the change of the winding number,
/// times two half turns. Shares are whole numbers, so that their sum does not depend on the order.
PIERCE_HD inline std::int64_t crossing_share(const ShearedRay& ray, Vec3d v0, Vec3d v1, Vec3d v2,
                                             const Crossing& crossing) {
    constexpr double pi = 3.14159265358979323846;
    const bool on[3] = {crossing.weight[0] == 0, crossing.weight[1] == 0, crossing.weight[2] == 0};
    const int zeros = on[0] + on[1] + on[2];
    if (zeros == 0) return 2 * constants::half_turn;
    if (zeros == 1) return constants::half_turn;
    // The corner hit and the two after it. They are not in an array, because a GPU would keep an
    // array in memory.
    const Vec3d p = !on[0]   ? v0
                    : !on[1] ? v1
                             : v2,
                q = !on[0]   ? v1
                    : !on[1] ? v2
                             : v0,
                r = !on[0]   ? v2
                    : !on[1] ? v0
                             : v1;
    const auto flat = [&](Vec3d corner) {
        const Vec3d d = ray.sheared(corner - p);
        return Vec3d{d.x, d.y, 0};
    };
    const Vec3d e = flat(q), f = flat(r);
    const double part = angle_of(dot(e, f), std::fabs(e.x * f.y - e.y * f.x)) / pi;
    return static_cast<std::int64_t>(part * static_cast<double>(constants::half_turn));
}

/// True if `p`, known to lie in the triangle's plane, lies in the triangle or closer than
/// `tolerance` to its three sides and to its box. The box counts because, beyond a sharp corner,
/// the lines along the sides stay near for longer than boxes of trees reach.
PIERCE_HD inline bool touches_triangle(Vec3d p, Vec3d v0, Vec3d v1, Vec3d v2, double tolerance) {
    for (int k = 0; k < 3; ++k)
        if (p[k] < min_of(v0[k], min_of(v1[k], v2[k])) - tolerance ||
            p[k] > max_of(v0[k], max_of(v1[k], v2[k])) + tolerance)
            return false;
    const Vec3d n = normalized(cross(v1 - v0, v2 - v0));
    if (length_squared(n) == 0 || std::fabs(dot(n, p - v0)) > tolerance) return false;
    const auto is_beyond = [&](Vec3d from, Vec3d to) {
        return dot(cross(n, normalized(to - from)), p - from) < -tolerance;
    };
    return !is_beyond(v0, v1) && !is_beyond(v1, v2) && !is_beyond(v2, v0);
}

}  // namespace pierce
