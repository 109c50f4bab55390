#include "core/overlap/first_meeting.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/geometry/continuous.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

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
          own_second_(own_features(second)),
          normals_{normals_of(first), normals_of(second)} {
        Box both = first.box();
        both.extend(second.box());
        const double travel = travel_of(first) + travel_of(second);
        // What meets at the same place is found within the tolerance of it, in this time at least.
        tolerance_ = 2 * constants::meeting_tolerance * both.extent();
        same_time_ = travel > 0 ? tolerance_ / travel : 0.0;
    }

    std::vector<FirstMeeting> run(std::uint32_t most) {
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
        std::vector<FirstMeeting> result{best_};
        spread(result, most);
        return result;
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
        const double time = impact.time;
        const Vec3d outward = cross(at_time(b, time) - at_time(a, time),
                                    at_time(c, time) - at_time(a, time));
        const auto on_face = [&](double at) {
            const Vec3d corner_a = at_time(a, at);
            return corner_a + impact.u * (at_time(b, at) - corner_a) +
                   impact.v * (at_time(c, at) - corner_a);
        };
        const MovingPoint face{on_face(0), on_face(1)};
        FirstMeeting meeting = second ? made(time, at_time(p, time), outward, face, p)
                                      : made(time, at_time(p, time), -outward, p, face);
        if (!is_meeting(meeting, second ? face : p, second ? p : face)) return;
        meeting.vertex_of_second = second;
        meeting.vertex = v;
        meeting.triangle = u;
        const auto [known, is_new] = of_vertices_.try_emplace({second, v}, meeting);
        if (!is_new && time < known->second.time) known->second = meeting;
        // A vertex at the border of a face still leaves by the face.
        note(meeting, true);
    }

    void look_at_edges(std::uint32_t t, std::uint32_t k, std::uint32_t u, std::uint32_t m) {
        const Triangle &one = first_.triangles[t], &other = second_.triangles[u];
        const std::uint32_t from = one.vertex[k], to = one.vertex[(k + 1) % 3];
        const MovingPoint &a = first_.points[from], &b = first_.points[to],
                          &c = second_.points[other.vertex[m]],
                          &d = second_.points[other.vertex[(m + 1) % 3]];
        Impact impact;
        if (!edges_meet(a, b, c, d, impact)) return;
        const double time = impact.time;
        const auto on = [](const MovingPoint& begin, const MovingPoint& end, double along) {
            return MovingPoint{begin.start + along * (end.start - begin.start),
                               begin.end + along * (end.end - begin.end)};
        };
        const MovingPoint first = on(a, b, impact.u), second = on(c, d, impact.v);
        Vec3d normal = cross(at_time(b, time) - at_time(a, time),
                             at_time(d, time) - at_time(c, time));
        if (dot(normal, normals_[0][from] + normals_[0][to]) < 0) normal = -normal;
        FirstMeeting meeting = made(time, at_time(first, time), normal, first, second);
        if (!is_meeting(meeting, first, second)) return;
        meeting.edges = true;
        meeting.vertex = from;
        meeting.edge_end = to;
        meeting.triangle = u;
        note(meeting, is_inner(impact.u) && is_inner(impact.v));
    }

    /// `first`, `second`: the places that meet. `normal` leads from the first surface to the second
    /// where they touch as they begin.
    FirstMeeting made(double time, Vec3d place, Vec3d normal, const MovingPoint& first,
                      const MovingPoint& second) const {
        const Vec3d apart = second.start - first.start;
        // Parallel edges and faces without area have no normal: the way they come is one.
        normal = normalized(length_squared(normal) > 0 ? normal : apart);
        if (dot(normal, apart) < -tolerance_) normal = -normal;
        FirstMeeting meeting;
        meeting.time = time;
        meeting.place = place;
        meeting.normal = normal;
        meeting.gap = max_of(dot(normal, apart), 0.0);
        meeting.start[0] = first.start;
        meeting.start[1] = second.start;
        return meeting;
    }

    /// False if two places only slide along each other, as the sides of boxes that lie in one plane
    /// do: that stops nothing.
    bool is_meeting(const FirstMeeting& meeting, const MovingPoint& first,
                    const MovingPoint& second) const {
        const Vec3d way = (first.end - first.start) - (second.end - second.start);
        return meeting.gap > tolerance_ || dot(meeting.normal, way) > tolerance_;
    }

    /// Keeps what comes first. Of meetings at the same time, one between the ends of edges or
    /// corners of faces counts more: only it has a normal of its own.
    void note(const FirstMeeting& meeting, bool within) {
        earliest_ = std::min(earliest_, meeting.time);
        const bool is_first = !is_found_ || meeting.time < best_.time - same_time_ ||
                              (meeting.time <= best_.time + same_time_ && within && !is_within_);
        if (!is_first) return;
        is_found_ = true;
        is_within_ = within;
        best_ = meeting;
    }

    /// Per vertex, the way its triangles face as the surface begins.
    static std::vector<Vec3d> normals_of(const MovingSurface& surface) {
        std::vector<Vec3d> normals(surface.points.size());
        for (const Triangle& t : surface.triangles) {
            const Vec3d a = surface.points[t.vertex[0]].start;
            const Vec3d normal = cross(surface.points[t.vertex[1]].start - a,
                                       surface.points[t.vertex[2]].start - a);
            for (std::uint32_t v : t.vertex) normals[v] += normal;
        }
        return normals;
    }

    /// Adds first meetings of vertices that face what they meet, each as far as possible from those
    /// that are there.
    void spread(std::vector<FirstMeeting>& meetings, std::uint32_t most) const {
        std::vector<const FirstMeeting*> left;
        std::vector<double> far;
        for (const auto& [vertex, meeting] : of_vertices_) {
            const auto [of_second, v] = vertex;
            if (!((of_second ? -1 : 1) * dot(normals_[of_second][v], meeting.normal) > 0)) continue;
            left.push_back(&meeting);
            far.push_back(std::numeric_limits<double>::infinity());
        }
        while (meetings.size() < most) {
            std::size_t furthest = left.size();
            double distance = 0;
            for (std::size_t i = 0; i < left.size(); ++i) {
                for (int side = 0; side < 2; ++side)
                    far[i] = std::min(
                        length_squared(left[i]->start[side] - meetings.back().start[side]), far[i]);
                if (far[i] <= distance) continue;
                distance = far[i];
                furthest = i;
            }
            if (furthest == left.size()) return;
            meetings.push_back(*left[furthest]);
        }
    }

    const MovingSurface &first_, &second_;
    std::vector<std::uint8_t> own_first_, own_second_;
    std::vector<Vec3d> normals_[2];
    FirstMeeting best_;
    std::map<std::pair<bool, std::uint32_t>, FirstMeeting> of_vertices_;  ///< of the second surface
                                                                          ///< or not; its vertex
    bool is_found_ = false;
    bool is_within_ = false;  ///< of `best_`
    double earliest_ = 1, tolerance_ = 0, same_time_ = 0;
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

std::vector<FirstMeeting> first_meetings(const MovingSurface& first, const MovingSurface& second,
                                         std::uint32_t most) {
    return Search(first, second).run(most);
}

}  // namespace pierce
