#pragma once

#include "core/geometry/float_rules.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"

/// Bounds tighter than boxes for what is flat and aslant.
namespace pierce::stages {

/// A group or a block of triangles over the step, between two planes along its mean normal and
/// within a rectangle across it: float32, not smaller than what it holds. Layers that lie on each
/// other aslant have boxes that overlap those of many others; their slabs do not.
struct alignas(16) Slab {
    Vec3f center;
    Vec3f axis[3];  ///< the normal, and two at right angles to it; unit
    float half[3] = {};
    float rounding = 0;  ///< [length] by how much sums of the above may be wrong

    /// False for a slab that stands for nothing. If it is one of several, the slabs after it stand
    /// for nothing, too.
    PIERCE_HD bool holds_something() const { return quick_dot(axis[0], axis[0]) > 0; }

    /// True if nothing in the two slabs comes closer than `margin`. False proves nothing.
    PIERCE_HD bool is_apart(const Slab& other, float margin) const {
        return is_above_or_below(other, margin) || other.is_above_or_below(*this, margin) ||
               is_beside(other, margin);
    }

    /// True if along this slab's normal the other one is further away than `margin`.
    PIERCE_HD bool is_above_or_below(const Slab& other, float margin) const {
        const Vec3f n = axis[0];
        float reach = half[0] + margin + rounding + other.rounding;
        for (int k = 0; k < 3; ++k) reach += other.half[k] * std::fabs(quick_dot(n, other.axis[k]));
        return std::fabs(quick_dot(n, other.center - center)) > reach;
    }

    /// True if along the line between the centres the other one is further away than `margin`.
    PIERCE_HD bool is_beside(const Slab& other, float margin) const {
        const Vec3f d = other.center - center;
        float reach = (margin + rounding + other.rounding) *
                      (std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z));
        for (int k = 0; k < 3; ++k)
            reach += half[k] * std::fabs(quick_dot(d, axis[k])) +
                     other.half[k] * std::fabs(quick_dot(d, other.axis[k]));
        return quick_dot(d, d) > reach;
    }
};

/// Axes and extents from which a slab is made, in double.
struct SlabFrame {
    Vec3d axis[3];

    PIERCE_HD explicit SlabFrame(Vec3d normal) {
        axis[0] = normalized(normal);
        if (length_squared(axis[0]) == 0) axis[0] = {0, 0, 1};
        const Vec3d n = axis[0];
        const int least = std::fabs(n.x) <= std::fabs(n.y) && std::fabs(n.x) <= std::fabs(n.z) ? 0
                          : std::fabs(n.y) <= std::fabs(n.z)                                   ? 1
                                                                                               : 2;
        Vec3d side;
        side[least] = 1;
        axis[1] = normalized(cross(n, side));
        axis[2] = cross(n, axis[1]);
    }

    PIERCE_HD Vec3d along(Vec3d p) const {
        return {dot(axis[0], p), dot(axis[1], p), dot(axis[2], p)};
    }

    /// The slab of what lies within `extent` along the axes, relative to `origin`.
    PIERCE_HD Slab slab(const Box& extent, Vec3d origin) const {
        const Vec3d middle = extent.center(), half = extent.half_size();
        Slab slab;
        slab.center = to_float(origin + middle.x * axis[0] + middle.y * axis[1] +
                               middle.z * axis[2]);
        double largest = length(half);
        for (int k = 0; k < 3; ++k) {
            slab.axis[k] = to_float(axis[k]);
            slab.half[k] = round_up(half[k]);
            largest = max_of(std::fabs(static_cast<double>(slab.center[k])), largest);
        }
        // u: half a float32 ulp. Two centres are at most 3.5 times the largest coordinate apart;
        // their difference is off by 4 u of it, the axis by 1 u, the dot product by 3 u more: 28 u
        // in all, and as much again for the sum of the reaches.
        slab.rounding = round_up(4 * constants::slab_margin * largest);
        return slab;
    }
};

}  // namespace pierce::stages
