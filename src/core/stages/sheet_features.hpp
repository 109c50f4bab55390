#pragma once

#include "pierce/core/stages/sheet_search.hpp"

/// Sheets, second part: which vertices and triangles, and which edges, of two triangles may meet or come close.
namespace pierce::stages {

/// What two features are.
enum class FeatureKind : std::uint32_t {
    vertex_of_a,         ///< a vertex of the pair's a, and a triangle of its b
    vertex_of_b,         ///< the other way round
    edges,               ///< an edge of a and an edge of b
    piercing_edge_of_a,  ///< an edge of a through a triangle of b, at the start of the step and at its end
    piercing_edge_of_b,
};

/// Two features that may meet or come close during the step.
struct FeaturePair {
    std::uint32_t pair = 0;
    FeatureKind kind = FeatureKind::vertex_of_a;
    std::uint32_t item = 0;   ///< the vertex, or the edge of a, or the one that pierces
    std::uint32_t other = 0;  ///< the triangle, or the edge of b
};

/// Bits of a feature mask.
inline constexpr std::uint32_t first_faces = 3, first_edges = 6, first_piercing = 15, feature_bits = 21;

/// True if a segment runs through a triangle, from one side to the other. Strictly: touching is not piercing.
PIERCE_HD inline bool pierces(Vec3d p, Vec3d q, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d n = cross(b - a, c - a);
    const double from = dot(n, p - a), to = dot(n, q - a);
    if (!((from > 0 && to < 0) || (from < 0 && to > 0))) return false;
    const Vec3d d = q - p;
    const double u = dot(d, cross(a - p, b - p)), v = dot(d, cross(b - p, c - p)), w = dot(d, cross(c - p, a - p));
    return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

/// Per pair of triangles: a bit for each two of their own features that may meet or come close, and their number. Bits 0..2:
/// a vertex of the first and the second triangle; 3..5: a vertex of the second and the first triangle; 6..14: edges, three
/// of the second's for each of the first's; 15..17: an edge of the first through the second; 18..20: the other way round.
struct MaskFeatures {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const TrianglePair> triangles;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        masks[i] = mask(triangles[i], pairs[triangles[i].pair]);
        counts[i] = bit_count(masks[i]);
    }

private:
    PIERCE_HD std::uint32_t mask(const TrianglePair& t, const SheetPair& pair) const {
        const BodyView &a = bodies[pair.first], &b = bodies[pair.second];
        const Triangle &ta = a.mesh.triangles[t.first], &tb = b.mesh.triangles[t.second];
        const std::uint32_t own_a = a.mesh.features[t.first].own, own_b = b.mesh.features[t.second].own;
        const Vec3d origin = moving_vertex(a, ta.vertex[0]).end;
        const MovingTriangle ma(a, t.first, origin), mb(b, t.second, origin);
        const double size = max_of(ma.box().max_coordinate(), mb.box().max_coordinate());
        const bool self = pair.first == pair.second;
        std::uint32_t bits = 0;
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (own_a >> k & 1 && !(self && has_vertex(tb, ta.vertex[k])) && may_meet(ma.corner[k], mb, pair.margin, size))
                bits |= 1u << k;
            if (own_b >> k & 1 && !(self && has_vertex(ta, tb.vertex[k])) && may_meet(mb.corner[k], ma, pair.margin, size))
                bits |= 1u << (first_faces + k);
        }
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (!(own_a >> (3 + k) & 1)) continue;
            const MovingPoint mine[2] = {ma.corner[k], ma.corner[(k + 1) % 3]};
            const std::uint32_t p = ta.vertex[k], q = ta.vertex[(k + 1) % 3];
            for (std::uint32_t l = 0; l < 3; ++l) {
                if (!(own_b >> (3 + l) & 1)) continue;
                const std::uint32_t r = tb.vertex[l], s = tb.vertex[(l + 1) % 3];
                if (self && (p == r || p == s || q == r || q == s)) continue;
                const MovingPoint others[2] = {mb.corner[l], mb.corner[(l + 1) % 3]};
                if (edges_may_meet(mine, others, pair.thickness, size)) bits |= 1u << (first_edges + 3 * k + l);
            }
        }
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t next = (k + 1) % 3;
            if (own_a >> (3 + k) & 1 && !(self && (has_vertex(tb, ta.vertex[k]) || has_vertex(tb, ta.vertex[next]))) &&
                stays_pierced(ma.corner[k], ma.corner[next], mb))
                bits |= 1u << (first_piercing + k);
            if (own_b >> (3 + k) & 1 && !(self && (has_vertex(ta, tb.vertex[k]) || has_vertex(ta, tb.vertex[next]))) &&
                stays_pierced(mb.corner[k], mb.corner[next], ma))
                bits |= 1u << (first_piercing + 3 + k);
        }
        return bits;
    }

    PIERCE_HD static bool may_meet(const MovingPoint& p, const MovingTriangle& face, double margin, double size) {
        const MovingPoint point[1] = {p};
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d n;
            n[axis] = 1;
            if (stay_apart(n, point, face.corner, margin, size)) return false;
        }
        return !stay_apart(face.end_normal(), point, face.corner, margin, size) &&
               !stay_apart(face.start_normal(), point, face.corner, margin, size);
    }

    PIERCE_HD static bool edges_may_meet(const MovingPoint (&a)[2], const MovingPoint (&b)[2], double margin, double size) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d n;
            n[axis] = 1;
            if (stay_apart(n, a, b, margin, size)) return false;
        }
        return !stay_apart(cross(a[1].end - a[0].end, b[1].end - b[0].end), a, b, margin, size) &&
               !stay_apart(cross(a[1].start - a[0].start, b[1].start - b[0].start), a, b, margin, size);
    }

    PIERCE_HD static bool stays_pierced(const MovingPoint& p, const MovingPoint& q, const MovingTriangle& face) {
        const MovingPoint* c = face.corner;
        return pierces(p.end, q.end, c[0].end, c[1].end, c[2].end) &&
               pierces(p.start, q.start, c[0].start, c[1].start, c[2].start);
    }
};

