#pragma once

#include "pierce/core/stages/sheet_search.hpp"

/// Sheets, second part: which vertices and triangles, and which edges, of two triangles may meet or come close.
namespace pierce::stages {

/// A point during the step, float32, relative to some place near it.
struct QuickPoint {
    Vec3f start, end;
};

/// How two features get along during the step.
enum class Company : std::uint32_t {
    open,      ///< nothing is known
    separate,  ///< they do not meet
    distant,   ///< nor do they come near
};

/// How far apart along `n`, of any length, two convex features stay, one always ahead: differences of corners are linear in
/// time, so they do if they do at the start and at the end. In float32, with constants::quick_rounding to be sure. `size`:
/// no coordinate is larger.
template <int mine, int others>
PIERCE_HD Company company_along(Vec3f n, const QuickPoint (&a)[mine], const QuickPoint (&b)[others], float margin,
                                float size) {
    float low_a[2], high_a[2], low_b[2], high_b[2];  // at the start and at the end
    for (int k = 0; k < mine; ++k) {
        const float at[2] = {dot(n, a[k].start), dot(n, a[k].end)};
        for (int when = 0; when < 2; ++when) {
            low_a[when] = k == 0 ? at[when] : min_of(at[when], low_a[when]);
            high_a[when] = k == 0 ? at[when] : max_of(at[when], high_a[when]);
        }
    }
    for (int k = 0; k < others; ++k) {
        const float at[2] = {dot(n, b[k].start), dot(n, b[k].end)};
        for (int when = 0; when < 2; ++when) {
            low_b[when] = k == 0 ? at[when] : min_of(at[when], low_b[when]);
            high_b[when] = k == 0 ? at[when] : max_of(at[when], high_b[when]);
        }
    }
    const float gap =
        max_of(min_of(low_a[0] - high_b[0], low_a[1] - high_b[1]), min_of(low_b[0] - high_a[0], low_b[1] - high_a[1])) -
        constants::quick_rounding * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z)) * size;
    return gap > margin * length(n) ? Company::distant : gap > 0 ? Company::separate : Company::open;
}

/// The same along the coordinate axes: the best of them.
template <int mine, int others>
PIERCE_HD Company company_along_axes(const QuickPoint (&a)[mine], const QuickPoint (&b)[others], float margin, float size) {
    Company best = company_along(Vec3f{1, 0, 0}, a, b, margin, size);
    if (best != Company::distant) best = max_of(company_along(Vec3f{0, 1, 0}, a, b, margin, size), best);
    if (best != Company::distant) best = max_of(company_along(Vec3f{0, 0, 1}, a, b, margin, size), best);
    return best;
}

/// A triangle during the step, float32, relative to `origin`.
struct QuickTriangle {
    QuickPoint corner[3];
    float size = 0;  ///< no coordinate is larger

    PIERCE_HD QuickTriangle(const BodyView& body, std::uint32_t triangle, Vec3d origin) {
        const MovingTriangle t(body, triangle, origin);
        for (int k = 0; k < 3; ++k) {
            corner[k] = {to_float(t.corner[k].start), to_float(t.corner[k].end)};
            for (int axis = 0; axis < 3; ++axis)
                size = max_of(max_of(std::fabs(corner[k].start[axis]), std::fabs(corner[k].end[axis])), size);
        }
    }
    PIERCE_HD Vec3f start_normal() const {
        return cross(corner[1].start - corner[0].start, corner[2].start - corner[0].start);
    }
    PIERCE_HD Vec3f end_normal() const { return cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end); }
};

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
    bool separate = false;    ///< it is known that they do not meet
    std::uint8_t padding[3] = {};
};

