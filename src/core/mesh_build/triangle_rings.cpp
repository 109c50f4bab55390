#include "core/mesh_build/triangle_rings.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "core/base/workers.hpp"
#include "core/device/bits.hpp"
#include "core/geometry/closest_point.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/four_distances.hpp"
#include "core/mesh_build/openness.hpp"

namespace pierce {

std::vector<Neighbors> neighbors_of(std::size_t triangles, const HalfEdges& sides_of_all) {
    std::vector<Neighbors> neighbors(triangles);
    sides_of_all.for_each_edge([&](std::span<const HalfEdge> sides) {
        if (sides.size() != 2) return;
        neighbors[sides[0].triangle].across[sides[0].opposite] = sides[1].triangle;
        neighbors[sides[1].triangle].across[sides[1].opposite] = sides[0].triangle;
    });
    return neighbors;
}

namespace {

/// True if the triangles around `v` form one closed fan that, seen along `axis`, goes once around
/// it.
bool goes_around_once(const MeshView& mesh, std::uint32_t v, Vec3d axis) {
    const Corner* corner = mesh.corners.data + mesh.corner_offsets[v];
    const std::uint32_t count = mesh.corner_offsets[v + 1] - mesh.corner_offsets[v];
    std::uint32_t next = corner[0].previous, seen = 1;
    while (next != corner[0].next && seen < count) {
        const Corner* found = std::find_if(corner, corner + count,
                                           [&](const Corner& c) { return c.next == next; });
        if (found == corner + count) return false;
        next = found->previous;
        ++seen;
    }
    if (next != corner[0].next || seen != count) return false;

    // How often the triangles, one after the other, cross the half line from the apex through the
    // first corner counter-clockwise, less how often clockwise.
    const Vec3d apex = to_double(mesh.positions[v]);
    const auto from_apex = [&](std::uint32_t u) { return to_double(mesh.positions[u]) - apex; };
    const Vec3d first = from_apex(corner[0].next), side = cross(axis, first);
    int turns = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3d a = from_apex(corner[i].next), b = from_apex(corner[i].previous);
        const bool a_is_left = corner[i].next == corner[0].next || dot(a, side) > 0,
                   b_is_left = corner[i].previous == corner[0].next || dot(b, side) > 0;
        const bool counter_clockwise = dot(cross(a, b), axis) > 0;
        if (!a_is_left && b_is_left && counter_clockwise) ++turns;
        if (a_is_left && !b_is_left && !counter_clockwise) --turns;
    }
    return turns == 1;
}

double triangle_distance(const Corners& a, const Corners& b) {
    if (edge_pierces(a, b, 0, 0) || edge_pierces(b, a, 0, 0)) return 0;
    double best = length(a[0] - closest_on_triangle(a[0], b[0], b[1], b[2]));
    for (int i = 0; i < 3; ++i) {
        best = std::min(best, length(a[i] - closest_on_triangle(a[i], b[0], b[1], b[2])));
        best = std::min(best, length(b[i] - closest_on_triangle(b[i], a[0], a[1], a[2])));
        for (int j = 0; j < 3; ++j)
            best = std::min(best, segment_distance(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
    }
    return best;
}

Corners corners_of(const MeshView& mesh, std::uint32_t t) {
    return corners_of(mesh.positions, mesh.triangles[t]);
}

Vec3d center_of(const Corners& c) { return (1.0 / 3) * (c[0] + c[1] + c[2]); }

/// The triangles of the ring, each as often as it shares a vertex.
void list_ring(const MeshView& mesh, std::uint32_t t, std::vector<Corners>& ring) {
    const auto at = [&](std::uint32_t v) { return to_double(mesh.positions[v]); };
    ring.clear();
    for (std::uint32_t v : mesh.triangles[t].vertex)
        for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i)
            ring.push_back({at(v), at(mesh.corners[i].next), at(mesh.corners[i].previous)});
}

/// The cone around the ring's normals, and by how much they may turn.
void measure_normals(const MeshView& mesh, std::uint32_t t, const std::vector<Corners>& triangles,
                     std::vector<Vec3d>& normals, TriangleRing& ring) {
    Vec3d sum;
    normals.clear();
    double lowest = std::numeric_limits<double>::infinity();
    bool sound = true;
    for (const Corners& c : triangles) {
        const Vec3d normal = cross(c[1] - c[0], c[2] - c[0]);
        lowest = std::min(
            lowest, length(normal) /
                        std::max({length(c[1] - c[0]), length(c[2] - c[0]), length(c[2] - c[1])}));
        sound &= !is_degenerate(c[0], c[1], c[2]);
        normals.push_back(normalized(normal));
        sum += normals.back();
    }
    // Where vertices move by d, edges e and f each change by 2 d, and the normal e x f by 4 d
    // (longest + d) at most. The normal's length is longest times lowest. So the sine of its turn
    // is below 8 d / lowest while d is below the longest edge; beyond, 8 d / lowest is above 1.
    ring.tilt = round_up(8 / lowest);

    const Vec3d axis = normalized(sum);
    double cosine = 1;
    for (Vec3d n : normals) cosine = std::min(cosine, dot(axis, n));
    sound &= cosine > 0;
    for (std::uint32_t v : mesh.triangles[t].vertex)
        sound = sound && goes_around_once(mesh, v, axis);
    if (!sound) return;
    ring.axis = to_float(axis);
    // The sine is rounded up, so that a direction inside the cone faces every triangle of the ring
    // for certain.
    ring.sine = static_cast<float>(std::sqrt(1 - std::min(cosine * cosine, 1.0)) +
                                   constants::touch_tolerance);
}

constexpr std::uint32_t triangles_at_once = 256;  ///< of a thread
constexpr double first_part_of_reach = 4;  ///< the search for a gap begins within the reach divided
                                           ///< by this, or further

/// The squared distance between two boxes, not more than it is.
float squared_gap(const QuickBox& a, const QuickBox& b) {
    float squared = 0;
    for (int r = 0; r < 3; ++r) {
        const float gap = std::max({a.lower[r] - b.upper[r], b.lower[r] - a.upper[r], 0.0f});
        squared += gap * gap;
    }
    return squared * (1 - 4 * std::numeric_limits<float>::epsilon());
}

/// A triangle in float32, relative to a point near it.
struct NearTriangle {
    Vec3f corner[3];
};

/// The distance from a triangle to the closest one of some others; asks four at a time.
class GapSearch {
public:
    GapSearch(const Corners& own, double most)
        : own_(own), origin_(own_[0]), gap_(most), distances_(near_origin(own_).corner) {}

    double gap() const { return gap_; }

    void add(const Corners& other) {
        waiting_[count_++] = other;
        if (count_ == Four::count) ask();
    }
    void ask() {
        if (count_ == 0) return;
        FourVec3 corners[3];
        for (std::uint32_t lane = 0; lane < Four::count; ++lane) {
            const NearTriangle near = near_origin(waiting_[lane < count_ ? lane : 0]);
            for (std::size_t k = 0; k < 3; ++k) {
                corners[k].x.set(lane, near.corner[k].x);
                corners[k].y.set(lane, near.corner[k].y);
                corners[k].z.set(lane, near.corner[k].z);
            }
        }
        const FourDistances found = distances_.from(corners);
        for (std::uint32_t lane = 0; lane < count_; ++lane) {
            const double distance = static_cast<double>(found.distance[lane]);
            const bool is_known = (found.unknown >> lane & 1) == 0;
            if (is_known && distance >= gap_) continue;
            gap_ = std::min(is_known ? distance : triangle_distance(own_, waiting_[lane]), gap_);
        }
        count_ = 0;
    }

private:
    NearTriangle near_origin(const Corners& c) const {
        return {{to_float(c[0] - origin_), to_float(c[1] - origin_), to_float(c[2] - origin_)}};
    }

    Corners own_;
    Vec3d origin_;
    double gap_;
    DistancesOfTriangle distances_;
    Corners waiting_[Four::count];
    std::uint32_t count_ = 0;
};

/// Finds what is known of the rings of triangles, one after the other.
class RingFinder {
public:
    /// `boxes`: of the triangles.
    RingFinder(const MeshView& mesh, std::span<const QuickBox> boxes, const MeshChange* change)
        : mesh_(mesh),
          boxes_(boxes),
          change_(change),
          levels_(mesh.triangles.size),
          rounding_(constants::touch_tolerance * mesh.box.extent()) {}

    TriangleRing find(std::uint32_t t) {
        TriangleRing ring;
        const Corners own = corners_of(mesh_, t);
        list_ring(mesh_, t, triangles_);
        // The rest of the surface is looked for as far as the ring reaches.
        double reach = 0;
        const Vec3d center = center_of(own);
        for (const Corners& c : triangles_)
            for (Vec3d p : c) reach = std::max(length_squared(p - center), reach);
        reach = std::sqrt(reach);
        // A box in float32 is rounded outward, so a little more than the reach is looked at.
        if (change_ != nullptr)
            if (const TriangleRing* const known = change_->ring(mesh_, t)) {
                ring = *known;
                ring.gap = gap_after_change(t, ring, reach);
                return ring;
            }
        measure_normals(mesh_, t, triangles_, normals_, ring);
        for (int k = 0; k < 3; ++k) {
            const Vec3d edge = own[(k + 2) % 3] - own[(k + 1) % 3];
            ring.height[k] = round_down(length(cross(edge, own[k] - own[(k + 1) % 3])) /
                                        length(edge));
        }
        ring.openness = openness_of(t);
        ring.gap = gap_beyond_ring(t, ring, reach);
        return ring;
    }

private:
    /// A triangle that may be near, and how far its box is away.
    struct Other {
        float squared;
        std::uint32_t triangle;
    };

    /// Calls see(other) for the other triangles whose boxes may come within `reach` of a
    /// triangle's.
    template <class See>
    void for_each_near(std::uint32_t t, double reach, const See& see) const {
        const QuickBox region = boxes_[t].inflated(not_below(static_cast<float>(reach)));
        for_each_group(
            mesh_.box_nodes, levels_, region, [&](std::uint32_t group, std::uint32_t mask) {
                for (; mask != 0; mask &= mask - 1) {
                    const std::uint32_t place = group * constants::group_size + lowest_bit(mask),
                                        other = mesh_.group_triangles[place];
                    if (other != t) see(other);
                }
                return false;
            });
    }

    /// The least openness of those that share a vertex.
    float openness_of(std::uint32_t t) const {
        const Triangle& own = mesh_.triangles[t];
        const Openness own_openness(corners_of(mesh_, t));
        double openness = 1;
        for_each_near(t, 0, [&](std::uint32_t other) {
            if (share_vertex(own, mesh_.triangles[other]))
                openness = std::min(
                    own_openness.towards(own, mesh_.triangles[other], corners_of(mesh_, other)),
                    openness);
        });
        return static_cast<float>(std::max(openness - constants::touch_tolerance, 0.0));
    }

    /// `ring`: its heights are known.
    float gap_beyond_ring(std::uint32_t t, const TriangleRing& ring, double reach) {
        // Most gaps are about as wide as the triangle is high, which is a good part of the reach.
        // The heights of a triangle without area are NaN.
        const double height = std::ranges::min(ring.height), least = reach / first_part_of_reach;
        double radius = height > least ? height : least;
        double gap = reach;
        for (;; radius *= 2) {
            radius = std::min(radius, reach);
            gap = gap_within(t, radius, reach);
            if (gap <= radius || radius >= reach) break;
        }
        return round_down(std::max(gap - rounding_, 0.0));
    }

    /// The gap of a ring whose triangles have not changed.
    float gap_after_change(std::uint32_t t, const TriangleRing& ring, double reach) {
        const double near = std::min(reach + rounding_,
                                     static_cast<double>(ring.gap) + gap_loss(reach, mesh_));
        const Corners own = corners_of(mesh_, t);
        Box region;
        for (Vec3d p : own) region.extend(p);
        GapSearch came(own, ring.gap + rounding_), went(own, near);
        change_->for_each_changed(region.inflated(near), [&](const Corners& c, bool is_new) {
            (is_new ? came : went).add(c);
        });
        came.ask();
        went.ask();
        if (went.gap() < near) return gap_beyond_ring(t, ring, reach);
        return std::min(ring.gap, round_down(std::max(came.gap() - rounding_, 0.0)));
    }

    /// The distance to the closest of the triangles outside of the ring within `radius`; `most` if
    /// there is none.
    double gap_within(std::uint32_t t, double radius, double most) {
        const QuickBox& box = boxes_[t];
        const float limit = not_below(static_cast<float>(radius * radius));
        others_.clear();
        for_each_near(t, radius, [&](std::uint32_t other) {
            const float squared = squared_gap(box, boxes_[other]);
            if (squared <= limit && !share_vertex(mesh_.triangles[t], mesh_.triangles[other]))
                others_.push_back({squared, other});
        });
        // Those that look nearest decide on how many others are looked at.
        const auto first = others_.begin() +
                           std::min<std::ptrdiff_t>(Four::count, std::ssize(others_));
        std::ranges::nth_element(others_, first, {}, &Other::squared);
        GapSearch search(corners_of(mesh_, t), most);
        for (const Other& other : others_)
            if (static_cast<double>(other.squared) < search.gap() * search.gap())
                search.add(corners_of(mesh_, other.triangle));
        search.ask();
        return search.gap();
    }

    const MeshView& mesh_;
    std::span<const QuickBox> boxes_;
    const MeshChange* change_;  ///< may be null
    BoxLevels levels_;
    double rounding_;
    std::vector<Corners> triangles_;
    std::vector<Vec3d> normals_;
    std::vector<Other> others_;
};

}  // namespace

std::vector<TriangleRing> rings_of(const MeshView& mesh, Workers& workers,
                                   const MeshChange* change) {
    std::vector<QuickBox> boxes(mesh.triangles.size);
    for (std::uint32_t t = 0; t < mesh.triangles.size; ++t)
        boxes[t] = box_of(mesh, mesh.positions, t);
    std::vector<TriangleRing> rings(mesh.triangles.size);
    std::vector<std::uint32_t> unknown;
    if (change != nullptr) {
        unknown = change->triangles_with_changed_rings(mesh);
        for (std::uint32_t t = 0; t < rings.size(); ++t)
            if (const TriangleRing* const known = change->ring(mesh, t)) rings[t] = *known;
    } else {
        unknown.resize(mesh.triangles.size);
        std::iota(unknown.begin(), unknown.end(), 0u);
    }
    workers.share_out("rings", static_cast<std::uint32_t>(unknown.size()), triangles_at_once,
                      [&](std::uint32_t begin, std::uint32_t end) {
                          RingFinder finder(mesh, boxes, change);
                          for (std::uint32_t i = begin; i < end; ++i)
                              rings[unknown[i]] = finder.find(unknown[i]);
                      });
    return rings;
}

}  // namespace pierce