/// Per pair of triangles: lists the features of its mask.
struct ListFeatures {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const TrianglePair> triangles;
    View<const std::uint32_t> masks, offsets;
    View<FeaturePair> features;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const TrianglePair& t = triangles[i];
        const SheetPair& pair = pairs[t.pair];
        std::uint32_t place = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1) {
            const std::uint32_t bit = lowest_bit(mask);
            features[place++] = feature(t, pair, bit);
        }
    }

private:
    PIERCE_HD FeaturePair feature(const TrianglePair& t, const SheetPair& pair, std::uint32_t bit) const {
        const MeshView &first = bodies[pair.first].mesh, &second = bodies[pair.second].mesh;
        // In a body itself, which of the two it is matters to nobody.
        const bool second_is_a = pair.first == pair.second;
        const auto of = [](bool a, FeatureKind kind_of_a) {
            return a ? kind_of_a : static_cast<FeatureKind>(static_cast<std::uint32_t>(kind_of_a) + 1);
        };
        if (bit < first_faces) return {t.pair, FeatureKind::vertex_of_a, first.triangles[t.first].vertex[bit], t.second};
        if (bit < first_edges)
            return {t.pair, of(second_is_a, FeatureKind::vertex_of_a), second.triangles[t.second].vertex[bit - first_faces],
                    t.first};
        if (bit < first_piercing) {
            const std::uint32_t k = (bit - first_edges) / 3, l = (bit - first_edges) % 3;
            const std::uint32_t e = first.features[t.first].edge[k], f = second.features[t.second].edge[l];
            // The smaller one first where both are of one body: the same two are always the same.
            const bool turn = second_is_a && f < e;
            return {t.pair, FeatureKind::edges, turn ? f : e, turn ? e : f};
        }
        const std::uint32_t k = bit - first_piercing;
        if (k < 3) return {t.pair, FeatureKind::piercing_edge_of_a, first.features[t.first].edge[k], t.second};
        return {t.pair, of(second_is_a, FeatureKind::piercing_edge_of_a), second.features[t.second].edge[k - 3], t.first};
    }
};

}  // namespace pierce::stages
