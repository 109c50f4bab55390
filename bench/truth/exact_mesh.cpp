#include "truth/exact_mesh.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>

#include "pierce/error.hpp"

namespace pierce::truth {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 exact(Vec3d p) { return {p.x, p.y, p.z}; }
Vec3d plain(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

void check(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (!is_finite(positions[v]))
            throw InputError("position " + std::to_string(v) + " is not finite");
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t v : triangles[t].vertex)
            if (v >= positions.size())
                throw InputError("triangle " + std::to_string(t) + " names vertex " +
                                 std::to_string(v) + " of " + std::to_string(positions.size()));
}

std::vector<std::uint32_t> used_vertices(std::span<const Triangle> triangles) {
    std::vector<std::uint32_t> ids;
    for (const Triangle& t : triangles)
        ids.insert(ids.end(), std::begin(t.vertex), std::end(t.vertex));
    std::ranges::sort(ids);
    ids.erase(std::ranges::unique(ids).begin(), ids.end());
    return ids;
}

/// True if triangles run through every edge equally often both ways.
bool is_closed(std::span<const Triangle> triangles) {
    std::vector<std::array<std::uint32_t, 2>> forth, back;
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
            if (v < w) forth.push_back({v, w});
            if (w < v) back.push_back({w, v});
        }
    std::ranges::sort(forth);
    std::ranges::sort(back);
    return forth == back;
}

/// The lowest vertex of each set of triangles that are connected by common vertices.
std::vector<std::uint32_t> connected_parts(std::size_t vertex_count,
                                           std::span<const Triangle> triangles,
                                           std::span<const std::uint32_t> used) {
    std::vector<std::uint32_t> parent(vertex_count);
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const Triangle& t : triangles)
        for (int k = 1; k < 3; ++k) {
            const std::uint32_t v = root(t.vertex[0]), w = root(t.vertex[k]);
            parent[std::max(v, w)] = std::min(v, w);
        }
    std::vector<std::uint32_t> parts;
    std::ranges::copy_if(used, std::back_inserter(parts),
                         [&](std::uint32_t v) { return parent[v] == v; });
    return parts;
}

/// A random point outside of the box, behind the side that is nearest to `p`.
template <class Engine>
Vec3d point_outside(const Box& box, Vec3d p, Engine& engine) {
    const double extent = box.extent();
    std::uniform_real_distribution<double> offset(-0.1 * extent, 0.1 * extent);
    Vec3d end = p + Vec3d{offset(engine), offset(engine), offset(engine)};
    int axis = 0;
    const auto gap = [&](int k) { return std::min(p[k] - box.lower[k], box.upper[k] - p[k]); };
    for (int k = 1; k < 3; ++k)
        if (gap(k) < gap(axis)) axis = k;
    const bool below = p[axis] - box.lower[axis] < box.upper[axis] - p[axis];
    end[axis] = below ? box.lower[axis] - extent : box.upper[axis] + extent;
    return end;
}

/// How a segment that meets a triangle crosses it: 1 against its normal's side first, -1 the other
/// way; nothing if it touches the triangle's plane with an end or passes through its border.
std::optional<int> crossing(const Kernel::Point_3& from, const Kernel::Point_3& to,
                            const Kernel::Triangle_3& t) {
    const CGAL::Orientation side = CGAL::orientation(t[0], t[1], t[2], from);
    if (side == CGAL::COPLANAR || CGAL::orientation(t[0], t[1], t[2], to) == CGAL::COPLANAR)
        return std::nullopt;
    for (int k = 0; k < 3; ++k)
        if (CGAL::orientation(from, to, t[k], t[(k + 1) % 3]) == CGAL::COPLANAR)
            return std::nullopt;
    return side == CGAL::NEGATIVE ? 1 : -1;
}

}  // namespace

struct ExactMesh::Tree {
    Triangles triangles;             ///< those with area
    std::vector<std::uint32_t> ids;  ///< of `triangles` in the mesh
    AabbTree boxes;
};

