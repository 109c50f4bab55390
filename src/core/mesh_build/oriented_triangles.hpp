#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce {

/// The triangles of a mesh, each once, turned so that neighbours face the same way.
struct OrientedTriangles {
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> given;  ///< per triangle, its id in the mesh
    std::vector<bool> turned;          ///< per triangle
    /// Per triangle, the number of its patch: triangles that are connected by edges with two
    /// triangles.
    std::vector<std::uint32_t> patch;
    std::uint32_t patches = 0;

    /// Per patch: some of its edges lack a triangle of its own, or have one too many.
    std::vector<bool> open_patches(std::size_t vertex_count) const;

    /// Makes a triangle face the other way.
    void turn(std::uint32_t t) {
        std::swap(triangles[t].vertex[1], triangles[t].vertex[2]);
        turned[t] = !turned[t];
    }
};

/// Leaves out triangles that have a vertex twice, and all but one of those with the same vertices.
/// Within a patch, those of the smaller area are turned; a triangle that is given both ways has no
/// say. Where a patch cannot be oriented, as a Moebius strip, some neighbours still disagree.
OrientedTriangles oriented_triangles(std::span<const Vec3f> positions,
                                     std::span<const Triangle> triangles);

}  // namespace pierce
