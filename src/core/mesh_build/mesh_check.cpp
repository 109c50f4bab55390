#include "pierce/mesh_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "core/base/usable.hpp"
#include "core/base/workers.hpp"
#include "core/device/view.hpp"
#include "core/geometry/closest_point.hpp"
#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/coincident_vertices.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/mesh_build/closed_surface.hpp"
#include "core/mesh_build/connected_parts.hpp"
#include "core/mesh_build/facing_of_parts.hpp"
#include "core/mesh_build/mesh_topology.hpp"
#include "core/mesh_build/self_intersections.hpp"

namespace pierce {
namespace {

/// Counts findings by kind and keeps the places of the first ones.
class Findings {
public:
    Findings() {
        for (std::uint32_t i = 0; i < mesh_defect_count; ++i)
            all_[i].kind = static_cast<MeshDefect>(i);
    }

    void add(MeshDefect kind, std::initializer_list<std::uint32_t> place) {
        MeshFinding& finding = all_[static_cast<std::size_t>(kind)];
        if (finding.count++ < constants::finding_places)
            finding.places.insert(finding.places.end(), place.begin(), place.end());
    }

    std::vector<MeshFinding> present() const {
        std::vector<MeshFinding> findings;
        std::ranges::copy_if(all_, std::back_inserter(findings),
                             [](const MeshFinding& f) { return f.count > 0; });
        return findings;
    }

private:
    std::array<MeshFinding, mesh_defect_count> all_;
};

/// The triangles that can be checked, and their ids in the given mesh.
struct Part {
    MeshData mesh;
    std::vector<std::uint32_t> ids;
};

/// The box around what bodies have of the mesh; around all vertices if no triangle can be checked.
Box box_of(const MeshData& mesh, const Part& part) {
    Box box;
    for (const Triangle& t : part.mesh.triangles)
        for (std::uint32_t v : t.vertex) box.extend(to_double(mesh.positions[v]));
    if (part.ids.empty())
        for (Vec3f p : mesh.positions)
            if (is_finite(p)) box.extend(to_double(p));
    return box;
}

/// Reports vertices that are not finite, out of range, not there or not used, and keeps the
/// triangles that can be checked.
Part usable_part(const MeshData& mesh, Findings& findings) {
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
        if (!is_within_reach(mesh.positions[v]))
            findings.add(
                is_finite(mesh.positions[v]) ? MeshDefect::out_of_range : MeshDefect::not_finite,
                {v});
    Part part{{mesh.positions, {}}, {}};
    std::vector<bool> used(mesh.positions.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        bool known = true, finite = true;
        for (std::uint32_t v : mesh.triangles[t].vertex) {
            if (v < used.size()) {
                used[v] = true;
                finite &= is_finite(mesh.positions[v]);
            } else {
                known = false;
            }
        }
        if (!known) findings.add(MeshDefect::bad_index, {t});
        if (!known || !finite) continue;
        part.mesh.triangles.push_back(mesh.triangles[t]);
        part.ids.push_back(t);
    }
    if (mesh.triangles.empty()) findings.add(MeshDefect::no_triangles, {});
    for (std::uint32_t v = 0; v < used.size(); ++v)
        if (!used[v]) findings.add(MeshDefect::unused_vertex, {v});
    return part;
}

void check_duplicate_vertices(const MeshData& mesh, Findings& findings) {
    const std::vector<std::uint32_t> first = first_at_position(mesh.positions);
    for (std::uint32_t v = 0; v < first.size(); ++v)
        if (first[v] != v) findings.add(MeshDefect::duplicate_vertex, {v});
}

/// The same triangle with its smallest vertex first, facing the same way.
Triangle turned(const Triangle& t) {
    const auto smallest = std::ranges::min_element(t.vertex) - t.vertex;
    return {{t.vertex[smallest], t.vertex[(smallest + 1) % 3], t.vertex[(smallest + 2) % 3]}};
}

void check_triangles(const Part& part, Findings& findings) {
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> first;
    for (std::uint32_t t = 0; t < part.ids.size(); ++t) {
        const Triangle& triangle = part.mesh.triangles[t];
        const Corners c = corners_of(view_of(part.mesh.positions), triangle);
        if (is_degenerate(c[0], c[1], c[2]))
            findings.add(MeshDefect::degenerate_triangle, {part.ids[t]});
        std::array<std::uint32_t, 3> key = {triangle.vertex[0], triangle.vertex[1],
                                            triangle.vertex[2]};
        std::ranges::sort(key);
        const auto [earlier, is_new] = first.try_emplace(key, t);
        if (is_new) continue;
        const bool same_way = turned(triangle) == turned(part.mesh.triangles[earlier->second]);
        findings.add(same_way ? MeshDefect::duplicate_triangle : MeshDefect::opposite_triangle,
                     {part.ids[t]});
    }
}

/// What edges say about the surface around vertices and triangles.
struct Connections {
    std::vector<bool> on_open_edge;       ///< per triangle: one of its edges is not balanced
    std::vector<bool> on_irregular_edge;  ///< per vertex: one of its edges does not have two
                                          ///< triangles that run opposite ways
    DisjointSets fans;  ///< corners of triangles, 3 t + k; corners that lie side by side around a
                        ///< vertex form a set
};

Connections check_edges(const MeshData& mesh, const HalfEdges& sides_of_all, Findings& findings) {
    Connections connections{std::vector<bool>(mesh.triangles.size()),
                            std::vector<bool>(mesh.positions.size()),
                            DisjointSets(3 * mesh.triangles.size())};
    sides_of_all.for_each_edge([&](std::span<const HalfEdge> sides) {
        const std::uint32_t low = sides[0].low, high = sides[0].high;
        const bool balanced = is_balanced(sides);
        if (sides.size() == 1) findings.add(MeshDefect::border_edge, {low, high});
        if (sides.size() == 2 && !balanced) findings.add(MeshDefect::flipped_edge, {low, high});
        if (sides.size() > 2) findings.add(MeshDefect::non_manifold_edge, {low, high});
        const auto corner = [](const HalfEdge& s, bool of_low) {
            return 3 * s.triangle + (s.opposite + (of_low == s.forward ? 1u : 2u)) % 3;
        };
        for (const HalfEdge& s : sides) {
            if (!balanced) connections.on_open_edge[s.triangle] = true;
            for (const bool of_low : {true, false})
                connections.fans.join(corner(s, of_low), corner(sides[0], of_low));
        }
        if (!balanced || sides.size() != 2)
            connections.on_irregular_edge[low] = connections.on_irregular_edge[high] = true;
    });
    return connections;
}

/// True if `direction`, the opposite of a vertex's normal, leads out of the surface. The vertex's
/// triangles must be a closed fan. `direction` leads out if it is in front of the nearest feature
/// of the fan, continued to infinity (Baerentzen and Aanaes 2005).
bool leads_outside(const MeshView& mesh, std::uint32_t v, Vec3d direction) {
    if (leads_inside(mesh, mesh.positions, v, direction)) return false;
    struct Wedge {
        Vec3d away;  ///< from the wedge's nearest point to the direction
        Vec3d normal;
    };
    const Vec3d apex = to_double(mesh.positions[v]);
    std::vector<Wedge> fan;
    for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i) {
        const Vec3d a = constants::wedge_length *
                        normalized(to_double(mesh.positions[mesh.corners[i].next]) - apex);
        const Vec3d b = constants::wedge_length *
                        normalized(to_double(mesh.positions[mesh.corners[i].previous]) - apex);
        fan.push_back(
            {direction - closest_on_triangle(direction, {}, a, b), normalized(cross(a, b))});
    }
    const auto distance = [](const Wedge& w) { return length(w.away); };
    const Wedge nearest = *std::ranges::min_element(fan, {}, distance);
    // Where the vertex itself is nearest, its normal decides, and the normal points the other way.
    if (distance(nearest) > 1 - constants::touch_tolerance) return false;
    Vec3d normal;
    for (const Wedge& w : fan)
        if (distance(w) <= distance(nearest) + constants::touch_tolerance) normal += w.normal;
    return dot(nearest.away, normal) > constants::touch_tolerance;
}

void check_vertices(const MeshData& mesh, bool closed, Connections& connections,
                    Findings& findings) {
    const auto [offsets, corners] = corners_by_vertex(mesh.triangles, mesh.positions.size());
    MeshView view;
    view.positions = view_of(mesh.positions);
    view.corner_offsets = view_of(offsets);
    view.corners = view_of(corners);
    constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::uint32_t> fan(mesh.positions.size(), none);
    std::vector<bool> bowtie(mesh.positions.size());
    for (std::uint32_t i = 0; i < 3 * mesh.triangles.size(); ++i) {
        const std::uint32_t v = mesh.triangles[i / 3].vertex[i % 3],
                            root = connections.fans.root(i);
        if (fan[v] != none && fan[v] != root) bowtie[v] = true;
        fan[v] = root;
    }
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        if (fan[v] == none) continue;
        if (bowtie[v]) findings.add(MeshDefect::bowtie_vertex, {v});
        const Vec3d normal = vertex_normal(view, view.positions, v);
        const bool regular = closed && !bowtie[v] && !connections.on_irregular_edge[v];
        if (length_squared(normal) == 0 || (regular && leads_outside(view, v, -normal)))
            findings.add(MeshDefect::no_inward_direction, {v});
    }
}

