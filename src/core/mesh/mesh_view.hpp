#pragma once

#include <cstdint>
#include <vector>

#include "core/device/view.hpp"
#include "core/mesh/clearance_grid.hpp"
#include "core/mesh/leaf.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/ids.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

PIERCE_HD inline bool has_vertex(const Triangle& t, std::uint32_t v) {
    return t.vertex[0] == v || t.vertex[1] == v || t.vertex[2] == v;
}

/// The first of a triangle's corners that is vertex `v`, which it has.
PIERCE_HD inline int corner_of(const Triangle& t, std::uint32_t v) {
    return t.vertex[0] == v ? 0 : t.vertex[1] == v ? 1 : 2;
}

/// Two vertices that are next to each other, and the two triangles there. At a border, and where
/// more than two triangles meet or two run through it the same way, every triangle has an edge of
/// its own there and the other one is no_triangle.
struct Edge {
    std::uint32_t vertex[2];
    std::uint32_t triangle[2];
};

/// A triangle's edges, and which of its vertices and edges are its own: each vertex and edge
/// belongs to one triangle, so that whoever looks at all triangles sees each once (Curtis, Tamstorf
/// and Manocha 2008).
struct TriangleFeatures {
    std::uint32_t edge[3] = {};  ///< edge[k] joins vertex k and the next one; no_vertex for one of
                                 ///< no length
    std::uint32_t own = 0;       ///< bit k: vertex k; bit 3 + k: edge k
};

/// A triangle as one of its vertices sees it: the other two, counter-clockwise seen from outside.
struct Corner {
    std::uint32_t next, previous;
};

/// A few points relative to a centre, side by side for vector arithmetic. float32: their error is
/// half an ulp of how far they reach.
struct alignas(16) Offsets {
    static constexpr std::uint32_t count = 16;
    float x[count] = {}, y[count] = {}, z[count] = {};

    PIERCE_HD void set(std::uint32_t i, Vec3f offset) {
        x[i] = offset.x;
        y[i] = offset.y;
        z[i] = offset.z;
    }
};
static_assert(constants::patch_size == Offsets::count && constants::block_size == Offsets::count);

/// A patch as it was last seen.
struct SeenPatch {
    Vec3d center;
    Offsets offsets;
};

/// Spheres around the patches (patch.hpp) of a block, in the space of the positions.
struct PatchBlock {
    Vec3d center;
    Offsets offsets;  ///< of the spheres' centres
    float radius[constants::block_size] = {};
    float reach = 0;  ///< no vertex is further from `center`
};

/// The triangles across a triangle's edges: across[k] lies opposite its vertex k. None at a border,
/// or where more than two triangles meet.
struct Neighbors {
    std::uint32_t across[3] = {no_triangle, no_triangle, no_triangle};
};

/// The triangles that share a vertex with a triangle, itself among them.
struct TriangleRing {
    Vec3f axis;          ///< a cone around it holds all their normals
    float sine = 2;      ///< of the cone's half angle; 2 if they face different ways, or do not lie
                         ///< side by side around it
    float gap = 0;       ///< [length] no other triangle comes closer to any point of the triangle
    float openness = 0;  ///< no triangle of the ring comes closer to a point of the triangle than
                         ///< this part of the point's distance to the triangle's border
    float height[3] = {};  ///< [length] of the triangle over its edges, opposite vertex k
    float tilt = 0;  ///< [1 / length] the sine by which a normal of the ring turns is below this
                     ///< times how far vertices move
};

/// All arrays of a mesh, each declared here once: as views, as vectors of their owner, or as copies
/// on a device.
template <template <class> class Array>
struct MeshArrays {
    Array<Vec3f> positions;  ///< rest shape
    Array<Triangle> triangles;
    Array<Vec3f> normals;  ///< unit, outward, of the rest shape; zero where undefined
    Array<std::uint32_t> corner_offsets;  ///< vertex_count + 1; of vertex v:
                                          ///< corners[offsets[v]..offsets[v+1])
    Array<Corner> corners;
    Array<std::uint32_t> fans;            ///< per corner, the vertices around each vertex (fans_of)
    Array<std::uint32_t> patch_vertices;  ///< all vertices, patch after patch,
                                          ///< constants::patch_size each
    Array<PatchBlock> blocks;             ///< of the rest shape
    Array<Offsets> patches;  ///< per patch, its vertices relative to its centre; of the rest shape
    Array<Edge> edges;       ///< patch after patch, each with its first vertex
    Array<std::uint32_t> edge_offsets;     ///< per patch and one more: where its edges begin
    Array<float> edge_reach;               ///< per patch, its longest edge; of the rest shape
    Array<TriangleFeatures> features;      ///< per triangle
    Array<std::uint32_t> group_triangles;  ///< all triangles, group after group,
                                           ///< constants::group_size each
    Array<bvh::Leaf> leaves;               ///< all triangles, by ones and twos
    Array<std::uint32_t> parts;            ///< one vertex of every connected part
    Array<Neighbors> neighbors;            ///< per triangle
    Array<TriangleRing> rings;             ///< per triangle; of the rest shape
    Array<float> star_clearance;           ///< per vertex; empty for a mesh that is not closed
    Array<double> own_exit;  ///< per vertex, length of its inward ray inside the rest shape; -1
                             ///< where that does not start inside; empty for a mesh that is not
                             ///< closed
    Array<std::uint8_t> clearance_steps;  ///< cells of clearance(); empty for a mesh that is not
                                          ///< closed
};

/// Calls f(m.array...) for every array of some meshes' MeshArrays.
template <class F, class... M>
constexpr void for_each_array(F&& f, M&... m) {
    f(m.positions...);
    f(m.triangles...);
    f(m.normals...);
    f(m.corner_offsets...);
    f(m.corners...);
    f(m.fans...);
    f(m.patch_vertices...);
    f(m.blocks...);
    f(m.patches...);
    f(m.edges...);
    f(m.edge_offsets...);
    f(m.edge_reach...);
    f(m.features...);
    f(m.group_triangles...);
    f(m.leaves...);
    f(m.parts...);
    f(m.neighbors...);
    f(m.rings...);
    f(m.star_clearance...);
    f(m.own_exit...);
    f(m.clearance_steps...);
}

template <class T>
using ConstView = View<const T>;

static_assert(
    [] {
        MeshArrays<ConstView> arrays;
        std::size_t bytes = 0;
        for_each_array([&](auto& array) { bytes += sizeof array; }, arrays);
        return bytes == sizeof arrays;
    }(),
    "for_each_array names every array");

/// What a mesh has one of.
struct MeshShape {
    Box box;                           ///< of the rest shape
    Vec3d centroid;                    ///< mean of the rest positions
    double mean_edge_length = 0;       ///< [length]
    ClearanceGridLayout clearance_at;  ///< of clearance()
    bool closed = false;
    bool simple = false;  ///< one closed surface that does not meet itself and has its inside
                          ///< inside
};

/// A mesh as stages see it. Offsets and ids are checked when the mesh is made, never again.
struct MeshView : MeshArrays<ConstView>, MeshShape {
    /// How far points are from the rest shape, at least; nothing is known of a mesh that is not
    /// closed.
    PIERCE_HD ClearanceGridView clearance() const { return {clearance_at, clearance_steps}; }
};

}  // namespace pierce
