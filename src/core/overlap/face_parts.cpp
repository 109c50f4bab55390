#include "core/overlap/face_parts.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <utility>

#include "core/mesh_build/box_tree.hpp"

namespace pierce {
namespace {

/// A place where an edge goes through a triangle of the other surface.
struct Cut {
    std::uint32_t triangle = 0;
    int inward = 0;    ///< as the edge runs from its first vertex to its second
    double along = 0;  ///< from its first vertex
    Vec3d place;
};

struct CutEdge {
    std::uint32_t from = 0, to = 0;
    std::vector<Cut> cuts;  ///< sorted along the edge

    /// By how much the winding number of the other surface is larger at its second vertex.
    int rise() const {
        int sum = 0;
        for (const Cut& cut : cuts) sum += cut.inward;
        return sum;
    }
};

/// An edge of a triangle.
struct Use {
    std::uint32_t edge = 0;
    bool reversed = false;
};

/// One of the surfaces, and where the other one cuts it.
struct Cuttable {
    GridSurface surface;
    Shift shift;
    std::vector<CutEdge> edges;
    std::vector<std::array<Use, 3>> uses;                  ///< by triangle
    std::vector<std::vector<std::uint32_t>> edges_at;      ///< by vertex
    std::vector<std::vector<std::uint32_t>> triangles_at;  ///< by edge
    std::vector<int> winding;  ///< by vertex: of the other surface around it
    Box box;                   ///< in steps of the grid

