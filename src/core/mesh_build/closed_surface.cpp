#include "core/mesh_build/closed_surface.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/mesh/coincident_vertices.hpp"
#include "core/mesh_build/caps.hpp"
#include "core/mesh_build/connected_parts.hpp"
#include "core/mesh_build/covered_triangles.hpp"
#include "core/mesh_build/covered_walls.hpp"
#include "core/mesh_build/facing_of_parts.hpp"
#include "core/mesh_build/oriented_triangles.hpp"
#include "core/mesh_build/seen_sides.hpp"
#include "core/mesh_build/separating_patches.hpp"
#include "core/mesh_build/triangle_groups.hpp"
#include "pierce/constants.hpp"
#include "pierce/ids.hpp"

namespace pierce {
namespace {

/// Leaves out patches that separate nothing.
OrientedTriangles without_walls(std::span<const Vec3f> positions, const OrientedTriangles& surface,
                                Workers& workers) {
    const std::vector<bool> separates = separating_patches(positions, surface, workers);
    OrientedTriangles rest;
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
        if (!separates[surface.patch[t]]) continue;
        rest.triangles.push_back(surface.triangles[t]);
        rest.given.push_back(surface.given[t]);
        rest.turned.push_back(surface.turned[t]);
    }
    return rest;
}

/// Turns sides and parts that face inward.
void turn_outward(std::span<const Vec3f> positions, OrientedTriangles& surface, Workers& workers) {
    const ConnectedParts parts = connected_parts(surface.triangles, positions.size());
    const std::vector<Facing> as_given = facing_of(positions, surface.triangles, parts, workers);
    const std::vector<bool> was_turned = turn_seen_sides_outward(positions, surface, workers);
    std::vector<bool> stays(parts.count, true);  // since it was given
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
        if (was_turned[surface.patch[t]]) stays[parts.part[t]] = false;
    const std::vector<Facing> now = std::ranges::count(was_turned, true) == 0
                                        ? as_given
                                        : facing_of(positions, surface.triangles, parts, workers);
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
        const std::uint32_t part = parts.part[t];
        if (now[part] != Facing::outward || (stays[part] && as_given[part] == Facing::in_inward))
            surface.turn(t);
    }
}

/// What the caps of a surface add to it.
struct CapSums {
    std::size_t triangles = 0;
    std::size_t of_holes = 0;  ///< triangles of caps that close no gap
    double area = 0;
    double largest = 0;  ///< area of a cap with many edges
};

CapSums sums_of(const std::vector<Cap>& caps) {
    CapSums sums;
    for (const Cap& cap : caps) {
        sums.triangles += cap.triangles.size();
        if (!cap.is_gap) sums.of_holes += cap.triangles.size();
        sums.area += cap.area;
        if (cap.border_edges > constants::small_cap_edges)
            sums.largest = std::max(sums.largest, cap.area);
    }
    return sums;
}

/// True if the holes are a defect of the mesh, and not openings that it is meant to have.
bool is_nearly_closed(const CapSums& caps, double area, std::size_t triangles) {
    return caps.area <= constants::caps_of_area * area &&
           static_cast<double>(caps.of_holes) <=
               constants::caps_of_triangles * static_cast<double>(triangles) &&
           caps.largest <= constants::small_cap * area;
}

/// A surface on the way to be closed.
struct Draft {
    OrientedTriangles surface;
    std::uint32_t joined_vertices = 0;
    double area = 0;
    std::vector<Cap> caps;
};

void measure(const MeshData& mesh, Draft& draft) {
    double edges = 0;
    draft.area = 0;
    for (const Triangle& t : draft.surface.triangles) {
        draft.area += area_of(mesh.positions, t);
        for (int k = 0; k < 3; ++k)
            edges += length(to_double(mesh.positions[t.vertex[(k + 1) % 3]]) -
                            to_double(mesh.positions[t.vertex[k]]));
    }
    const auto sides = 3.0 * static_cast<double>(draft.surface.triangles.size());
    draft.caps = caps_of(mesh.positions, draft.surface.triangles, sides > 0 ? edges / sides : 0);
}

