#include "core/overlap/first_meeting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <tuple>
#include <utility>

#include "core/geometry/continuous.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "core/overlap/foremost_features.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

namespace pierce {
namespace {

/// True unless a vertex leaves the face that it meets, and goes to where that faces.
bool enters(const MovingPoint& p, const MovingPoint& a, const MovingPoint& b, const MovingPoint& c,
            const Impact& impact) {
    const auto way = [](const MovingPoint& q) { return q.end - q.start; };
    const Vec3d from = at_time(a, impact.time);
    const Vec3d outward = cross(at_time(b, impact.time) - from, at_time(c, impact.time) - from);
    const Vec3d of_face = way(a) + impact.u * (way(b) - way(a)) + impact.v * (way(c) - way(a));
    return !(dot(outward, way(p) - of_face) > 0);
}

class Search {
public:
    Search(const MovingSurface& first, const MovingSurface& second)
        : first_(first),
          second_(second),
          own_first_(first.own_features()),
          own_second_(second.own_features()),
          around_{VertexCorners(first), VertexCorners(second)},
          normals_{first.normals(&MovingPoint::start), second.normals(&MovingPoint::start)} {
        Box both = first.box();
        both.extend(second.box());
        skin_ = touch_at_start(first, second);
        inner_first_ = first.inner(skin_);
        inner_second_ = second.inner(skin_);
        const double travel = travel_of(first) + travel_of(second);
        tolerance_ = 2 * constants::meeting_tolerance * both.extent();
        // What meets at the same place is found within the tolerance of it, or within the skins of
        // both surfaces, in this time at least.
        same_time_ = travel > 0 ? tolerance_ / travel : 0.0;
        same_time_in_skin_ = travel > 0 ? 4 * skin_ / travel : 0.0;
    }

