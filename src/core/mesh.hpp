#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pierce/core/box.hpp"
#include "pierce/core/bvh/leaf.hpp"
#include "pierce/core/clearance_grid.hpp"
#include "pierce/core/constants.hpp"
#include "pierce/core/ids.hpp"
#include "pierce/core/view.hpp"

namespace pierce {

/// Three vertex ids, counter-clockwise seen from outside.
struct Triangle {
    std::uint32_t vertex[3];

    friend bool operator==(const Triangle&, const Triangle&) = default;
};

PIERCE_HD inline bool has_vertex(const Triangle& t, std::uint32_t v) {
    return t.vertex[0] == v || t.vertex[1] == v || t.vertex[2] == v;
}

/// The first of a triangle's corners that is vertex `v`, which it has.
PIERCE_HD inline int corner_of(const Triangle& t, std::uint32_t v) { return t.vertex[0] == v ? 0 : t.vertex[1] == v ? 1 : 2; }

/// Two vertices that are next to each other, and the two triangles there. At a border, and where more than two triangles
/// meet or two run through it the same way, every triangle has an edge of its own there and the other one is no_triangle.
struct Edge {
    std::uint32_t vertex[2];
    std::uint32_t triangle[2];
};

/// A triangle's edges, and which of its vertices and edges are its own: each vertex and edge belongs to one triangle, so
/// that whoever looks at all triangles sees each once (Curtis, Tamstorf and Manocha 2008).
struct TriangleFeatures {
    std::uint32_t edge[3] = {};  ///< edge[k] joins vertex k and the next one; no_vertex for one of no length
    std::uint32_t own = 0;       ///< bit k: vertex k; bit 3 + k: edge k
};

/// A triangle as one of its vertices sees it: the other two, counter-clockwise seen from outside.
struct Corner {
    std::uint32_t next, previous;
};

/// What a mesh is made from: vertex positions and triangles, in the caller's numbering and unit.
struct MeshData {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
};

/// What was found out about a mesh's topology; decides which contact rules apply to it.
struct MeshTraits {
    std::uint32_t boundary_edges = 0;        ///< edges with one triangle
    std::uint32_t non_manifold_edges = 0;    ///< edges with more than two triangles
    std::uint32_t inconsistent_edges = 0;    ///< edges whose triangles do not run through it equally often both ways
    std::uint32_t degenerate_triangles = 0;  ///< triangles without area; they are never hit
    double volume = 0;                       ///< signed; negative: the mesh is inside out
    double mean_edge_length = 0;

    /// True if the surface has no border and one orientation, so that it has an inside.
    bool closed() const { return inconsistent_edges == 0; }
};

/// A few points relative to a centre, side by side for vector arithmetic. float32: their error is half an ulp of how far
/// they reach.
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

/// The triangles across a triangle's edges: across[k] lies opposite its vertex k. None at a border, or where more than two
/// triangles meet.
struct Neighbors {
    std::uint32_t across[3] = {no_triangle, no_triangle, no_triangle};
};

/// The triangles that share a vertex with a triangle, itself among them.
struct TriangleRing {
    Vec3f axis;            ///< a cone around it holds all their normals
    float sine = 2;        ///< of the cone's half angle; 2 if they face different ways, or do not lie side by side around it
    float gap = 0;         ///< [length] no other triangle comes closer to any point of the triangle
    float openness = 0;    ///< no triangle of the ring comes closer to a point of the triangle than this part of the point's
                           ///< distance to the triangle's border
    float height[3] = {};  ///< [length] of the triangle over its edges, opposite vertex k
    float tilt = 0;  ///< [1 / length] the sine by which a normal of the ring turns is below this times how far vertices move
};

/// A mesh as stages see it. Offsets and ids are checked when the mesh is made, never again.
struct MeshView {
    View<const Vec3f> positions;  ///< rest shape
    View<const Vec3f> normals;    ///< unit, outward, of the rest shape; zero where undefined
    View<const Triangle> triangles;
    View<const std::uint32_t> corner_offsets;  ///< vertex_count + 1; of vertex v: corners[offsets[v]..offsets[v+1])
    View<const Corner> corners;
    View<const std::uint32_t> fans;             ///< per corner, the vertices around each vertex (fans_of)
    View<const std::uint32_t> patch_vertices;   ///< all vertices, patch after patch, constants::patch_size each
    View<const PatchBlock> blocks;              ///< of the rest shape
    View<const Offsets> patches;                ///< per patch, its vertices relative to its centre; of the rest shape
    View<const Edge> edges;                     ///< patch after patch, each with its first vertex
    View<const std::uint32_t> edge_offsets;     ///< per patch and one more: where its edges begin
    View<const float> edge_reach;               ///< per patch, its longest edge; of the rest shape
    View<const TriangleFeatures> features;      ///< per triangle
    View<const std::uint32_t> group_triangles;  ///< all triangles, group after group, constants::group_size each
    View<const bvh::Leaf> leaves;               ///< all triangles, by ones and twos
    View<const std::uint32_t> parts;            ///< one vertex of every connected part
    View<const Neighbors> neighbors;            ///< per triangle
    View<const TriangleRing> rings;             ///< per triangle; of the rest shape
    View<const float> star_clearance;           ///< per vertex; empty for a mesh that is not closed
    ClearanceGridView clearance;                ///< of the rest shape; empty for a mesh that is not closed
    Box box;                                    ///< of the rest shape
    Vec3d centroid;                             ///< mean of the rest positions
    double mean_edge_length = 0;
    bool closed = false;
    bool simple = false;  ///< one closed surface that does not meet itself and has its inside inside
};

/// Topology and rest shape, checked once and then constant; any number of bodies share it.
class Mesh {
public:
    /// Throws InputError, naming `name` and the offending element, for an empty mesh, an index out of range or a position
    /// that is not finite or beyond constants::largest_coordinate. Anything else is accepted and described by traits().
    Mesh(std::string name, MeshData data);

