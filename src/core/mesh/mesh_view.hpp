#pragma once

#include <cstdint>
#include <vector>

#include "core/device/view.hpp"
#include "core/geometry/grid_boxes.hpp"
#include "core/mesh/clearance_grid.hpp"
#include "core/mesh/leaf.hpp"
#include "core/mesh/slab_grid.hpp"
#include "core/mesh/surface.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/ids.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

PIERCE_HD inline bool has_vertex(const Triangle& t, std::uint32_t v) {
    return t.vertex[0] == v || t.vertex[1] == v || t.vertex[2] == v;
}

/// The first of a triangle's corners that is vertex `v`; the triangle must have that vertex.
PIERCE_HD inline int corner_of(const Triangle& t, std::uint32_t v) {
    return t.vertex[0] == v ? 0 : t.vertex[1] == v ? 1 : 2;
}

/// Two neighbouring vertices, and the two triangles that share them. At a border, and where more
/// than two triangles meet or two run through the edge the same way, every triangle has an edge of
/// its own, whose other triangle is no_triangle.
struct Edge {
    std::uint32_t vertex[2];
    std::uint32_t triangle[2];
};

/// A triangle's edges, and which of its vertices and edges are its own: each vertex and edge
/// belongs to one triangle, so that a loop over all triangles sees each once (Curtis, Tamstorf and
/// Manocha 2008).
struct TriangleFeatures {
    std::uint32_t edge[3] = {};  ///< edge[k] joins vertex k and the next one; no_vertex for an edge
                                 ///< that joins a vertex to itself
    std::uint32_t own = 0;       ///< bit k: vertex k; bit 3 + k: edge k
};

/// The other two vertices of a triangle at a vertex, counter-clockwise seen from outside.
struct Corner {
    std::uint32_t next, previous;
};

/// A few points relative to a centre, stored side by side for vector arithmetic. They are float32:
/// their error is half an ulp of their length.
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
    float motion = 0;  ///< [length] none of its vertices moved further in the last step
    float padding = 0;
};

/// Sixteen edges of a mesh as spheres around their middles, relative to a centre. Places past the
/// last edge repeat the centre.
struct EdgeGroup {
    Offsets middles;
    float half[Offsets::count] = {};  ///< [length] half of the edge, rounded up
};

/// Spheres around the patches (patch.hpp) of a block, in the space of the positions.
struct PatchBlock {
    Vec3d center;
    Offsets offsets;  ///< of the spheres' centres
    float radius[constants::block_size] = {};
    float reach = 0;  ///< no vertex is further than this from `center`
};

/// A node of a tree of boxes (box_nodes.hpp).
struct alignas(16) BoxNode {
    GridBoxes boxes;  ///< of its sixteen triangles or nodes; those that it does not have are empty
    QuickBox around;  ///< all of them
};

/// The triangles across a triangle's edges: across[k] lies opposite its vertex k. It is no_triangle
/// at a border, or where more than two triangles meet.
struct Neighbors {
    std::uint32_t across[3] = {no_triangle, no_triangle, no_triangle};
};

/// What is known of a triangle's ring: the triangles that share a vertex with it, itself among
/// them.
struct TriangleRing {
    Vec3f axis;      ///< a cone around this axis holds all normals of the ring
    float sine = 2;  ///< of the cone's half angle; 2 if the ring's triangles face different ways,
                     ///< or do not lie side by side around the axis
    float gap = 0;   ///< [length] no triangle outside the ring comes closer than this to any point
                     ///< of the triangle
    float openness = 0;    ///< no triangle of the ring comes closer to a point of the triangle than
                           ///< this part of the point's distance to the triangle's border
    float height[3] = {};  ///< [length] of the triangle over its edges, opposite vertex k
    float tilt = 0;  ///< [1 / length] when vertices move, the sine of the angle by which a normal
                     ///< of the ring turns is below this times how far they move
};

/// A connected part of a surface by four of its vertices that, in the rest shape, are far from each
/// other and from one plane, unless the part is flat: the first vertex, the one furthest from it,
/// from the line through both, and from the plane through the three.
struct MeshPart {
    static constexpr std::uint32_t count = 4;

    std::uint32_t vertex[count] = {};
};

