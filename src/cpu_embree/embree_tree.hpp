#pragma once

#include "core/mesh/surface.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/first_crossing.hpp"
#include "core/trace/refit_policy.hpp"
#include "cpu_embree/embree_api.hpp"

namespace pierce::embree {

/// Whether a tree's triangles will ever move.
enum class TreeKind { still, moving };

/// An Embree scene over one surface. Triangles are user primitives, so that Embree asks us for
/// boxes and tests.
class Tree {
public:
    /// Builds the tree. `box`: around all positions.
    Tree(RTCDevice device, TreeKind kind, const Surface& surface, const Box& box);
    ~Tree();
    Tree(const Tree&) = delete;
    Tree& operator=(const Tree&) = delete;

    /// Takes over positions that moved, keeping the tree's shape. The triangles must be the same.
    void refit(const Surface& surface, const Box& box);
    /// Takes over all but positions: what counts as covered, as a body may become a sheet.
    void see(const Surface& surface) { surface_ = surface; }

    /// The triangle the ray crosses first; adds the number of triangles tested to `tests`.
    Hit trace(const Ray& ray, std::uint32_t& tests) const;

    /// Shows a search all triangles that may be closest to its point. `known`: one of them that is
    /// probably near, or no_triangle.
    void show_near(ClosestSearch& search, std::uint32_t known) const;

    std::uint32_t triangle_count() const { return surface_.triangles.size; }

    RefitPolicy policy;

private:
    struct Query;
    struct PointQuery;

    static void bounds(const RTCBoundsFunctionArguments* arguments);
    static void intersect(const RTCIntersectFunctionNArguments* arguments);
    static bool test_near(RTCPointQueryFunctionArguments* arguments);
    void set_surface(const Surface& surface, const Box& box);

    Surface surface_;
    Box reach_;         ///< no point outside of this box is near the surface
    float margin_ = 0;  ///< [length] how far boxes reach beyond their triangles
    RTCScene scene_ = nullptr;
    RTCGeometry geometry_ = nullptr;
};

}  // namespace pierce::embree