    std::vector<FirstMeeting> run(std::uint32_t most) {
        std::vector<std::uint32_t> near;
        std::vector<Box> boxes;
        const Box around_first = first_.box(), around_second = second_.box();
        for (std::uint32_t t = 0; t < second_.triangles.size(); ++t) {
            // What begins within the skin may be behind the other surface all the time.
            const Box box = box_of(second_, t).inflated(skin_);
            if (!overlap(box, around_first)) continue;
            near.push_back(t);
            boxes.push_back(box);
        }
        if (near.empty()) return {};
        const BoxTree tree(boxes);
        for (std::uint32_t t = 0; t < first_.triangles.size(); ++t) {
            const Box box = box_of(first_, t);
            if (!overlap(box, around_second.inflated(skin_))) continue;
            tree.for_each_in(box, [&](std::uint32_t n) { look(t, near[n]); });
        }
        if (!is_found_) return {};
        best_.meeting.time = earliest_;
        std::vector<FirstMeeting> result{best_.meeting};
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

    /// True for a place on an edge that is more than two skins from its ends.
    bool is_inner(double weight, const MovingPoint& from, const MovingPoint& to) const {
        return min_of(weight, 1 - weight) * length(to.start - from.start) > 2 * skin_;
    }

    /// True for a place on a face that is as near to one of its sides as what has sunk in by
    /// rounding is deep.
    bool is_at_border(const MovingPoint& a, const MovingPoint& b, const MovingPoint& c,
                      const Impact& impact) const {
        const Vec3d at[3] = {at_time(a, impact.time), at_time(b, impact.time),
                             at_time(c, impact.time)};
        const double weight[3] = {1 - impact.u - impact.v, impact.u, impact.v},
                     twice_area = length(cross(at[1] - at[0], at[2] - at[0]));
        for (int k = 0; k < 3; ++k)
            if (weight[k] * twice_area <=
                constants::skin * skin_ * length(at[(k + 2) % 3] - at[(k + 1) % 3]))
                return true;
        return false;
    }

    void look_at_vertex(const MovingSurface& of, std::uint32_t t, std::uint32_t k,
                        const MovingSurface& face_of, std::uint32_t u, bool second) {
        const std::uint32_t v = of.triangles[t].vertex[k];
        const std::uint32_t* corner = face_of.triangles[u].vertex;
        const MovingPoint &p = of.points[v], &a = face_of.points[corner[0]],
                          &b = face_of.points[corner[1]], &c = face_of.points[corner[2]];
        const auto find = [&](Impact& impact) { return vertex_meets_face(p, a, b, c, impact); };
        const auto comes_first = [&](const Impact& impact) {
            const Vec3d from = at_time(a, impact.time);
            return is_foremost(
                of, around_[second], v, impact.time,
                cross(at_time(b, impact.time) - from, at_time(c, impact.time) - from), skin_);
        };
        const auto find_inside = [&](Impact& impact) {
            const MovingPoint in{skin_ * normalized(cross(b.start - a.start, c.start - a.start)),
                                 skin_ * normalized(cross(b.end - a.end, c.end - a.end))};
            const auto inner = [&](const MovingPoint& q) {
                return MovingPoint{q.start - in.start, q.end - in.end};
            };
            const auto enters_through = [&](const MovingPoint& inner_a, const MovingPoint& inner_b,
                                            const MovingPoint& inner_c) {
                return vertex_meets_face(p, inner_a, inner_b, inner_c, impact) &&
                       enters(p, inner_a, inner_b, inner_c, impact);
            };
            if (enters_through(inner(a), inner(b), inner(c)) && comes_first(impact)) return true;
            // Where the surface is hollow, there is a gap between its faces within the skin.
            const std::vector<MovingPoint>& in_face = (second ? inner_first_ : inner_second_)
                                                          .points;
            return enters_through(in_face[corner[0]], in_face[corner[1]], in_face[corner[2]]) &&
                   (!is_at_border(a, b, c, impact) || comes_first(impact));
        };
        const auto describe = [&](const Impact& impact) {
            const double time = impact.time;
            const Vec3d outward = cross(at_time(b, time) - at_time(a, time),
                                        at_time(c, time) - at_time(a, time));
            const auto on_face = [&](double at) {
                const Vec3d corner_a = at_time(a, at);
                return corner_a + impact.u * (at_time(b, at) - corner_a) +
                       impact.v * (at_time(c, at) - corner_a);
            };
            const MovingPoint face{on_face(0), on_face(1)};
            return second ? made(time, at_time(p, time), outward, face, p)
                          : made(time, at_time(p, time), -outward, p, face);
        };
        Impact impact;
        Found found;
        const Vec3d normal = cross(b.start - a.start, c.start - a.start);
        if (!meets(
                is_within_skin(dot(normal, p.start - a.start), normal), find, find_inside, describe,
                [&](const Impact& at, Vec3d) { return comes_first(at); }, impact, found))
            return;
        FirstMeeting& meeting = found.meeting;
        meeting.vertex_of_second = second;
        meeting.vertex = v;
        meeting.triangle = u;
        const auto [known, is_new] = of_vertices_.try_emplace({second, v}, meeting);
        if (!is_new && meeting.time < known->second.time) known->second = meeting;
        found.is_within = true;  // a vertex at the border of a face still leaves by the face
        note(found);
    }

    void look_at_edges(std::uint32_t t, std::uint32_t k, std::uint32_t u, std::uint32_t m) {
        const Triangle &one = first_.triangles[t], &other = second_.triangles[u];
        const std::uint32_t from = one.vertex[k], to = one.vertex[(k + 1) % 3],
                            begin = other.vertex[m], end = other.vertex[(m + 1) % 3];
        const auto find = [&](const MovingSurface& first, const MovingSurface& second,
                              Impact& impact) {
            return edges_meet(first.points[from], first.points[to], second.points[begin],
                              second.points[end], impact);
        };
        const Vec3d across = cross(first_.points[to].start - first_.points[from].start,
                                   second_.points[end].start - second_.points[begin].start);
        const bool begins_in_skin = is_within_skin(
            dot(across, second_.points[begin].start - first_.points[from].start), across);
        const auto describe = [&](const Impact& impact) {
            const MovingPoint &a = first_.points[from], &b = first_.points[to],
                              &c = second_.points[begin], &d = second_.points[end];
            const double time = impact.time;
            const auto on = [](const MovingPoint& p, const MovingPoint& q, double along) {
                return MovingPoint{p.start + along * (q.start - p.start),
                                   p.end + along * (q.end - p.end)};
            };
            const MovingPoint first = on(a, b, impact.u);
            Vec3d normal = cross(at_time(b, time) - at_time(a, time),
                                 at_time(d, time) - at_time(c, time));
            if (dot(normal, normals_[0][from] + normals_[0][to]) < 0) normal = -normal;
            const MovingPoint second = on(c, d, impact.v);
            // Edges that are apart as they begin come from the side that they are on; the normals
            // of vertices need not say which that is.
            if (!begins_in_skin &&
                dot(normal, second.start - first.start) < -tolerance_ * length(normal))
                normal = -normal;
            return made(time, at_time(first, time), normal, first, second);
        };
        Impact impact;
        Found found;
        const auto is_within = [&](const Impact& at) {
            return is_inner(at.u, first_.points[from], first_.points[to]) &&
                   is_inner(at.v, second_.points[begin], second_.points[end]);
        };
        const auto come_first = [&](const Impact& at, Vec3d normal) {
            return is_foremost_edge(first_, around_[0], from, to, at.time, normal, skin_) &&
                   is_foremost_edge(second_, around_[1], begin, end, at.time, -normal, skin_);
        };
        if (!meets(
                begins_in_skin, [&](Impact& at) { return find(first_, second_, at); },
                [&](Impact& at) {
                    return find(inner_first_, inner_second_, at) &&
                           come_first(at, describe(at).normal);
                },
                describe,
                [&](const Impact& at, Vec3d normal) {
                    return is_within(at) && come_first(at, normal);
                },
                impact, found))
            return;
        found.meeting.edges = true;
        found.meeting.vertex = from;
        found.meeting.edge_end = to;
        found.meeting.triangle = u;
        found.is_within = !found.is_in_skin && is_within(impact);
        note(found);
    }

    /// True if a height times the length of its normal says that features are as near as the skin
    /// when they begin.
    bool is_within_skin(double height, Vec3d normal) const {
        return !(std::fabs(height) > 2 * skin_ * length(normal));
    }

    /// A meeting, and what decides which of several counts.
    struct Found {
        FirstMeeting meeting;
        bool is_within = false;   ///< not at the end of an edge
        bool is_in_skin = false;  ///< found further inside, of places without a gap
    };

    /// True if two features meet. Where they have no gap as they begin, they may touch there and
    /// only slide along each other, or part and meet elsewhere; where an edge ends, as a corner
    /// that slides over the diagonal of a side has it, the normal is not one of the surface. They
    /// meet then if they do so a skin further inside, where what slides is apart.
    template <class Find, class FindInside, class Describe, class HasNormal>
    bool meets(bool begins_in_skin, const Find& find, const FindInside& find_inside,
               const Describe& describe, const HasNormal& has_normal, Impact& impact,
               Found& found) const {
        if (find(impact)) {
            found.meeting = describe(impact);
            if (found.meeting.gap > tolerance_ && has_normal(impact, found.meeting.normal))
                return true;
        } else if (!begins_in_skin) {
            return false;
        }
        found.is_in_skin = true;
        if (!find_inside(impact)) return false;
        found.meeting = describe(impact);
        return true;
    }

    /// `first`, `second`: the places that meet. `normal` leads from the first surface to the
    /// second. Places that begin on its other side leave each other: they have no gap.
    FirstMeeting made(double time, Vec3d place, Vec3d normal, const MovingPoint& first,
                      const MovingPoint& second) const {
        const Vec3d apart = second.start - first.start;
        // Parallel edges and faces without area have no normal: the way they come is one.
        normal = normalized(length_squared(normal) > 0 ? normal : apart);
        FirstMeeting meeting;
        meeting.time = time;
        meeting.place = place;
        meeting.normal = normal;
        meeting.gap = max_of(dot(normal, apart), 0.0);
        meeting.start[0] = first.start;
        meeting.start[1] = second.start;
        return meeting;
    }

    /// Keeps what comes first. Of meetings at the same time, one between the ends of edges or
    /// corners of faces counts more: only it has a normal of its own.
    void note(const Found& found) {
        const double time = found.meeting.time, best = best_.meeting.time,
                     same = found.is_in_skin || best_.is_in_skin ? same_time_in_skin_ : same_time_;
        earliest_ = std::min(earliest_, time);
        const bool is_first = !is_found_ || time < best - same ||
                              (time <= best + same && found.is_within && !best_.is_within);
        if (!is_first) return;
        is_found_ = true;
        best_ = found;
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
    MovingSurface inner_first_, inner_second_;
    std::vector<std::uint8_t> own_first_, own_second_;
    VertexCorners around_[2];
    std::vector<Vec3d> normals_[2];
    Found best_;
    std::map<std::pair<bool, std::uint32_t>, FirstMeeting> of_vertices_;  ///< of the second surface
                                                                          ///< or not; its vertex
    bool is_found_ = false;
    double earliest_ = 1, tolerance_ = 0, skin_ = 0, same_time_ = 0, same_time_in_skin_ = 0;
};

}  // namespace

double touch_at_start(const MovingSurface& first, const MovingSurface& second) {
    const auto box_of = [](const MovingSurface& surface) {
        Box box;
        for (const MovingPoint& p : surface.points) box.extend(p.start);
        return box;
    };
    const Box a = box_of(first), b = box_of(second);
    const double apart = length(a.center() - b.center());
    const auto reach = [&](const Box& source, const Box& target) {
        return std::min(target.extent(), source.extent() + apart);
    };
    return constants::touch_tolerance * std::max(reach(a, b), reach(b, a));
}

std::vector<FirstMeeting> first_meetings(const MovingSurface& first, const MovingSurface& second,
                                         std::uint32_t most) {
    return Search(first, second).run(most);
}

}  // namespace pierce