ExactMesh::ExactMesh(std::span<const Vec3d> positions, std::span<const Triangle> triangles)
    : positions_(positions.begin(), positions.end()),
      vertices_(used_vertices(triangles)),
      tree_(std::make_unique<Tree>()) {
    check(positions, triangles);
    closed_ = is_closed(triangles);
    parts_ = connected_parts(positions.size(), triangles, vertices_);
    for (std::uint32_t v : vertices_) box_.extend(positions_[v]);
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
        const auto& v = triangles[i].vertex;
        const Kernel::Triangle_3 t(exact(positions[v[0]]), exact(positions[v[1]]),
                                   exact(positions[v[2]]));
        if (t.is_degenerate()) continue;
        tree_->triangles.push_back(t);
        tree_->ids.push_back(i);
    }
    tree_->boxes.insert(tree_->triangles.cbegin(), tree_->triangles.cend());
    tree_->boxes.build();
}

ExactMesh::ExactMesh(ExactMesh&&) noexcept = default;
ExactMesh& ExactMesh::operator=(ExactMesh&&) noexcept = default;
ExactMesh::~ExactMesh() = default;

Where ExactMesh::where(Vec3d point) const {
    if (!overlap(box_, {point, point})) return Where::outside;
    const Kernel::Point_3 from = exact(point);
    std::minstd_rand engine;
    std::vector<Triangles::const_iterator> met;
    // Almost every segment crosses the surface only inside of triangles; the first one nearly
    // always does.
    for (;;) {
        const Kernel::Point_3 to = exact(point_outside(box_, point, engine));
        met.clear();
        tree_->boxes.all_intersected_primitives(Kernel::Segment_3(from, to),
                                                std::back_inserter(met));
        if (std::ranges::any_of(met, [&](auto t) { return t->has_on(from); })) return Where::on;
        if (!closed_) return Where::outside;
        std::optional<int> winding = 0;
        for (auto t : met) {
            const std::optional<int> c = crossing(from, to, *t);
            winding = winding && c ? std::optional(*winding + *c) : std::nullopt;
        }
        if (winding) return *winding != 0 ? Where::inside : Where::outside;
    }
}

Nearest ExactMesh::nearest(Vec3d point) const {
    if (tree_->triangles.empty()) return {point, 0, std::numeric_limits<double>::infinity()};
    const auto [closest, primitive] = tree_->boxes.closest_point_and_primitive(exact(point));
    const auto index = static_cast<std::size_t>(primitive - tree_->triangles.cbegin());
    return {plain(closest), tree_->ids[index], length(plain(closest) - point)};
}

bool ExactMesh::surfaces_intersect(const ExactMesh& other, const Frame& placement) const {
    for (const Kernel::Triangle_3& t : other.tree_->triangles) {
        Box box;
        std::array<Kernel::Point_3, 3> corners;
        for (int k = 0; k < 3; ++k) {
            const Vec3d p = placement.to_parent(plain(t[k]));
            box.extend(p);
            corners[static_cast<std::size_t>(k)] = exact(p);
        }
        if (!overlap(box, box_)) continue;
        const Kernel::Triangle_3 placed(corners[0], corners[1], corners[2]);
        if (!placed.is_degenerate() && tree_->boxes.do_intersect(placed)) return true;
    }
    return false;
}

bool ExactMesh::contains_part(const ExactMesh& other, const Frame& placement) const {
    return std::ranges::any_of(other.parts_, [&](std::uint32_t v) {
        return where(placement.to_parent(other.positions_[v])) == Where::inside;
    });
}

bool ExactMesh::overlaps(const ExactMesh& other, const Frame& placement) const {
    if (surfaces_intersect(other, placement)) return true;
    return closed_ && other.closed_ &&
           (contains_part(other, placement) || other.contains_part(*this, placement.inverse()));
}

}  // namespace pierce::truth
