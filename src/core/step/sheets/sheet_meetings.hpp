#pragma once

#include <initializer_list>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/geometry/continuous.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/sheets/piercing_edge.hpp"
#include "core/step/sheets/sheet_judgement.hpp"
#include "core/step/sheets/sheet_memory.hpp"
#include "core/trace/closest_search.hpp"
#include "pierce/contact.hpp"
#include "pierce/min_max.hpp"

/// Sheets, third part: which of the features found are contacts, and on which side.
///
/// A sheet has no inside: what counts is where a vertex comes from. Its side of a triangle is the
/// side that is remembered; otherwise the side from which it meets the triangle; otherwise the side
/// it was on when the step began. Motion is relative to the triangle: layers that move together do
/// not meet. A contact pushes the vertex to its side, also when the vertex is through. The side of
/// a solid is always its outside.
namespace pierce::stages {

/// Per two features: whether they are a contact, and how. Reads the memory of the last step. It
/// runs twice. The first run takes all features and does not search for the time of a meeting: a
/// direction that separates them settles nearly all, and the others are listed as undecided. The
/// second run searches, for the undecided ones. The search needs so much of a GPU's registers that
/// few threads could run with it.
template <bool searching>
struct MeetFeatures {
    SheetBodies bodies;
    View<const Pair> pairs;
    View<const SheetPair> sheet_pairs;
    View<const FeaturePair> features;
    View<const std::uint32_t> undecided;  ///< if searching: the features to judge
    SheetMemory memory;
    View<SheetMeeting> meetings;
    View<Judgement> judgements;

    PIERCE_HD void operator()(std::uint32_t item) const { judge(undecided[item]); }

    /// Without searching: true if they are undecided.
    PIERCE_HD bool find(std::uint32_t i) const { return judge(i).verdict == Verdict::undecided; }
    PIERCE_HD static std::uint32_t count(bool is_undecided) { return is_undecided; }
    PIERCE_HD void write(std::uint32_t i, bool is_undecided, std::uint32_t place,
                         std::uint32_t* list) const {
        if (is_undecided) list[place] = i;
    }

private:
    PIERCE_HD Judgement judge(std::uint32_t i) const {
        const FeaturePair f = read_whole(features[i]);
        const SheetPair pair = read_whole(sheet_pairs[f.pair]);
        // Vertices are read side by side, whatever the features are; the bodies' places are not
        // looked up again.
        MovingPoint p[4];
        for (int k = 0; k < 4; ++k) p[k] = bodies.vertex(f.vertex[k]);
        SheetMeeting m;
        Judgement judgement;
        if (f.kind == FeatureKind::vertex_of_a || f.kind == FeatureKind::vertex_of_b)
            judgement = vertex_and_triangle(f, pair, p, m);
        else if (f.kind == FeatureKind::edges)
            judgement = two_edges(f, pair, p, m);
        else
            judgement = piercing(f, pair, m);
        judgements[i] = judgement;
        // Features that are no contact are written, too: threads that write together all write.
        if constexpr (searching)
            write_whole(meetings[i], m);
        else
            write_side_by_side(meetings.data, i, [&](SheetMeeting& to) { to = m; });
        return judgement;
    }

    /// The body of a feature's vertex or edge; target() is the body of its triangle.
    PIERCE_HD SheetBody holder(const FeaturePair& f) const {
        return bodies[pairs[f.pair].source(side_of(f.kind))];
    }
    PIERCE_HD SheetBody target(const FeaturePair& f) const {
        return bodies[pairs[f.pair].target(side_of(f.kind))];
    }
    PIERCE_HD static std::uint32_t side_of(FeatureKind kind) {
        return kind == FeatureKind::vertex_of_b || kind == FeatureKind::piercing_edge_of_b;
    }

    /// The first of some directions that has a length, as a unit vector. If none has, any
    /// direction, and the way out is unknown.
    PIERCE_HD static Vec3d way_out(Judgement& judgement, std::initializer_list<Vec3d> directions) {
        for (const Vec3d& d : directions)
            if (const Vec3d unit = normalized(d); length_squared(unit) > 0) return unit;
        judgement.unknown = true;
        return {1, 0, 0};
    }

    PIERCE_HD static MovingPoint relative(const MovingPoint& p, Vec3d origin) {
        return {p.start - origin, p.end - origin};
    }