/// True if a segment runs through a triangle, from one side to the other. Strictly: touching is not piercing.
PIERCE_HD inline bool pierces(Vec3d p, Vec3d q, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d n = cross(b - a, c - a);
    const double from = dot(n, p - a), to = dot(n, q - a);
    if (!((from > 0 && to < 0) || (from < 0 && to > 0))) return false;
    const Vec3d d = q - p;
    const double u = dot(d, cross(a - p, b - p)), v = dot(d, cross(b - p, c - p)), w = dot(d, cross(c - p, a - p));
    return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

/// What an item of two triangles looks at: corner k, and edge k, of each of them, and how they get along with the other
/// triangle's features. A bit each for a test that is not settled by distance, in the order of FeatureBits; sixteen places
/// further up, one if it is known that the two do not meet.
struct FeatureBits {
    static constexpr std::uint32_t vertex_of_first = 0, vertex_of_second = 1;
    static constexpr std::uint32_t edges = 2;  ///< three: edge k of the first with each of the second's
    static constexpr std::uint32_t piercing_first = 5, piercing_second = 6;
    static constexpr std::uint32_t all = 0x7f, separate_shift = 16;
};

/// Per pair of triangles and corner: which of their own features may meet or come close, and their number.
struct MaskFeatures {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const TrianglePair> triangles;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const TrianglePair& t = triangles[i / 3];
        masks[i] = mask(t, pairs[t.pair], i % 3);
        counts[i] = bit_count(masks[i] & FeatureBits::all);
    }

private:
    PIERCE_HD std::uint32_t mask(const TrianglePair& t, const SheetPair& pair, std::uint32_t k) const {
        const BodyView &a = bodies[pair.first], &b = bodies[pair.second];
        const std::uint32_t own_a = a.mesh.features[t.first].own, own_b = b.mesh.features[t.second].own;
        if (!((own_a | own_b) >> k & 1) && !((own_a | own_b) >> (3 + k) & 1)) return 0;
        const Triangle &ta = a.mesh.triangles[t.first], &tb = b.mesh.triangles[t.second];
        const std::uint32_t next = k == 2 ? 0 : k + 1;
        const Vec3d origin = moving_vertex(a, ta.vertex[0]).end;
        const QuickTriangle qa(a, t.first, origin), qb(b, t.second, origin);
        const float size = max_of(qa.size, qb.size), thickness = round_up(pair.thickness), margin = round_up(pair.margin);
        const bool self = pair.first == pair.second;
        std::uint32_t bits = 0;
        const auto note = [&](std::uint32_t bit, Company company) {
            if (company == Company::distant) return;
            bits |= 1u << bit;
            if (company == Company::separate) bits |= 1u << (bit + FeatureBits::separate_shift);
        };
        const QuickPoint corner_a = pick(qa, k), corner_b = pick(qb, k), after_a = pick(qa, next), after_b = pick(qb, next);
        if (own_a >> k & 1 && !(self && has_vertex(tb, ta.vertex[k])))
            note(FeatureBits::vertex_of_first, company(corner_a, qb, margin, size));
        if (own_b >> k & 1 && !(self && has_vertex(ta, tb.vertex[k])))
            note(FeatureBits::vertex_of_second, company(corner_b, qa, margin, size));
        if (own_a >> (3 + k) & 1) {
            const std::uint32_t p = ta.vertex[k], q = ta.vertex[next];
            const QuickPoint mine[2] = {corner_a, after_a};
            for (std::uint32_t l = 0; l < 3; ++l) {
                if (!(own_b >> (3 + l) & 1)) continue;
                const std::uint32_t r = tb.vertex[l], s = tb.vertex[l == 2 ? 0 : l + 1];
                if (self && (p == r || p == s || q == r || q == s)) continue;
                const QuickPoint others[2] = {pick(qb, l), pick(qb, l == 2 ? 0 : l + 1)};
                note(FeatureBits::edges + l, company(mine, others, thickness, size));
            }
            if (!(self && (has_vertex(tb, p) || has_vertex(tb, q))) && may_pierce(corner_a.end, after_a.end, qb, size) &&
                stays_pierced(a, p, q, b, tb))
                bits |= 1u << FeatureBits::piercing_first;
        }
        if (own_b >> (3 + k) & 1 && !(self && (has_vertex(ta, tb.vertex[k]) || has_vertex(ta, tb.vertex[next]))) &&
            may_pierce(corner_b.end, after_b.end, qa, size) && stays_pierced(b, tb.vertex[k], tb.vertex[next], a, ta))
            bits |= 1u << FeatureBits::piercing_second;
        return bits;
    }

    /// A corner without an index that only the running thread knows: such arrays do not stay in registers.
    PIERCE_HD static QuickPoint pick(const QuickTriangle& t, std::uint32_t k) {
        return k == 0 ? t.corner[0] : k == 1 ? t.corner[1] : t.corner[2];
    }

    PIERCE_HD static Company company(const QuickPoint& p, const QuickTriangle& face, float margin, float size) {
        const QuickPoint point[1] = {p};
        Company best = company_along(face.end_normal(), point, face.corner, margin, size);
        if (best != Company::distant) best = max_of(company_along_axes(point, face.corner, margin, size), best);
        if (best != Company::distant)
            best = max_of(company_along(face.start_normal(), point, face.corner, margin, size), best);
        return best;
    }

    PIERCE_HD static Company company(const QuickPoint (&a)[2], const QuickPoint (&b)[2], float margin, float size) {
        Company best = company_along(cross(a[1].end - a[0].end, b[1].end - b[0].end), a, b, margin, size);
        if (best != Company::distant) best = max_of(company_along_axes(a, b, margin, size), best);
        if (best != Company::distant)
            best = max_of(company_along(cross(a[1].start - a[0].start, b[1].start - b[0].start), a, b, margin, size), best);
        return best;
    }

    /// False if both ends are on one side of the triangle's plane for certain.
    PIERCE_HD static bool may_pierce(Vec3f p, Vec3f q, const QuickTriangle& face, float size) {
        const Vec3f n = face.end_normal();
        const float room = constants::quick_rounding * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z)) * size;
        const float from = dot(n, p - face.corner[0].end), to = dot(n, q - face.corner[0].end);
        return !(from > room && to > room) && !(from < -room && to < -room);
    }

    PIERCE_HD static bool stays_pierced(const BodyView& of_edge, std::uint32_t v, std::uint32_t w, const BodyView& of_face,
                                        const Triangle& t) {
        const MovingPoint a = moving_vertex(of_face, t.vertex[0]), b = moving_vertex(of_face, t.vertex[1]),
                          c = moving_vertex(of_face, t.vertex[2]), p = moving_vertex(of_edge, v),
                          q = moving_vertex(of_edge, w);
        return pierces(p.end - a.end, q.end - a.end, {}, b.end - a.end, c.end - a.end) &&
               pierces(p.start - a.start, q.start - a.start, {}, b.start - a.start, c.start - a.start);
    }
};

