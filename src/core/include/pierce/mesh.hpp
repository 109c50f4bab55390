#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pierce/inside.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// Three vertex ids, counter-clockwise seen from outside.
struct Triangle {
    std::uint32_t vertex[3];

    friend bool operator==(const Triangle&, const Triangle&) = default;
};

/// What a mesh is made from: vertex positions and triangles, in the caller's numbering and unit.
struct MeshData {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
};

/// What the check of a mesh's topology found. Volume and edge length are those of
/// Mesh::triangles(), all else is counted in the mesh as it was given.
struct MeshTraits {
    std::uint32_t boundary_edges = 0;        ///< edges with one triangle
    std::uint32_t non_manifold_edges = 0;    ///< edges with more than two triangles
    std::uint32_t inconsistent_edges = 0;    ///< edges that triangles do not run through equally
                                             ///< often both ways
    std::uint32_t degenerate_triangles = 0;  ///< triangles without area; they are never hit
    double volume = 0;                       ///< signed; negative: the mesh is inside out
    double mean_edge_length = 0;

    /// True if the surface has no border and one orientation.
    bool closed() const { return inconsistent_edges == 0; }
};

struct MeshNeeds;
struct MeshView;

/// How a mesh is made.
struct MeshOptions {
    Inside inside = Inside::automatic;
    /// A folder in which what is measured is kept, by the mesh's content, and found again by the
    /// next program; empty: none. It must be trusted as the program itself (docs/meshes.md). A mesh
    /// made from another one does not use it.
    std::filesystem::path cache = {};
    std::uint32_t threads = 0;  ///< 0: one per processor; the mesh is the same for every number
    /// What is being made, and the share of it that is made, from 0 to 1. It is called now and
    /// then once making has taken 0.2 s, by one thread at a time, and at last with 1. It must not
    /// throw, nor use the mesh or a world that has it: that throws InputError where it would wait
    /// for itself.
    std::function<void(std::string_view what, double share)> progress = {};
};

/// Topology and rest shape, checked once and then constant; any number of bodies share it, in
/// several worlds and threads at once. What only some steps read is made when the first of those
/// steps is planned.
class Mesh {
public:
    /// Throws InputError, naming `name` and the offending element, for an empty mesh, an index out
    /// of range, a position that is not finite or beyond constants::largest_coordinate, a mesh that
    /// is smaller than the reciprocal of that and no point, or a cache that is no folder and cannot
    /// be made one. Anything else is accepted and described by traits().
    Mesh(std::string name, MeshData data, MeshOptions options = {});
    /// A mesh that is mostly `before`, cut, torn or grown. Vertices keep their numbers; new ones
    /// follow. Which triangles stay is found out, and what is known of them is taken over; grids,
    /// which pay off over many steps only, are not made anew. So the mesh is ready sooner. Steps
    /// find the same contacts as with a mesh made from nothing, unless a body is folded through
    /// itself or its mesh is inside out, and take a little longer.
    Mesh(std::string name, MeshData data, const Mesh& before, MeshOptions options = {});
    Mesh(Mesh&&) noexcept;
    Mesh& operator=(Mesh&&) noexcept;
    ~Mesh();

    const std::string& name() const;
    /// What decides whether a point is inside.
    const MeshInside& inside() const;
    std::span<const Vec3f> positions() const;
    /// Per vertex, unit and outward; zero where undefined.
    std::span<const Vec3f> normals() const;
    /// The triangles that contacts name. They are those that were given, unless inside().rule is
    /// Inside::winding: then some are left out or turned, and triangles that close holes are added.
    std::span<const Triangle> triangles() const;
    /// The place of one of triangles() among those that were given; no_triangle if it closes a
    /// hole. Throws InputError if there is no such triangle.
    std::uint32_t given_triangle(std::uint32_t triangle) const;
    /// A copy of the data that the mesh was made from.
    MeshData data() const;
    const MeshTraits& traits() const;
    /// What steps read of the mesh (core/mesh/mesh_view.hpp, which is not installed): everything,
    /// or what is needed. Makes what is missing.
    MeshView view() const;
    MeshView view(const MeshNeeds& needs) const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pierce
