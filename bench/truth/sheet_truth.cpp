#include "truth/sheet_truth.hpp"
#include "core/mesh/mesh_view.hpp"

#include <CGAL/Bbox_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace pierce::truth {
namespace {

/// A feature of a body.
struct Item {
    std::uint32_t body = 0, index = 0;
};

using FeatureBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, Item>;

bool is_usable(const Pose& pose) {
    const Quaternion& q = pose.rotation;
    const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return is_finite(pose.position) && std::isfinite(norm) && norm > 0;
}

/// True if a segment crosses a triangle's inside; no orientation of four of the five points may be
/// zero.
bool pierces(Vec3d from, Vec3d to, const std::array<Vec3d, 3>& corners) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    const auto point = [](Vec3d v) { return Kernel::Point_3(v.x, v.y, v.z); };
    const Kernel::Point_3 p = point(from), q = point(to), a = point(corners[0]),
                          b = point(corners[1]), c = point(corners[2]);
    const CGAL::Orientation side = CGAL::orientation(a, b, c, p);
    if (side == CGAL::COPLANAR || CGAL::orientation(a, b, c, q) != -side) return false;
    const CGAL::Orientation turn = CGAL::orientation(p, q, a, b);
    return turn != CGAL::COPLANAR && CGAL::orientation(p, q, b, c) == turn &&
           CGAL::orientation(p, q, c, a) == turn;
}

bool share_vertex(const Edge& e, const Edge& f) {
    return e.vertex[0] == f.vertex[0] || e.vertex[0] == f.vertex[1] || e.vertex[1] == f.vertex[0] ||
           e.vertex[1] == f.vertex[1];
}

}  // namespace

/// A body during a step: vertices that move in straight lines.
struct SheetTruth::Placed {
    const MeshView* mesh = nullptr;  ///< null: left out
    std::uint32_t number = 0;        ///< of the mesh in the recording
    std::vector<MovingPoint> points;

    template <class Vertices>
    FeatureBox box(Item item, const Vertices& vertices) const {
        CGAL::Bbox_3 all;
        for (std::uint32_t v : vertices)
            for (const Vec3d& p : {points[v].start, points[v].end})
                all += CGAL::Bbox_3(p.x, p.y, p.z, p.x, p.y, p.z);
        return {all, item};
    }
};

SheetTruth::SheetTruth(const scenes::Recording& recording)
    : recording_(recording), rules_(recording) {
    for (std::uint32_t m = 0; m < recording.meshes.size(); ++m)
        meshes_.emplace_back(recording.meshes[m].name, recording.meshes[m].data,
                             MeshOptions{.inside = inside_of(recording, m)});
    for (const Mesh& mesh : meshes_) {
        views_.push_back(mesh.view());
        std::set<std::uint32_t> used;
        for (const Triangle& t : mesh.triangles())
            used.insert(std::begin(t.vertex), std::end(t.vertex));
        used_.emplace_back(used.begin(), used.end());
    }
}

bool SheetTruth::are_looked_at(std::uint32_t a, std::uint32_t b) const {
    const Collision &first = recording_.bodies[a].collision,
                    &second = recording_.bodies[b].collision;
    return a == b ? first.sheet && first.self != SelfCollision::off
                  : (first.sheet || second.sheet) && rules_.allow(a, b);
}

std::vector<SheetTruth::Placed> SheetTruth::placed(std::uint32_t from, std::uint32_t to) const {
    std::vector<Placed> bodies(recording_.bodies.size());
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        const scenes::RecordedBody& body = recording_.bodies[b];
        Placed& result = bodies[b];
        if (body.motion == Motion::deforming) {
            const std::span<const Vec3f> start = recording_.start_positions(b, from, to),
                                         end = recording_.positions(b, to);
            const auto finite = [](Vec3f p) { return is_finite(p); };
            if (!std::ranges::all_of(start, finite) || !std::ranges::all_of(end, finite)) continue;
            for (std::size_t v = 0; v < end.size(); ++v)
                result.points.push_back({to_double(start[v]), to_double(end[v])});
        } else {
            const Pose start = recording_.pose(b, from), end = recording_.pose(b, to);
            if (!is_usable(start) || !is_usable(end)) continue;
            const Frame before = frame_of(start), after = frame_of(end);
            for (Vec3f p : recording_.meshes[body.mesh].data.positions)
                result.points.push_back(
                    {before.to_parent(to_double(p)), after.to_parent(to_double(p))});
        }
        result.number = recording_.mesh_of(b, to);
        result.mesh = &views_[result.number];
    }
    return bodies;
}