    PIERCE_HD Judgement vertex_and_triangle(const FeaturePair& f, const SheetPair& pair,
                                            const MovingPoint (&point)[4], SheetMeeting& m) const {
        const Vec3d origin = point[1].end;
        const MovingTriangle face(point[1], point[2], point[3], origin);
        const MovingPoint p = relative(point[0], origin);
        const Vec3d normal = normalized(face.end_normal());
        const double height = dot(normal, p.end - face.corner[0].end);
        const bool above = weights_over(face.corner[0].end, face.corner[1].end, face.corner[2].end,
                                        p.end, m.weight);

        const bool close = above && std::fabs(height) < pair.margin;
        const bool changes = (dot(face.start_normal(), p.start - face.corner[0].start) < 0) !=
                             (height < 0);
        Impact impact;
        bool met = false;
        if constexpr (searching)
            met = vertex_meets_face(p, face.corner[0], face.corner[1], face.corner[2], impact);
        else if ((close && changes) ||
                 (!f.separate &&
                  !vertex_surely_misses_face(p, face.corner[0], face.corner[1], face.corner[2])))
            return {Verdict::undecided};
        if (!met && !close) return {};
        // Reading the memory takes longer than all the rest, so it is read only where it matters.
        const std::int32_t remembered = pair.was_through ? memory.side(f, target(f).mesh.triangles)
                                                         : 0;
        bool is_known = true;
        std::int32_t its_side = side(f, face, p, height, remembered, met, impact, is_known);
        // A vertex inside a solid is pushed out along a ray. But a vertex that leaves the solid
        // here and still ends behind the triangle, or on it, has come in again, and may have
        // slipped around the triangle's border before. One that ends outside may be near.
        if (pair.is_solid[1 - side_of(f.kind)] && its_side < 0) {
            if (height > rounding_of(face, p))
                met = false;
            else if (!met || remembered != 0)
                return {};
            its_side = 1;
        }

        const double gap = its_side * height;
        const bool through = above && remembered != 0 && gap < 0 && -gap < pair.margin;
        const bool near = above && std::fabs(height) < pair.thickness &&
                          gap < proximity_of_vertex(f, pair);
        if (!met && !near && !through) return {};
        Judgement judgement{Verdict::contact,
                            met       ? Found::crossing
                            : through ? Found::remembered
                                      : Found::near,
                            static_cast<std::int8_t>(its_side)};
        m.out = static_cast<double>(its_side) * normal;
        m.distance = gap;
        if (!above) {
            // The vertex meets the triangle and goes on beside it: the contact is at the place it
            // has met.
            m.weight[0] = 1 - impact.u - impact.v;
            m.weight[1] = impact.u;
            Vec3d at, start;
            for (int k = 0; k < 3; ++k) {
                at += m.weight_of(k) * face.corner[k].end;
                start += m.weight_of(k) * face.corner[k].start;
            }
            // A triangle that has lost its area has no side any more.
            if (length_squared(m.out) == 0)
                m.out = way_out(judgement, {static_cast<double>(its_side) * face.start_normal(),
                                            p.start - start, p.end - at});
            m.distance = dot(m.out, p.end - at);
        }
        if (met) m.time = impact.time;
        // Of a vertex that touches, only a side that it has come from is remembered.
        if (!is_known && !(m.distance < 0)) judgement.side = 0;
        return judgement;
    }

    /// How far from the face `p` ends [length], if it touches the face but for rounding.
    PIERCE_HD static double rounding_of(const MovingTriangle& face, const MovingPoint& p) {
        double size = max_of(length(p.start), length(p.end));
        for (const MovingPoint& corner : face.corner)
            size = max_of(max_of(length(corner.start), length(corner.end)), size);
        return constants::meeting_tolerance * size;
    }

    /// Weights of the first two corners at the foot of `p`; true if the foot lies in the triangle.
    PIERCE_HD static bool weights_over(Vec3d a, Vec3d b, Vec3d c, Vec3d p, double (&weight)[2]) {
        const Vec3d n = cross(b - a, c - a);
        const double size = length_squared(n);
        if (!(size > 0)) return false;
        weight[0] = dot(n, cross(c - b, p - b)) / size;
        weight[1] = dot(n, cross(a - c, p - c)) / size;
        return weight[0] >= 0 && weight[1] >= 0 && 1 - weight[0] - weight[1] >= 0;
    }