    Cuttable(const GridSurface& its_surface, Shift its_shift);
    Box box_of_triangle(std::uint32_t t) const;
};

Vec3d in_steps(GridPoint p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

Cuttable::Cuttable(const GridSurface& its_surface, Shift its_shift)
    : surface(its_surface),
      shift(its_shift),
      uses(surface.triangles.size()),
      edges_at(surface.points.size()),
      winding(surface.points.size(), 0) {
    for (const GridPoint& p : surface.points) box.extend(in_steps(p));
    struct Place {
        std::uint32_t low, high, triangle;
        int k;
    };
    std::vector<Place> places;
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t u = surface.triangles[t].vertex[k],
                                v = surface.triangles[t].vertex[(k + 1) % 3];
            places.push_back({std::min(u, v), std::max(u, v), t, k});
        }
    std::ranges::sort(places, {},
                      [](const Place& p) { return std::tuple(p.low, p.high, p.triangle, p.k); });
    for (const Place& p : places) {
        if (edges.empty() || edges.back().from != p.low || edges.back().to != p.high) {
            const auto made = static_cast<std::uint32_t>(edges.size());
            edges.push_back({p.low, p.high, {}});
            triangles_at.emplace_back();
            edges_at[p.low].push_back(made);
            edges_at[p.high].push_back(made);
        }
        const auto edge = static_cast<std::uint32_t>(edges.size() - 1);
        triangles_at[edge].push_back(p.triangle);
        uses[p.triangle][static_cast<std::size_t>(p.k)] = {
            edge, surface.triangles[p.triangle].vertex[p.k] != p.low};
    }
}

Box Cuttable::box_of_triangle(std::uint32_t t) const {
    Box around;
    for (std::uint32_t v : surface.triangles[t].vertex) around.extend(in_steps(surface.points[v]));
    return around;
}

Piercing pierce_by(const Cuttable& by, const Cuttable& cut, GridPoint p, GridPoint q,
                   std::uint32_t triangle) {
    const std::uint32_t* v = by.surface.triangles[triangle].vertex;
    const std::span<const GridPoint> at = by.surface.points;
    return pierce_triangle(p, q, cut.shift, at[v[0]], at[v[1]], at[v[2]]);
}

/// Finds where the edges of `cut` go through triangles of `by`.
void cut_edges(const Grid& grid, Cuttable& cut, const Cuttable& by) {
    std::vector<std::uint32_t> near;
    std::vector<Box> boxes;
    for (std::uint32_t t = 0; t < by.surface.triangles.size(); ++t) {
        const Box box = by.box_of_triangle(t);
        if (!overlap(box, cut.box)) continue;
        near.push_back(t);
        boxes.push_back(box);
    }
    if (near.empty()) return;
    const BoxTree tree(boxes);
    for (CutEdge& edge : cut.edges) {
        const GridPoint p = cut.surface.points[edge.from], q = cut.surface.points[edge.to];
        Box box;
        box.extend(in_steps(p));
        box.extend(in_steps(q));
        if (!overlap(box, by.box)) continue;
        tree.for_each_in(box, [&](std::uint32_t n) {
            const Piercing found = pierce_by(by, cut, p, q, near[n]);
            if (found.inward == 0) return;
            const Vec3d at_p = grid.place(p), at_q = grid.place(q);
            edge.cuts.push_back(
                {near[n], found.inward, found.along, at_p + found.along * (at_q - at_p)});
        });
        std::ranges::sort(edge.cuts, {},
                          [](const Cut& c) { return std::pair(c.along, c.triangle); });
    }
}

/// The winding number of `by` around a point of `cut`: what a ray along x goes through.
int winding_around(const Cuttable& by, const Cuttable& cut, GridPoint p) {
    GridPoint beyond = p;
    beyond.x = static_cast<std::int64_t>(by.box.upper.x) + 1;
    if (!(beyond.x > p.x)) return 0;
    int winding = 0;
    for (std::uint32_t t = 0; t < by.surface.triangles.size(); ++t)
        winding -= pierce_by(by, cut, p, beyond, t).inward;
    return winding;
}

/// Finds the winding number of `by` around every vertex of `cut`: 0 outside of its box, and along
/// edges it changes at cuts only.
void find_windings(Cuttable& cut, const Cuttable& by) {
    const std::span<const GridPoint> points = cut.surface.points;
    std::vector<bool> known(points.size(), false);
    std::vector<std::uint32_t> open;
    const auto spread = [&] {
        while (!open.empty()) {
            const std::uint32_t v = open.back();
            open.pop_back();
            for (const std::uint32_t e : cut.edges_at[v]) {
                const CutEdge& edge = cut.edges[e];
                const std::uint32_t other = edge.from == v ? edge.to : edge.from;
                if (known[other]) continue;
                cut.winding[other] = cut.winding[v] + (edge.from == v ? edge.rise() : -edge.rise());
                known[other] = true;
                open.push_back(other);
            }
        }
    };
    for (std::uint32_t v = 0; v < points.size(); ++v) {
        if (by.box.contains(in_steps(points[v]))) continue;
        known[v] = true;
        open.push_back(v);
    }
    spread();
    for (std::uint32_t v = 0; v < points.size(); ++v) {
        if (known[v] || cut.edges_at[v].empty()) continue;
        cut.winding[v] = winding_around(by, cut, points[v]);
        known[v] = true;
        open.push_back(v);
        spread();
    }
}

/// Where a triangle of the first surface and one of the second meet: a segment that has the inside
/// of the second surface at its left, seen from above the first triangle.
struct Segment {
    Vec3d from, to;
};
using Segments = std::map<std::pair<std::uint32_t, std::uint32_t>, Segment>;

/// An outline of a part inside runs along edges from where they come in to where they go out, and
/// from there along segments to where edges come in; edges of the other triangle see it the other
/// way around.
Segments find_segments(const Cuttable& first, const Cuttable& second) {
    Segments segments;
    const auto add = [&](const Cuttable& cut, bool is_first) {
        for (std::uint32_t e = 0; e < cut.edges.size(); ++e)
            for (const Cut& c : cut.edges[e].cuts)
                for (const std::uint32_t t : cut.triangles_at[e]) {
                    const auto& of_triangle = cut.uses[t];
                    for (const Use& use : of_triangle) {
                        if (use.edge != e) continue;
                        const bool comes_in = (c.inward > 0) != use.reversed;
                        Segment& segment = is_first ? segments[{t, c.triangle}]
                                                    : segments[{c.triangle, t}];
                        (comes_in == is_first ? segment.to : segment.from) = c.place;
                    }
                }
    };
    add(first, true);
    add(second, false);
    return segments;
}

/// Sums integrals over the inside of an outline, as triangles from one of its places.
class Outline {
public:
    /// `origin`: what places are told from.
    Outline(Vec3d origin, Vec3d normal) : origin_(origin), part_{} { part_.normal = normal; }