std::vector<SheetMeeting> SheetTruth::meetings(std::uint32_t frame, MeetingCounts* counts) const {
    std::vector<SheetMeeting> found;
    if (frame == 0) return found;
    const std::vector<Placed> bodies = placed(frame - 1, frame);
    std::vector<FeatureBox> vertices, triangles, edges;
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        if (bodies[b].mesh == nullptr) continue;
        const MeshView& mesh = *bodies[b].mesh;
        for (std::uint32_t v : used_[bodies[b].number])
            vertices.push_back(bodies[b].box({b, v}, std::array{v}));
        for (std::uint32_t t = 0; t < mesh.triangles.size; ++t)
            triangles.push_back(bodies[b].box({b, t}, mesh.triangles[t].vertex));
        for (std::uint32_t e = 0; e < mesh.edges.size; ++e)
            edges.push_back(bodies[b].box({b, e}, mesh.edges[e].vertex));
    }
    CGAL::box_intersection_d(vertices.begin(), vertices.end(), triangles.begin(), triangles.end(),
                             [&](const auto& x, const auto& y) {
                                 const auto [a, v] = x.info();
                                 const auto [b, t] = y.info();
                                 if (!are_looked_at(a, b)) return;
                                 const Triangle& face = bodies[b].mesh->triangles[t];
                                 if (a == b && has_vertex(face, v)) return;
                                 const std::vector<MovingPoint>& q = bodies[b].points;
                                 if (features_meet(Features::vertex_and_face,
                                                   {bodies[a].points[v], q[face.vertex[0]],
                                                    q[face.vertex[1]], q[face.vertex[2]]},
                                                   counts))
                                     found.push_back({Features::vertex_and_face, a, v, b, t});
                             });
    CGAL::box_self_intersection_d(edges.begin(), edges.end(), [&](const auto& x, const auto& y) {
        Item first = x.info(), second = y.info();
        if (std::pair(second.body, second.index) < std::pair(first.body, first.index))
            std::swap(first, second);
        if (!are_looked_at(first.body, second.body)) return;
        const Placed &a = bodies[first.body], &b = bodies[second.body];
        const Edge &e = a.mesh->edges[first.index], &f = b.mesh->edges[second.index];
        if (first.body == second.body && share_vertex(e, f)) return;
        if (features_meet(Features::edges,
                          {a.points[e.vertex[0]], a.points[e.vertex[1]], b.points[f.vertex[0]],
                           b.points[f.vertex[1]]},
                          counts))
            found.push_back({Features::edges, first.body, first.index, second.body, second.index});
    });
    std::ranges::sort(found);
    return found;
}

std::vector<Piercing> SheetTruth::piercings(std::uint32_t frame) const {
    const std::vector<Placed> bodies = placed(frame, frame);
    std::vector<FeatureBox> triangles, edges;
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        if (bodies[b].mesh == nullptr) continue;
        const MeshView& mesh = *bodies[b].mesh;
        for (std::uint32_t t = 0; t < mesh.triangles.size; ++t)
            triangles.push_back(bodies[b].box({b, t}, mesh.triangles[t].vertex));
        for (std::uint32_t e = 0; e < mesh.edges.size; ++e)
            edges.push_back(bodies[b].box({b, e}, mesh.edges[e].vertex));
    }
    std::vector<Piercing> found;
    CGAL::box_intersection_d(
        edges.begin(), edges.end(), triangles.begin(), triangles.end(),
        [&](const auto& x, const auto& y) {
            const auto [a, e] = x.info();
            const auto [b, t] = y.info();
            if (!are_looked_at(a, b)) return;
            const Edge& edge = bodies[a].mesh->edges[e];
            const Triangle& face = bodies[b].mesh->triangles[t];
            if (a == b && (has_vertex(face, edge.vertex[0]) || has_vertex(face, edge.vertex[1])))
                return;
            const Vec3d p = bodies[a].points[edge.vertex[0]].end,
                        q = bodies[a].points[edge.vertex[1]].end;
            std::array<Vec3d, 3> c;
            for (std::size_t k = 0; k < 3; ++k) c[k] = bodies[b].points[face.vertex[k]].end;
            if (!pierces(p, q, c)) return;
            const Vec3d n = normalized(cross(c[1] - c[0], c[2] - c[0]));
            found.push_back(
                {a, e, b, t, std::min(std::fabs(dot(n, p - c[0])), std::fabs(dot(n, q - c[0])))});
        });
    std::ranges::sort(found, {},
                      [](const Piercing& p) { return std::tuple(p.a, p.edge, p.b, p.triangle); });
    return found;
}

}  // namespace pierce::truth
