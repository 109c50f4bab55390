#include "scenes/measure/sheet_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/geometry/closest_place_on_triangle.hpp"
#include "core/geometry/closest_points_of_segments.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"

namespace pierce::scenes {
namespace {

double share(std::uint64_t part, std::uint64_t all) {
    return all == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(all);
}

FeatureMeeting features_of(const Contact& c) {
    const std::uint32_t source = c.source_body().index, target = c.target_body().index;
    if (c.is_edge())
        return {.edges = true, .a = source, .item = c.edge, .b = target, .other = c.other_edge};
    return {.edges = false, .a = source, .item = c.vertex, .b = target, .other = c.triangle};
}

double distance(const std::array<Vec3d, 4>& p, bool edges) {
    if (edges) {
        const SegmentPlaces s = closest_points_of_segments(p[0], p[1], p[2], p[3]);
        return length(p[0] + s.first * (p[1] - p[0]) - p[2] - s.second * (p[3] - p[2]));
    }
    const TrianglePlace t = closest_place_on_triangle(p[0], p[1], p[2], p[3]);
    return length(p[0] - p[1] - t.second * (p[2] - p[1]) - t.third * (p[3] - p[1]));
}

}  // namespace

double SheetAccuracy::recall() const { return share(meetings() - missed(), meetings()); }

double SheetAccuracy::precision() const { return share(crossings - wrong, crossings); }

SheetAccuracy& SheetAccuracy::operator+=(const SheetAccuracy& other) {
    for (const auto member :
         {&SheetAccuracy::vertex_meetings, &SheetAccuracy::missed_vertex_meetings,
          &SheetAccuracy::edge_meetings, &SheetAccuracy::missed_edge_meetings,
          &SheetAccuracy::vertices, &SheetAccuracy::missed_vertices, &SheetAccuracy::leaving,
          &SheetAccuracy::crossings, &SheetAccuracy::near, &SheetAccuracy::wrong})
        this->*member += other.*member;
    return *this;
}

SheetJudge::SheetJudge(const Recording& recording) : recording_(recording) {
    for (std::uint32_t m = 0; m < recording.meshes.size(); ++m)
        meshes_.emplace_back(recording.meshes[m].name, recording.meshes[m].data,
                             MeshOptions{.inside = inside_of(recording, m)});
}

bool SheetJudge::is_solid(std::uint32_t body, std::uint32_t frame) const {
    return meshes_[recording_.mesh_of(body, frame)].inside().exists() &&
           !recording_.bodies[body].collision.sheet;
}

/// Where a vertex is in a frame, of the mesh of a later frame `to`.
Vec3d SheetJudge::place(std::uint32_t body, std::uint32_t vertex, std::uint32_t frame,
                        std::uint32_t to) const {
    const RecordedBody& b = recording_.bodies[body];
    if (b.motion == Motion::deforming)
        return to_double(recording_.start_positions(body, frame, to)[vertex]);
    return frame_of(recording_.pose(body, frame))
        .to_parent(to_double(recording_.meshes[b.mesh].data.positions[vertex]));
}

/// The corners of both features at a time of the step that leads to `frame`.
SheetJudge::Corners SheetJudge::corners(const FeatureMeeting& m, std::uint32_t frame,
                                        double time) const {
    const auto at = [&](std::uint32_t body, std::uint32_t vertex) {
        const Vec3d start = place(body, vertex, frame - 1, frame);
        return start + time * (place(body, vertex, frame, frame) - start);
    };
    const MeshView of_a = meshes_[recording_.mesh_of(m.a, frame)].view({}),
                   of_b = meshes_[recording_.mesh_of(m.b, frame)].view({});
    if (m.edges) {
        const Edge &e = of_a.edges[m.item], &f = of_b.edges[m.other];
        return {at(m.a, e.vertex[0]), at(m.a, e.vertex[1]), at(m.b, f.vertex[0]),
                at(m.b, f.vertex[1])};
    }
    const Triangle& t = of_b.triangles[m.other];
    return {at(m.a, m.item), at(m.b, t.vertex[0]), at(m.b, t.vertex[1]), at(m.b, t.vertex[2])};
}

/// True if at that time the two features are close enough to count as a meeting
/// (constants::meeting_tolerance).
bool SheetJudge::is_near(const FeatureMeeting& m, std::uint32_t frame, double time) const {
    double size = 0, coordinate = 0;
    for (const double end : {0.0, 1.0}) {
        const Corners p = corners(m, frame, end);
        for (const Vec3d& corner : p)
            for (int k = 0; k < 3; ++k) {
                size = std::max(size, std::fabs(corner[k] - p[0][k]));
                coordinate = std::max(coordinate, std::fabs(corner[k]));
            }
    }
    const double rounding = constants::motion_rounding * coordinate;
    return distance(corners(m, frame, time), m.edges) <=
           constants::meeting_tolerance * size + rounding;
}

/// True if a vertex is on different sides of the triangle when the step begins and when it ends.
bool SheetJudge::goes_through(const FeatureMeeting& m, std::uint32_t frame) const {
    const auto height = [&](double time) {
        const Corners p = corners(m, frame, time);
        return dot(cross(p[2] - p[1], p[3] - p[1]), p[0] - p[1]);
    };
    const double before = height(0), after = height(1);
    return (before < 0 && after > 0) || (before > 0 && after < 0);
}

/// True if a vertex is behind a solid's triangle when the step begins.
bool SheetJudge::leaves(const FeatureMeeting& m, std::uint32_t frame) const {
    if (m.edges || !is_solid(m.b, frame)) return false;
    const Corners p = corners(m, frame, 0);
    return dot(cross(p[2] - p[1], p[3] - p[1]), p[0] - p[1]) < 0;
}

SheetAccuracy SheetJudge::judge(const TrueSheetFrame& truth, std::span<const Contact> contacts,
                                SheetPairs pairs) const {
    using Vertex = std::pair<std::uint32_t, std::uint32_t>;
    SheetAccuracy result;
    std::set<FeatureMeeting> found;
    std::set<Vertex> touched;
    for (const Contact& c : contacts) {
        const FeatureMeeting m = features_of(c);
        if (!c.of_sheet || c.found == Found::tangled || m.is_self() != (pairs == SheetPairs::self))
            continue;
        found.insert(m);
        if (!m.edges) touched.emplace(m.a, m.item);
        if (c.found != Found::crossing) continue;
        ++result.crossings;
        if (std::ranges::binary_search(truth.meetings, m)) continue;
        ++(is_near(m, truth.frame, c.time) ? result.near : result.wrong);
    }
    std::set<Vertex> passing;
    for (const FeatureMeeting& m : truth.meetings) {
        if (m.is_self() != (pairs == SheetPairs::self)) continue;
        const bool missed = !found.contains(m);
        if (missed && leaves(m, truth.frame)) {
            ++result.leaving;
            continue;
        }
        ++(m.edges ? result.edge_meetings : result.vertex_meetings);
        if (missed) ++(m.edges ? result.missed_edge_meetings : result.missed_vertex_meetings);
        if (!m.edges && goes_through(m, truth.frame)) passing.emplace(m.a, m.item);
    }
    result.vertices = passing.size();
    for (const Vertex& v : passing) result.missed_vertices += !touched.contains(v);
    return result;
}

}  // namespace pierce::scenes