Draft draft_of(const MeshData& mesh, Workers& workers) {
    Draft draft;
    const std::vector<std::uint32_t> first = first_at_position(mesh.positions);
    std::vector<Triangle> joined = mesh.triangles;
    for (std::uint32_t v = 0; v < first.size(); ++v) draft.joined_vertices += first[v] != v;
    for (Triangle& t : joined)
        for (std::uint32_t& v : t.vertex) v = first[v];
    draft.surface = oriented_triangles(mesh.positions, joined);
    turn_outward(mesh.positions, draft.surface, workers);
    measure(mesh, draft);
    return draft;
}

/// What was done so far, and what it takes to close the rest.
MeshInside inside_of(const Draft& draft, const MeshData& mesh) {
    const auto count = [](std::size_t number) { return static_cast<std::uint32_t>(number); };
    const CapSums caps = sums_of(draft.caps);
    return {.rule = Inside::none,
            .joined_vertices = draft.joined_vertices,
            .turned_triangles = count(
                static_cast<std::size_t>(std::ranges::count(draft.surface.turned, true))),
            .left_out_triangles = count(mesh.triangles.size() - draft.surface.triangles.size()),
            .holes = count(draft.caps.size()),
            .cap_triangles = count(caps.triangles),
            .cap_share = draft.area > 0 ? caps.area / draft.area : 0};
}

/// The triangles of a draft and of its caps.
ClosedSurface finished(Draft draft, const MeshData& mesh) {
    ClosedSurface result;
    result.inside = inside_of(draft, mesh);
    result.triangles = std::move(draft.surface.triangles);
    result.given = std::move(draft.surface.given);
    for (const Cap& cap : draft.caps)
        result.triangles.insert(result.triangles.end(), cap.triangles.begin(), cap.triangles.end());
    result.given.resize(result.triangles.size(), no_triangle);
    return result;
}

/// True if the draft and its caps make a solid by a rule. Leaves out what lies within.
bool becomes_solid(const MeshData& mesh, Inside rule, Draft& draft, Workers& workers) {
    const auto has_small_caps = [&] {
        return sums_of(draft.caps).area < constants::largest_caps * draft.area;
    };
    if (!has_small_caps()) return false;
    if (draft.surface.patches > 1) {
        draft.surface = without_walls(mesh.positions, draft.surface, workers);
        measure(mesh, draft);
    }
    return has_small_caps() &&
           (rule == Inside::winding ||
            is_nearly_closed(sums_of(draft.caps), draft.area, draft.surface.triangles.size()));
}

}  // namespace

ClosedSurface closed_surface(const MeshData& mesh, Inside rule, Workers& workers) {
    Draft draft = draft_of(mesh, workers);
    if (!becomes_solid(mesh, rule, draft, workers)) {
        ClosedSurface none;
        none.inside = inside_of(draft, mesh);
        return none;
    }
    ClosedSurface result = finished(std::move(draft), mesh);
    result.inside.rule = Inside::winding;
    return result;
}

ClosedSurface surface_with_inside(const MeshData& mesh, const HalfEdges& sides,
                                  const MeshTraits& traits, Inside rule, Workers& workers) {
    ClosedSurface surface;
    if (rule == Inside::winding || (rule == Inside::automatic && !traits.closed()))
        surface = closed_surface(mesh, rule, workers);
    else if (rule != Inside::none && traits.closed())
        surface.inside.rule = Inside::closed;
    if (!surface.inside.exists() || rule == Inside::closed) return surface;
    const bool is_given = surface.inside.rule != Inside::winding;
    const std::vector<Triangle>& triangles = is_given ? mesh.triangles : surface.triangles;
    const std::vector<Twins> twins = twins_of(
        triangles, is_given ? sides : HalfEdges(triangles, mesh.positions.size()));
    surface.covered = covered_triangles(mesh.positions, triangles, twins, workers);
    cover_walls(mesh.positions, triangles, twins, surface.covered);
    surface.inside.covered_triangles = count_covered(surface.covered);
    return surface;
}

ClosedSurface mended_surface(const MeshData& mesh, Workers& workers) {
    Draft draft = draft_of(mesh, workers);
    std::erase_if(draft.caps, [&](const Cap& cap) {
        return !cap.is_gap && cap.area > constants::small_cap * draft.area;
    });
    return finished(std::move(draft), mesh);
}

}  // namespace pierce