    /// The side of the triangle that the vertex belongs to. It is not known of a vertex that lies
    /// on the triangle and does not move.
    PIERCE_HD std::int32_t side(const FeaturePair& f, const MovingTriangle& face,
                                const MovingPoint& p, double height, std::int32_t remembered,
                                bool met, const Impact& impact, bool& is_known) const {
        if (remembered != 0) return remembered;
        const Vec3d n = face.start_normal(), from_corner = p.start - face.corner[0].start;
        const double before = dot(n, from_corner);
        if (met) {
            const double weight[3] = {1 - impact.u - impact.v, impact.u, impact.v};
            Vec3d motion = p.end - p.start;
            double way = length(motion);
            for (int k = 0; k < 3; ++k) {
                const Vec3d of_corner = face.corner[k].end - face.corner[k].start;
                motion -= weight[k] * of_corner;
                way += length(of_corner);
            }
            Vec3d c[3];
            for (int k = 0; k < 3; ++k)
                c[k] = face.corner[k].start +
                       impact.time * (face.corner[k].end - face.corner[k].start);
            // A vertex that rests on the triangle, or moves with it, comes from neither side: a
            // sign that is only rounding is no answer.
            const Vec3d then = cross(c[1] - c[0], c[2] - c[0]);
            const double approach = dot(then, motion);
            if (std::fabs(approach) > constants::motion_rounding * length(then) * way)
                return approach < 0 ? 1 : -1;
            const double rounding = constants::motion_rounding * length(n) * length(from_corner);
            is_known = std::fabs(before) > rounding;
            return before < -rounding ? -1 : 1;
        }
        if ((before < 0) == (height < 0)) return height < 0 ? -1 : 1;
        // The vertex has changed sides without meeting this triangle: through one that shares a
        // corner with it, or around the border.
        bool through = false;
        if constexpr (searching) through = meets_neighbor(f, p);
        return (through ? before : height) < 0 ? -1 : 1;
    }

    PIERCE_HD bool meets_neighbor(const FeaturePair& f, const MovingPoint& p) const {
        const SheetBody of_face = target(f);
        const MeshView& mesh = of_face.mesh;
        const Triangle& own = mesh.triangles[f.other];
        const Vec3d origin = of_face.vertex(own.vertex[0]).end;
        const bool is_self = sheet_pairs[f.pair].is_self();
        for (std::uint32_t v : own.vertex)
            for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i) {
                const Corner& c = mesh.corners[i];
                const Triangle other{{v, c.next, c.previous}};
                if ((has_vertex(own, c.next) && has_vertex(own, c.previous)) ||
                    (is_self && has_vertex(other, f.item)))
                    continue;
                const MovingTriangle face(of_face.vertex(v), of_face.vertex(c.next),
                                          of_face.vertex(c.previous), origin);
                Impact impact;
                if (vertex_meets_face(p, face.corner[0], face.corner[1], face.corner[2], impact))
                    return true;
            }
        return false;
    }

    /// The distance that counts as near: the thickness; for a body against itself, at most half of
    /// the distance of the two features at rest.
    PIERCE_HD double proximity_of_vertex(const FeaturePair& f, const SheetPair& pair) const {
        if (!pair.is_self()) return pair.thickness;
        Vec3d rest[4];
        at_rest(f, pair, rest);
        return min_of(
            pair.thickness,
            0.5 * length(rest[0] - closest_on_triangle(rest[0], rest[1], rest[2], rest[3])));
    }
    PIERCE_HD double proximity_of_edges(const FeaturePair& f, const SheetPair& pair) const {
        if (!pair.is_self()) return pair.thickness;
        Vec3d rest[4];
        at_rest(f, pair, rest);
        return min_of(pair.thickness, 0.5 * segment_distance(rest[0], rest[1], rest[2], rest[3]));
    }
    PIERCE_HD void at_rest(const FeaturePair& f, const SheetPair& pair, Vec3d (&rest)[4]) const {
        const View<const Vec3f> positions = bodies.views[pair.first].mesh.positions;
        const std::uint32_t offset = bodies.vertex_offsets[pair.first];
        for (int k = 0; k < 4; ++k) rest[k] = to_double(positions[f.vertex[k] - offset]);
    }

