#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/solid_angle.hpp"
#include "pierce/ids.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// The generalized winding number of a surface around points: the sum of the solid angles of its
/// triangles / 4 pi (Jacobson, Kavan and Sorkine-Hornung 2013). It is 1 inside a closed surface
/// that faces outward and 0 outside, and in between where the surface is open. Triangles that are
/// far away for their size count together, as dipoles (Barill et al. 2018).
class WindingTree {
public:
    /// The arrays must outlive the tree. Takes n log n.
    WindingTree(std::span<const Vec3f> positions, std::span<const Triangle> triangles);

    /// The winding number around `p`, without triangle `left_out`. A triangle in one plane with `p`
    /// adds nothing: on a closed surface the result is the mean of both sides.
    double at(Vec3d p, std::uint32_t left_out = no_triangle) const;
    /// The same by the solid angle of every triangle.
    double exactly_at(Vec3d p, std::uint32_t left_out = no_triangle) const;

private:
    /// A run of `order_` with all its triangles.
    struct Node {
        std::uint32_t begin = 0, end = 0;
        std::uint32_t skip = 0;  ///< the next node that is not below this one
        Vec3d center;
        Vec3d area;         ///< sum of normals times areas
        double radius = 0;  ///< no corner is further from the centre
    };

    void build(std::uint32_t begin, std::uint32_t end);
    Vec3d corner(std::uint32_t triangle, int k) const {
        return to_double(positions_[triangles_[triangle].vertex[k]]);
    }
    double angle_of(std::uint32_t triangle, Vec3d p) const {
        return solid_angle(corner(triangle, 0) - p, corner(triangle, 1) - p,
                           corner(triangle, 2) - p);
    }

    std::span<const Vec3f> positions_;
    std::span<const Triangle> triangles_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;  ///< depth first
};

}  // namespace pierce