    const std::string& name() const { return name_; }
    std::span<const Vec3f> positions() const { return data_.positions; }
    std::span<const Vec3f> normals() const { return normals_; }
    std::span<const Triangle> triangles() const { return data_.triangles; }
    const MeshData& data() const { return data_; }
    const MeshTraits& traits() const { return traits_; }
    MeshView view() const;

private:
    std::string name_;
    MeshData data_;
    MeshTraits traits_;
    Box box_;
    Vec3d centroid_;
    std::vector<Vec3f> normals_;
    std::vector<std::uint32_t> corner_offsets_;
    std::vector<Corner> corners_;
    std::vector<std::uint32_t> fans_;
    std::vector<std::uint32_t> patch_vertices_;
    std::vector<PatchBlock> blocks_;
    std::vector<Offsets> patches_;
    std::vector<Edge> edges_;
    std::vector<std::uint32_t> edge_offsets_;
    std::vector<float> edge_reach_;
    std::vector<TriangleFeatures> features_;
    std::vector<std::uint32_t> group_triangles_;
    std::vector<bvh::Leaf> leaves_;
    std::vector<std::uint32_t> parts_;
    std::vector<Neighbors> neighbors_;
    std::vector<TriangleRing> rings_;
    bool simple_ = false;
    std::vector<float> star_clearance_;
    ClearanceGrid clearance_;
};

/// Of a mesh with valid indices and finite positions. `origin` is a point near it, which keeps the volume accurate.
MeshTraits traits_of(const MeshData& data, Vec3d origin);

/// The corners of every vertex, in triangle order, and where each vertex's begin: vertex_count + 1 offsets.
std::pair<std::vector<std::uint32_t>, std::vector<Corner>> corners_of(std::span<const Triangle> triangles,
                                                                      std::size_t vertex_count);

/// Per corner, the vertices around each vertex, one after the other as its triangles hang together, if those go around it
/// once and none is left over; else no_vertex. A triangle at the vertex has two of them that follow each other.
std::vector<std::uint32_t> fans_of(std::span<const std::uint32_t> corner_offsets, std::span<const Corner> corners);

/// True if no coordinate is beyond constants::largest_coordinate, nor NaN.
template <class T>
bool is_within_reach(Vec3<T> p) {
    const T most = static_cast<T>(constants::largest_coordinate);
    return std::fabs(p.x) <= most && std::fabs(p.y) <= most && std::fabs(p.z) <= most;
}

/// Throws InputError unless every position is within reach.
void check_positions(const std::string& name, std::span<const Vec3f> positions);

}  // namespace pierce