    PIERCE_HD Judgement two_edges(const FeaturePair& f, const SheetPair& pair,
                                  const MovingPoint (&point)[4], SheetMeeting& m) const {
        const Vec3d origin = point[0].end;
        const MovingPoint p = relative(point[0], origin), q = relative(point[1], origin),
                          r = relative(point[2], origin), s = relative(point[3], origin);
        const SegmentPlaces at = closest_points_of_segments(p.end, q.end, r.end, s.end);
        const bool between = at.first > 0 && at.first < 1 && at.second > 0 && at.second < 1;
        Vec3d way = p.end + at.first * (q.end - p.end) - r.end - at.second * (s.end - r.end);
        m.distance = length(way);

        Impact impact;
        bool met = false;
        if constexpr (searching)
            met = edges_meet(p, q, r, s, impact);
        else if (!f.separate && !edges_surely_miss(p, q, r, s))
            return {Verdict::undecided};
        if (!met) {
            if (!between || !(m.distance > 0) || !(m.distance < proximity_of_edges(f, pair)))
                return {};
            m.out = {way.x / m.distance, way.y / m.distance, way.z / m.distance};
            set_places(m, at.first, at.second);
            return {Verdict::contact, Found::near};
        }
        // The side from which the edges meet; it stays their side while they turn.
        const auto when = [&](const MovingPoint& x) {
            return x.start + impact.time * (x.end - x.start);
        };
        const Vec3d u = when(q) - when(p), v = when(s) - when(r);
        const Vec3d motion = (1 - impact.u) * (p.end - p.start) + impact.u * (q.end - q.start) -
                             (1 - impact.v) * (r.end - r.start) - impact.v * (s.end - s.start);
        const Vec3d n = cross(u, v), end = cross(q.end - p.end, s.end - r.end);
        const double flat = constants::meeting_tolerance * length(u) * length(v);
        const bool turned = dot(n, motion) > 0;
        Judgement judgement{Verdict::contact, Found::crossing};
        // Edges that touched when the step began meet at once, wherever they go.
        const std::int32_t remembered = pair.was_through && !(impact.time > 0)
                                            ? memory.side_of_edges(f)
                                            : 0;
        if (remembered != 0 && length(end) > flat)
            m.out = static_cast<double>(remembered) * normalized(end);
        else if (length(n) > flat && length(end) > flat && dot(n, motion) != 0)
            m.out = normalized(turned ? -end : end);
        else
            m.out = way_out(judgement, {-motion, way});
        const double first_place = between ? at.first : impact.u,
                     second_place = between ? at.second : impact.v;
        way = p.end + first_place * (q.end - p.end) - r.end - second_place * (s.end - r.end);
        m.distance = dot(m.out, way);
        if (m.distance == 0 && length(end) > flat) judgement.side = dot(m.out, end) > 0 ? 1 : -1;
        set_places(m, first_place, second_place);
        m.time = impact.time;
        return judgement;
    }

    PIERCE_HD static void set_places(SheetMeeting& m, double first, double second) {
        m.along = first;
        m.weight[0] = second;
    }

    /// An edge that has been through a triangle since before the step began: it is a contact only
    /// if the way it came is unknown. Moving the edge along the gradient of the contour's length
    /// separates the two (Volino and Magnenat-Thalmann 2006).
    PIERCE_HD Judgement piercing(const FeaturePair& f, const SheetPair& pair,
                                 SheetMeeting& m) const {
        const std::uint32_t side_of_edge = side_of(f.kind);
        if (pair.is_solid[1 - side_of_edge]) return {};
        const SheetBody of_edge = holder(f), of_face = target(f);
        const View<const Triangle> triangles = of_face.mesh.triangles;
        const Edge& e = of_edge.mesh.edges[f.item];
        // A border that is inside the solid is found by rays and chords.
        if (pair.is_solid[side_of_edge] && crosses_border(of_edge, e, of_face, f.other)) return {};
        const FeatureKind vertices = side_of_edge == 0 || pair.is_self() ? FeatureKind::vertex_of_a
                                                                         : FeatureKind::vertex_of_b;
        for (std::uint32_t v : e.vertex)
            if (pair.was_through && memory.knows(f.pair, vertices, v, f.other, triangles))
                return {};
        const Triangle& t = triangles[f.other];
        const Vec3d a = of_face.vertex(t.vertex[0]).end, b = of_face.vertex(t.vertex[1]).end - a,
                    c = of_face.vertex(t.vertex[2]).end - a;
        const Vec3d p = of_edge.vertex(e.vertex[0]).end - a,
                    q = of_edge.vertex(e.vertex[1]).end - a;
        // `pierces` has seen different signs at the two ends. The normal is not made a unit vector
        // here, so that the signs are the same as there.
        const Vec3d across = cross(b, c), normal = normalized(across);
        const double from = dot(across, p), to = dot(across, q);
        m.along = from / (from - to);
        const Vec3d at = p + m.along * (q - p);
        // Both relative to the first corner: a far one does not take part in the other's weight.
        const double area = length_squared(across);
        m.weight[1] = dot(across, cross(at, c)) / area;
        m.weight[0] = 1 - m.weight[1] - dot(across, cross(b, at)) / area;
        const Vec3d along = normalized(q - p);
        const Vec3d gradient = contour_gradient(of_edge, e, a, at, along, normal);
        const double size = length(gradient);
        const bool unknown = !(size > constants::vanishing_normal) ||
                             !(size < 1 / constants::vanishing_normal);
        m.out = unknown ? normal : normalized(gradient);
        return {
            .verdict = Verdict::contact, .found = Found::tangled, .side = 0, .unknown = unknown};
    }
};

}  // namespace pierce::stages
