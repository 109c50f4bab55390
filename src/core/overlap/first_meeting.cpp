#include "core/overlap/first_meeting.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "core/geometry/continuous.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

Vec3d at_time(const MovingPoint& p, double t) { return p.start + t * (p.end - p.start); }

/// Which vertices and edges of each triangle are looked at with it, so that each is looked at once.
/// Bits 0 to 2 are vertices, bits 3 to 5 the edges from them to the next ones.
std::vector<std::uint8_t> own_features(const MovingSurface& surface) {
    std::vector<std::uint8_t> own(surface.triangles.size(), 0);
    std::vector<bool> seen(surface.points.size(), false);
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::size_t t = 0; t < own.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t u = surface.triangles[t].vertex[k],
                                v = surface.triangles[t].vertex[(k + 1) % 3];
            if (!seen[u]) own[t] |= static_cast<std::uint8_t>(1u << k);
            seen[u] = true;
            if (edges.emplace(std::min(u, v), std::max(u, v)).second)
                own[t] |= static_cast<std::uint8_t>(8u << k);
        }
    return own;
}

class Search {
public:
    Search(const MovingSurface& first, const MovingSurface& second)
        : first_(first),
          second_(second),
          own_first_(own_features(first)),
          own_second_(own_features(second)) {
        Box both = first.box();
        both.extend(second.box());
        const double travel = travel_of(first) + travel_of(second);
        // What meets at the same place is found within the tolerance of it, in this time at least.
        same_time_ = travel > 0 ? 2 * constants::meeting_tolerance * both.extent() / travel : 0.0;
    }

    std::optional<FirstMeeting> run() {
        std::vector<std::uint32_t> near;
        std::vector<Box> boxes;
        const Box around_first = first_.box(), around_second = second_.box();
        for (std::uint32_t t = 0; t < second_.triangles.size(); ++t) {
            const Box box = box_of(second_, t);
            if (!overlap(box, around_first)) continue;
            near.push_back(t);
            boxes.push_back(box);
        }
        if (near.empty()) return {};
        const BoxTree tree(boxes);
        for (std::uint32_t t = 0; t < first_.triangles.size(); ++t) {
            const Box box = box_of(first_, t);
            if (!overlap(box, around_second)) continue;
            tree.for_each_in(box, [&](std::uint32_t n) { look(t, near[n]); });
        }
        if (!is_found_) return {};
        best_.time = earliest_;
        return best_;
    }

private:
    static double travel_of(const MovingSurface& surface) {
        double most = 0;
        for (const MovingPoint& p : surface.points) most = std::max(most, length(p.end - p.start));
        return most;
    }
    static Box box_of(const MovingSurface& surface, std::uint32_t triangle) {
        Box box;
        for (std::uint32_t v : surface.triangles[triangle].vertex) {
            box.extend(surface.points[v].start);
            box.extend(surface.points[v].end);
        }
        return box;
    }

    void look(std::uint32_t t, std::uint32_t u) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (own_first_[t] >> k & 1u) look_at_vertex(first_, t, k, second_, u, false);
            if (own_second_[u] >> k & 1u) look_at_vertex(second_, u, k, first_, t, true);
            if (!(own_first_[t] >> (3 + k) & 1u)) continue;
            for (std::uint32_t m = 0; m < 3; ++m)
                if (own_second_[u] >> (3 + m) & 1u) look_at_edges(t, k, u, m);
        }
    }

    /// True if a meeting comes first. Of those that come at the same time, one between the ends of
    /// edges or corners of faces counts more: only it has a normal of its own.
    bool is_first(const Impact& impact, bool within) {
        earliest_ = std::min(earliest_, impact.time);
        if (!is_found_ || impact.time < best_.time - same_time_) return true;
        return impact.time <= best_.time + same_time_ && within && !is_within_;
    }

    static bool is_inner(double weight) {
        return weight > constants::meeting_tolerance && weight < 1 - constants::meeting_tolerance;
    }

    void look_at_vertex(const MovingSurface& of, std::uint32_t t, std::uint32_t k,
                        const MovingSurface& face_of, std::uint32_t u, bool second) {
        const std::uint32_t v = of.triangles[t].vertex[k];
        const std::uint32_t* corner = face_of.triangles[u].vertex;
        const MovingPoint &p = of.points[v], &a = face_of.points[corner[0]],
                          &b = face_of.points[corner[1]], &c = face_of.points[corner[2]];
        Impact impact;
        if (!vertex_meets_face(p, a, b, c, impact)) return;
        // A vertex at the border of a face still leaves by the face.
        if (!is_first(impact, true)) return;
        const double time = impact.time;
        const Vec3d face = cross(at_time(b, time) - at_time(a, time),
                                 at_time(c, time) - at_time(a, time));
        const Vec3d apart = a.start + impact.u * (b.start - a.start) +
                            impact.v * (c.start - a.start) - p.start;
        note(time, at_time(p, time), face, second ? -apart : apart, true);
        best_.vertex_of_second = second;
        best_.vertex = v;
        best_.triangle = u;
    }

    void look_at_edges(std::uint32_t t, std::uint32_t k, std::uint32_t u, std::uint32_t m) {
        const Triangle &one = first_.triangles[t], &other = second_.triangles[u];
        const std::uint32_t from = one.vertex[k], to = one.vertex[(k + 1) % 3];
        const MovingPoint &a = first_.points[from], &b = first_.points[to],
                          &c = second_.points[other.vertex[m]],
                          &d = second_.points[other.vertex[(m + 1) % 3]];
        Impact impact;
        if (!edges_meet(a, b, c, d, impact)) return;
        const bool within = is_inner(impact.u) && is_inner(impact.v);
        if (!is_first(impact, within)) return;
        const double time = impact.time;
        const Vec3d along = at_time(b, time) - at_time(a, time),
                    across = at_time(d, time) - at_time(c, time);
        const Vec3d apart = c.start + impact.v * (d.start - c.start) - a.start -
                            impact.u * (b.start - a.start);
        note(time, at_time(a, time) + impact.u * along, cross(along, across), apart, within);
        best_.edges = true;
        best_.vertex = from;
        best_.edge_end = to;
        best_.triangle = u;
    }

    /// `apart`: from the first surface to the second at time 0, at the places that meet.
    void note(double time, Vec3d place, Vec3d normal, Vec3d apart, bool within) {
        is_within_ = within;
        // Parallel edges and faces without area have no normal: the way they come is one.
        normal = normalized(length_squared(normal) > 0 ? normal : apart);
        if (dot(normal, apart) < 0) normal = -normal;
        is_found_ = true;
        best_ = {};
        best_.time = time;
        best_.place = place;
        best_.normal = normal;
        best_.gap = dot(normal, apart);
    }

    const MovingSurface &first_, &second_;
    std::vector<std::uint8_t> own_first_, own_second_;
    FirstMeeting best_;
    bool is_found_ = false;
    bool is_within_ = false;  ///< of `best_`
    double earliest_ = 1, same_time_ = 0;
};

}  // namespace

Box MovingSurface::box() const {
    Box around;
    for (const MovingPoint& p : points) {
        around.extend(p.start);
        around.extend(p.end);
    }
    return around;
}

std::optional<FirstMeeting> first_meeting(const MovingSurface& first, const MovingSurface& second) {
    return Search(first, second).run();
}

}  // namespace pierce