/// Per pair of triangles and corner: lists the features of its mask.
struct ListFeatures {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const TrianglePair> triangles;
    View<const std::uint32_t> masks, offsets;
    View<FeaturePair> features;

    PIERCE_HD void operator()(std::uint32_t i) const {
        std::uint32_t place = offsets[i];
        for (std::uint32_t mask = masks[i] & FeatureBits::all; mask != 0; mask &= mask - 1) {
            const TrianglePair& t = triangles[i / 3];
            const std::uint32_t bit = lowest_bit(mask);
            FeaturePair f = feature(t, pairs[t.pair], i % 3, bit);
            f.separate = masks[i] >> (bit + FeatureBits::separate_shift) & 1;
            features[place++] = f;
        }
    }

private:
    PIERCE_HD FeaturePair feature(const TrianglePair& t, const SheetPair& pair, std::uint32_t k, std::uint32_t bit) const {
        const MeshView &first = bodies[pair.first].mesh, &second = bodies[pair.second].mesh;
        const bool self = pair.first == pair.second;
        // In a body itself, which of the two it is matters to nobody.
        if (bit == FeatureBits::vertex_of_first)
            return {t.pair, FeatureKind::vertex_of_a, first.triangles[t.first].vertex[k], t.second};
        if (bit == FeatureBits::vertex_of_second)
            return {t.pair, self ? FeatureKind::vertex_of_a : FeatureKind::vertex_of_b, second.triangles[t.second].vertex[k],
                    t.first};
        if (bit == FeatureBits::piercing_first)
            return {t.pair, FeatureKind::piercing_edge_of_a, first.features[t.first].edge[k], t.second};
        if (bit == FeatureBits::piercing_second)
            return {t.pair, self ? FeatureKind::piercing_edge_of_a : FeatureKind::piercing_edge_of_b,
                    second.features[t.second].edge[k], t.first};
        const std::uint32_t e = first.features[t.first].edge[k],
                            f = second.features[t.second].edge[bit - FeatureBits::edges];
        // The smaller one first where both are of one body: the same two are always the same.
        const bool turn = self && f < e;
        return {t.pair, FeatureKind::edges, turn ? f : e, turn ? e : f};
    }
};

}  // namespace pierce::stages
