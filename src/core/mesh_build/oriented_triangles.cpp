#include "core/mesh_build/oriented_triangles.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "core/mesh/half_edges.hpp"
#include "pierce/ids.hpp"

namespace pierce {
namespace {

/// A triangle by its sorted vertices.
struct Sorted {
    std::array<std::uint32_t, 3> vertices;
    std::uint32_t triangle;
    bool odd;  ///< sorting has reversed its direction

    Sorted(const Triangle& t, std::uint32_t id)
        : vertices{t.vertex[0], t.vertex[1], t.vertex[2]}, triangle(id) {
        std::ranges::sort(vertices);
        const auto smallest = std::ranges::min_element(t.vertex) - t.vertex;
        odd = t.vertex[(smallest + 1) % 3] != vertices[1];
    }
    bool has_three() const { return vertices[0] != vertices[1] && vertices[1] != vertices[2]; }
};

/// Keeps one of the triangles with the same vertices; `says` tells which of those that are kept
/// have a direction.
void leave_out_doubles(std::span<const Triangle> triangles, OrientedTriangles& result,
                       std::vector<bool>& says) {
    std::vector<Sorted> sorted;
    sorted.reserve(triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const Sorted s(triangles[t], t);
        if (s.has_three()) sorted.push_back(s);
    }
    std::ranges::stable_sort(sorted, {}, &Sorted::vertices);
    std::vector<std::pair<std::uint32_t, bool>> kept;
    for (auto first = sorted.begin(); first != sorted.end();) {
        const auto last = std::find_if(
            first, sorted.end(), [&](const Sorted& s) { return s.vertices != first->vertices; });
        const auto odd = std::count_if(first, last, [](const Sorted& s) { return s.odd; });
        const bool most_odd = 2 * odd > last - first, tie = 2 * odd == last - first;
        const auto one = std::find_if(first, last,
                                      [&](const Sorted& s) { return tie || s.odd == most_odd; });
        kept.emplace_back(one->triangle, !tie);
        first = last;
    }
    std::ranges::sort(kept);
    for (const auto& [triangle, has_direction] : kept) {
        result.triangles.push_back(triangles[triangle]);
        result.given.push_back(triangle);
        says.push_back(has_direction);
    }
}

/// Vertices at which an odd number of edges with a single triangle end. Borders of a surface are
/// loops, so an edge between two such vertices is a part of a border that another surface hides: a
/// wall within a mesh, whose rim lacks a triangle.
std::vector<bool> ends_of_borders(const HalfEdges& edges, std::size_t vertex_count) {
    std::vector<bool> is_odd(vertex_count, false);
    edges.for_each_edge([&](std::span<const HalfEdge> sides) {
        if (sides.size() != 1) return;
        for (const std::uint32_t v : {sides[0].low, sides[0].high}) is_odd[v] = !is_odd[v];
    });
    return is_odd;
}

/// The neighbours of triangles across edges with two triangles, but for hidden borders.
struct Across {
    std::uint32_t triangle;  ///< no_triangle if there is none
    bool same_way;           ///< both run through the edge the same way, so one of them is turned
};

std::vector<std::array<Across, 3>> neighbors_of(std::span<const Triangle> triangles,
                                                std::size_t vertex_count) {
    constexpr Across nothing{no_triangle, false};
    std::vector<std::array<Across, 3>> across(triangles.size(), {nothing, nothing, nothing});
    const HalfEdges edges(triangles, vertex_count);
    const std::vector<bool> ends_border = ends_of_borders(edges, vertex_count);
    edges.for_each_edge([&](std::span<const HalfEdge> sides) {
        if (sides.size() != 2) return;
        if (ends_border[sides[0].low] && ends_border[sides[0].high]) return;
        const bool same_way = sides[0].forward == sides[1].forward;
        for (int k = 0; k < 2; ++k)
            across[sides[k].triangle][sides[k].opposite] = {sides[1 - k].triangle, same_way};
    });
    return across;
}

}  // namespace

OrientedTriangles oriented_triangles(std::span<const Vec3f> positions,
                                     std::span<const Triangle> triangles) {
    OrientedTriangles result;
    std::vector<bool> says;
    leave_out_doubles(triangles, result, says);
    const auto across = neighbors_of(result.triangles, positions.size());
    const std::size_t count = result.triangles.size();
    constexpr std::uint32_t none = 0xffffffffu;
    result.patch.assign(count, none);
    result.turned.assign(count, false);
    std::vector<std::uint32_t> members;
    for (std::uint32_t seed = 0; seed < count; ++seed) {
        if (result.patch[seed] != none) continue;
        members.assign(1, seed);
        result.patch[seed] = result.patches;
        double as_given = 0, turned = 0;
        for (std::size_t i = 0; i < members.size(); ++i) {
            const std::uint32_t t = members[i];
            const Triangle& triangle = result.triangles[t];
            const Vec3d corner = to_double(positions[triangle.vertex[0]]);
            const double area = length(cross(to_double(positions[triangle.vertex[1]]) - corner,
                                             to_double(positions[triangle.vertex[2]]) - corner));
            if (says[t]) (result.turned[t] ? turned : as_given) += area;
            for (const Across& a : across[t]) {
                if (a.triangle == no_triangle || result.patch[a.triangle] != none) continue;
                result.patch[a.triangle] = result.patches;
                result.turned[a.triangle] = result.turned[t] != a.same_way;
                members.push_back(a.triangle);
            }
        }
        if (turned > as_given)
            for (std::uint32_t t : members) result.turned[t] = !result.turned[t];
        ++result.patches;
    }
    for (std::uint32_t t = 0; t < count; ++t)
        if (result.turned[t])
            std::swap(result.triangles[t].vertex[1], result.triangles[t].vertex[2]);
    return result;
}

std::vector<bool> OrientedTriangles::open_patches(std::size_t vertex_count) const {
    std::vector<bool> is_open(patches, false);
    HalfEdges(triangles, vertex_count).for_each_edge([&](std::span<const HalfEdge> sides) {
        const bool is_plain = sides.size() == 2 &&
                              patch[sides[0].triangle] == patch[sides[1].triangle] &&
                              is_balanced(sides);
        if (is_plain) return;
        std::map<std::uint32_t, int> more_forward;  // by patch
        for (const HalfEdge& side : sides)
            more_forward[patch[side.triangle]] += side.forward ? 1 : -1;
        for (const auto& [its_patch, more] : more_forward)
            if (more != 0) is_open[its_patch] = true;
    });
    return is_open;
}

}  // namespace pierce
