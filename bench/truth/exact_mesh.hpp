#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pierce/box.hpp"
#include "pierce/mesh.hpp"
#include "pierce/pose.hpp"

/// What is true of placed meshes, by exact predicates and with none of the library's detection
/// code.
namespace pierce::truth {

enum class Where : std::uint8_t { inside, on, outside };

/// The point of a surface that is closest to another point.
struct Nearest {
    Vec3d point;
    std::uint32_t triangle = 0;
    double distance = 0;
};

/// A triangle mesh that answers exactly for the coordinates it is asked about. Triangles without
/// area are left out; a mesh is closed as in MeshTraits. Queries may run at the same time.
class ExactMesh {
public:
    /// Throws InputError for an index out of range or a position that is not finite.
    ExactMesh(std::span<const Vec3d> positions, std::span<const Triangle> triangles);
    ExactMesh(ExactMesh&&) noexcept;
    ExactMesh& operator=(ExactMesh&&) noexcept;
    ~ExactMesh();

    std::span<const Vec3d> positions() const { return positions_; }
    /// The vertices that triangles use, in order.
    std::span<const std::uint32_t> vertices() const { return vertices_; }
    const Box& box() const { return box_; }
    bool closed() const { return closed_; }

    /// Inside is where the surface winds around a point at least once, either way; nowhere for an
    /// open mesh.
    Where where(Vec3d point) const;

    /// Constructed in double. A surface without triangles is infinitely far away.
    Nearest nearest(Vec3d point) const;

    // `placement` takes the other mesh's points into this mesh's space, each with a rounding to
    // double.

    /// True if two triangles share a point.
    bool surfaces_intersect(const ExactMesh& other, const Frame& placement = {}) const;

    /// True if a connected part of the other, given that the surfaces do not intersect, is inside
    /// this mesh.
    bool contains_part(const ExactMesh& other, const Frame& placement = {}) const;

    /// True if the surfaces intersect or, both being closed, one mesh contains a part of the other.
    bool overlaps(const ExactMesh& other, const Frame& placement = {}) const;

private:
    struct Tree;

    std::vector<Vec3d> positions_;
    std::vector<std::uint32_t> vertices_;
    std::vector<std::uint32_t> parts_;  ///< a vertex of each connected part
    Box box_;                           ///< of vertices_
    bool closed_ = false;
    std::unique_ptr<Tree> tree_;
};

}  // namespace pierce::truth