    void add(double weight, Vec3d from_there, Vec3d to_there) {
        const Vec3d from = from_there - origin_, to = to_there - origin_;
        if (part_.outline.empty()) apex_ = from;
        part_.outline.push_back({weight, from, to});
        const double area = 0.5 * weight * dot(part_.normal, cross(from - apex_, to - apex_));
        part_.area += area;
        part_.moment += area / 3 * (apex_ + from + to);
        for (int k = 0; k < 3; ++k) {
            const double a = apex_[k], b = from[k], c = to[k];
            part_.squares[k] += area / 6 * (a * a + b * b + c * c + a * b + b * c + c * a);
        }
    }
    const FacePart& part() const { return part_; }

private:
    Vec3d origin_, apex_;
    FacePart part_;
};

/// Adds the pieces of an edge, as the triangle runs along it.
void add_edge(const Grid& grid, const Cuttable& of, const Use& use, Outline& outline) {
    const CutEdge& edge = of.edges[use.edge];
    int winding = of.winding[edge.from];
    Vec3d last = grid.place(of.surface.points[edge.from]);
    const auto piece = [&](Vec3d next) {
        if (winding != 0)
            outline.add(winding, use.reversed ? next : last, use.reversed ? last : next);
        last = next;
    };
    for (const Cut& cut : edge.cuts) {
        piece(cut.place);
        winding += cut.inward;
    }
    piece(grid.place(of.surface.points[edge.to]));
}

std::vector<FacePart> parts_of(const Grid& grid, Vec3d origin, const Cuttable& of,
                               const std::vector<std::vector<Segment>>& segments) {
    std::vector<FacePart> parts;
    for (std::uint32_t t = 0; t < of.surface.triangles.size(); ++t) {
        const auto is_inside = [&](const Use& use) {
            const CutEdge& edge = of.edges[use.edge];
            return of.winding[edge.from] != 0 || !edge.cuts.empty();
        };
        if (segments[t].empty() && std::ranges::none_of(of.uses[t], is_inside)) continue;
        const std::uint32_t* v = of.surface.triangles[t].vertex;
        const Vec3d corner = grid.place(of.surface.points[v[0]]);
        const Vec3d normal = normalized(cross(grid.place(of.surface.points[v[1]]) - corner,
                                              grid.place(of.surface.points[v[2]]) - corner));
        Outline outline(origin, normal);
        for (const Use& use : of.uses[t]) add_edge(grid, of, use, outline);
        for (const Segment& m : segments[t]) outline.add(1, m.from, m.to);
        if (outline.part().area == 0) continue;
        parts.push_back(outline.part());
        parts.back().triangle = t;
    }
    return parts;
}

/// A place of what two surfaces have in common, if they have anything.
Vec3d common_place(const Grid& grid, const Cuttable& a, const Cuttable& b,
                   const Segments& segments) {
    if (!segments.empty()) return segments.begin()->second.from;
    for (const Cuttable* of : {&a, &b})
        for (std::uint32_t v = 0; v < of->winding.size(); ++v)
            if (of->winding[v] != 0) return grid.place(of->surface.points[v]);
    return {};
}

}  // namespace

FaceParts find_face_parts(const Grid& grid, const GridSurface& first, const GridSurface& second) {
    Cuttable a(first, Shift::moved), b(second, Shift::other);
    cut_edges(grid, a, b);
    cut_edges(grid, b, a);
    find_windings(a, b);
    find_windings(b, a);
    std::vector<std::vector<Segment>> on_a(first.triangles.size()), on_b(second.triangles.size());
    const Segments segments = find_segments(a, b);
    for (const auto& [triangles, segment] : segments) {
        on_a[triangles.first].push_back(segment);
        on_b[triangles.second].push_back({segment.to, segment.from});
    }
    FaceParts parts;
    parts.origin = common_place(grid, a, b, segments);
    parts.of[0] = parts_of(grid, parts.origin, a, on_a);
    parts.of[1] = parts_of(grid, parts.origin, b, on_b);
    for (int side = 0; side < 2; ++side) {
        const Cuttable& of = side == 0 ? a : b;
        for (std::uint32_t v = 0; v < of.winding.size(); ++v)
            if (of.winding[v] != 0) parts.vertices_in[side].push_back(v);
    }
    return parts;
}

}  // namespace pierce