/// All arrays of a mesh, each declared here once. They are views, vectors of their owner, or copies
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
    Array<std::uint32_t> patch_vertices;  ///< all vertices of triangles, patch after patch,
                                          ///< constants::patch_size each
    Array<PatchBlock> blocks;             ///< of the rest shape
    Array<Offsets> patches;  ///< per patch, its vertices relative to its centre; of the rest shape
    Array<Edge> edges;       ///< group after group (edge_group.hpp)
    Array<EdgeGroup> edge_groups;          ///< of the rest shape
    Array<PatchBlock> edge_blocks;         ///< spheres around groups of edges; of the rest shape
    Array<TriangleFeatures> features;      ///< per triangle
    Array<std::uint32_t> group_triangles;  ///< all triangles, group after group,
                                           ///< constants::group_size each
    Array<BoxNode> box_nodes;     ///< a tree of boxes (box_nodes.hpp) around the rest shape
    Array<bvh::Leaf> leaves;      ///< all triangles, by ones and twos
    Array<MeshPart> parts;        ///< of every connected part
    Array<Cover> covered;         ///< per triangle, of the rest shape; empty if no parts overlap
    Array<Neighbors> neighbors;   ///< per triangle
    Array<TriangleRing> rings;    ///< per triangle; of the rest shape
    Array<float> star_clearance;  ///< per vertex; empty for a mesh that is not closed
    Array<double> own_exit;  ///< per vertex, length of its inward ray inside the rest shape; -1
                             ///< where the ray does not start inside; empty for a mesh that is not
                             ///< closed
    Array<std::uint8_t> clearance_steps;  ///< cells of clearance(); empty for a mesh that is not
                                          ///< closed
    Array<SlabCell> slab_cells;           ///< this and the next are of slabs_by_cell()
    Array<CellSlab> slabs;
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
    f(m.edge_groups...);
    f(m.edge_blocks...);
    f(m.features...);
    f(m.group_triangles...);
    f(m.box_nodes...);
    f(m.leaves...);
    f(m.parts...);
    f(m.covered...);
    f(m.neighbors...);
    f(m.rings...);
    f(m.star_clearance...);
    f(m.own_exit...);
    f(m.clearance_steps...);
    f(m.slab_cells...);
    f(m.slabs...);
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

/// Which arrays of a mesh are made, besides those that every step reads. Only closed meshes have
/// them.
struct MeshNeeds {
    bool clearance = false;  ///< clearance_steps
    bool rings = false;      ///< rings; whether the mesh is simple
    bool slabs = false;      ///< slab_cells and slabs
    bool stars = false;      ///< star_clearance
    bool own_exits = false;  ///< own_exit

    /// True if this is all that is needed.
    bool has(const MeshNeeds& needs) const {
        return clearance >= needs.clearance && rings >= needs.rings && slabs >= needs.slabs &&
               stars >= needs.stars && own_exits >= needs.own_exits;
    }

    friend bool operator==(const MeshNeeds&, const MeshNeeds&) = default;

    static constexpr MeshNeeds all() {
        return {.clearance = true, .rings = true, .slabs = true, .stars = true, .own_exits = true};
    }
};

/// What a mesh has once, besides its arrays.
struct MeshShape {
    Box box;                           ///< of the rest shape
    Vec3d centroid;                    ///< mean of the triangles' vertices at rest
    double mean_edge_length = 0;       ///< [length]
    ClearanceGridLayout clearance_at;  ///< of clearance()
    ClearanceGridLayout slabs_at;      ///< of slabs_by_cell()
    bool closed = false;
    bool has_degenerate = false;  ///< some triangles have no area at rest
    bool simple = false;  ///< one closed surface that does not meet itself and is not inside out;
                          ///< false where nobody needed to know
};

/// A mesh as stages see it. Offsets and ids are checked only when the mesh is made.
struct MeshView : MeshArrays<ConstView>, MeshShape {
    /// False if all vertices lie in one place.
    PIERCE_HD bool has_extent() const { return box.extent() > 0; }
    /// A lower bound of the distance of points to the rest shape; of a mesh that is not closed
    /// nothing is known.
    PIERCE_HD ClearanceGridView clearance() const { return {clearance_at, clearance_steps}; }
    /// Where the rest shape's surface is and which way it faces, cell by cell of a coarser grid.
    PIERCE_HD SlabGridView slabs_by_cell() const { return {slabs_at, slab_cells, slabs}; }
};

}  // namespace pierce