/// Notes closed components that face inward. Returns how many components there are.
std::uint32_t check_components(const Part& part, const Connections& connections, Workers& workers,
                               Findings& findings) {
    const MeshData& mesh = part.mesh;
    const ConnectedParts components = connected_parts(mesh.triangles, mesh.positions.size());
    std::vector<Facing> facing = facing_of(mesh.positions, mesh.triangles, components, workers);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (connections.on_open_edge[t]) facing[components.part[t]] = Facing::outward;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        Facing& its = facing[components.part[t]];
        if (std::exchange(its, Facing::outward) == Facing::outward) continue;
        findings.add(MeshDefect::inside_out, {part.ids[t]});
    }
    return components.count;
}

}  // namespace

const MeshFinding* MeshReport::find(MeshDefect kind) const {
    const auto found = std::ranges::find(findings, kind, &MeshFinding::kind);
    return found == findings.end() ? nullptr : &*found;
}

bool MeshReport::sound() const {
    return std::ranges::none_of(findings,
                                [](const MeshFinding& f) { return changes_detection(f.kind); });
}

MeshReport check_mesh(const MeshData& mesh, MeshCheckOptions options) {
    MeshReport report;
    report.vertices = static_cast<std::uint32_t>(mesh.positions.size());
    report.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
    Findings findings;
    const Part part = usable_part(mesh, findings);
    report.box = box_of(mesh, part);
    if (is_too_small(report.box))
        for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
            findings.add(MeshDefect::out_of_range, {v});
    check_duplicate_vertices(mesh, findings);
    check_triangles(part, findings);
    const HalfEdges sides(part.mesh.triangles, part.mesh.positions.size());
    Connections connections = check_edges(part.mesh, sides, findings);
    Workers workers(0);
    if (!part.ids.empty()) {
        report.traits = traits_of(part.mesh, sides, report.box.center());
        report.closed = report.traits.closed();
        report.inside = surface_with_inside(part.mesh, sides, report.traits, options.inside,
                                            workers)
                            .inside;
    }
    check_vertices(part.mesh, report.closed, connections, findings);
    report.components = check_components(part, connections, workers, findings);
    if (options.self_intersections)
        for (const auto& [t, other] : self_intersections(part.mesh))
            findings.add(MeshDefect::self_intersection, {part.ids[t], part.ids[other]});
    report.findings = findings.present();
    return report;
}

}  // namespace pierce
