#pragma once

#include <limits>

#include "pierce/core/stages/sheet_search.hpp"

/// Sheets, second part: which vertices and triangles, and which edges, of two triangles may meet or come close.
namespace pierce::stages {

/// A point during the step, float32, relative to some place near it.
struct QuickPoint {
    Vec3f start, end;
};

/// What is known of how two features, or two triangles, get along.
struct Company {
    bool separate = false;  ///< they do not meet during the step
    bool distant = false;   ///< at its end they are no contact, unless they have met: too far apart, or not over each other

    PIERCE_HD bool is_settled() const { return separate && distant; }
    PIERCE_HD void learn(const Company& more) {
        separate |= more.separate;
        distant |= more.distant;
    }
};

/// How far some points reach along a direction, at the start of the step and at its end.
struct Reach {
    float low[2], high[2];

    template <int count>
    PIERCE_HD Reach(Vec3f n, const QuickPoint (&points)[count]) {
        for (int k = 0; k < count; ++k) {
            const float at[2] = {dot(n, points[k].start), dot(n, points[k].end)};
            for (int when = 0; when < 2; ++when) {
                low[when] = k == 0 ? at[when] : quick_min(at[when], low[when]);
                high[when] = k == 0 ? at[when] : quick_max(at[when], high[when]);
            }
        }
    }
};

/// How much of what is said along `n` float32 may have made up. `size`: no coordinate is larger.
PIERCE_HD inline float made_up_along(Vec3f n, float size) {
    return constants::quick_rounding * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z)) * size;
}

/// True if something `ahead` along `n`, of any length, is further away than `margin`. Roots take long.
PIERCE_HD inline bool is_beyond(float margin, float ahead, Vec3f n) {
    return ahead > 0 && ahead * ahead > margin * margin * dot(n, n);
}

/// What `n`, of any length, says about two convex things: differences of corners are linear in time, so that one stays ahead
/// if it is ahead at the start and at the end.
template <int mine, int others>
PIERCE_HD Company company_along(Vec3f n, const QuickPoint (&a)[mine], const QuickPoint (&b)[others], float margin,
                                float size) {
    const Reach of_a(n, a), of_b(n, b);
    const float made_up = made_up_along(n, size);
    const float ahead = of_a.low[1] - of_b.high[1], behind = of_b.low[1] - of_a.high[1];
    return {quick_max(quick_min(of_a.low[0] - of_b.high[0], ahead), quick_min(of_b.low[0] - of_a.high[0], behind)) > made_up,
            is_beyond(margin, quick_max(ahead, behind) - made_up, n)};
}

/// A triangle during the step, float32, relative to `origin`.
struct QuickTriangle {
    QuickPoint corner[3];

    QuickTriangle() = default;
    PIERCE_HD QuickTriangle(const SheetBody& body, const Triangle& t, Vec3f origin) {
        for (int k = 0; k < 3; ++k) {
            const MovingVertex v = read_whole(body.vertices[t.vertex[k]]);
            corner[k] = {v.start - origin, v.end - origin};
        }
    }
    PIERCE_HD Vec3f start_normal() const {
        return cross(corner[1].start - corner[0].start, corner[2].start - corner[0].start);
    }
    PIERCE_HD Vec3f end_normal() const { return cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end); }
    /// No coordinate is larger at the start of the step, or at its end.
    PIERCE_HD float start_size() const {
        float size = 0;
        for (const QuickPoint& p : corner)
            for (int axis = 0; axis < 3; ++axis) size = quick_max(std::fabs(p.start[axis]), size);
        return size;
    }
    PIERCE_HD float end_size() const {
        float size = 0;
        for (const QuickPoint& p : corner)
            for (int axis = 0; axis < 3; ++axis) size = quick_max(std::fabs(p.end[axis]), size);
        return size;
    }
    /// A corner without an index that only the running thread knows: such arrays do not stay in registers.
    PIERCE_HD QuickPoint pick(std::uint32_t k) const { return k == 0 ? corner[0] : k == 1 ? corner[1] : corner[2]; }
};

/// How much of a product of four lengths float32 may have made up. Let u be half an ulp and no coordinate be above `size`.
/// Differences of coordinates are below 2 size and off by 4 u size; their cross product is below 8 size^2 and off by 48 u
/// size^2; that with another difference is below 32 size^3 and off by 320 u size^3; and the dot product with one more is
/// off by 2600 u size^4. Infinite where such products would come near the smallest float32.
PIERCE_HD inline float made_up_of_four(float size) {
    return size > constants::quick_smallest ? constants::quick_product_rounding * (size * size) * (size * size)
                                            : std::numeric_limits<float>::infinity();
}

/// The space over and under a triangle at the end of the step, as far as `margin` [length].
struct QuickPrism {
    Vec3f at[3], normal, inward[3];
    float margin = 0, made_up = 0, made_up_along_normal = 0;

    PIERCE_HD QuickPrism(const QuickTriangle& t, float reach, float size) : normal(t.end_normal()), margin(reach) {
        for (int k = 0; k < 3; ++k) {
            at[k] = t.corner[k].end;
            inward[k] = cross(normal, t.corner[k == 2 ? 0 : k + 1].end - at[k]);
        }
        made_up = made_up_of_four(size);
        made_up_along_normal = made_up_along(normal, size);
    }

    /// False if a point is outside for certain.
    PIERCE_HD bool may_hold(Vec3f p) const {
        return !(dot(inward[0], p - at[0]) < -made_up) && !(dot(inward[1], p - at[1]) < -made_up) &&
               !(dot(inward[2], p - at[2]) < -made_up) &&
               !is_beyond(margin, std::fabs(dot(normal, p - at[0])) - made_up_along_normal, normal);
    }
};

/// False if the points of two segments where their lines are closest are not within both for certain, or for certain
/// further apart than `margin` [length].
PIERCE_HD inline bool may_cross_over(Vec3f p, Vec3f q, Vec3f r, Vec3f s, float margin, float size) {
    const Vec3f d = q - p, e = s - r, n = cross(d, e), way = r - p;
    const float made_up = made_up_of_four(size);
    // The place along the first, times |n|^2, is way . (e x n); one less if `way` comes from the second end. The place along
    // the second is way . (d x n).
    const Vec3f beside_e = cross(e, n), beside_d = cross(d, n);
    return !(dot(way, beside_e) < -made_up) && !(dot(r - q, beside_e) > made_up) && !(dot(way, beside_d) < -made_up) &&
           !(dot(s - p, beside_d) > made_up) && !is_beyond(margin, std::fabs(dot(n, way)) - made_up_along(n, size), n);
}

/// What two features are.
enum class FeatureKind : std::uint8_t {
    vertex_of_a,         ///< a vertex of the pair's a, and a triangle of its b
    vertex_of_b,         ///< the other way round
    edges,               ///< an edge of a and an edge of b
    piercing_edge_of_a,  ///< an edge of a through a triangle of b, at the start of the step and at its end
    piercing_edge_of_b,
};

/// Two features that may meet or come close during the step.
struct alignas(16) FeaturePair {
    std::uint32_t pair = 0;
    std::uint32_t item = 0;   ///< the vertex, or the edge of a, or the one that pierces
    std::uint32_t other = 0;  ///< the triangle, or the edge of b
    FeatureKind kind = FeatureKind::vertex_of_a;
    bool separate = false;  ///< it is known that they do not meet
    std::uint8_t padding[2] = {};
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

/// The features of two triangles that may meet or come close, a bit each. Of corners and edges that two triangles share,
/// only those their own (TriangleFeatures::own).
struct FeatureBits {
    static constexpr std::uint32_t vertex_of_first = 0, vertex_of_second = 3;  ///< three each
    static constexpr std::uint32_t edges = 6;  ///< nine: three for each edge of the first, one for each of the second's
    static constexpr std::uint32_t piercing_first = 15, piercing_second = 18;  ///< three each
    static constexpr std::uint32_t all = (1u << 21) - 1;
    static constexpr std::uint32_t open = 1u << 30;      ///< nothing is known yet
    static constexpr std::uint32_t separate = 1u << 31;  ///< the triangles do not meet
};

/// Two triangles, ready to have their features looked at.
struct QuickPair {
    SheetBody a, b;
    const Triangle &ta, &tb;
    std::uint32_t own_a, own_b;
    QuickTriangle qa, qb;
    float thickness, margin, end_size, size;

    PIERCE_HD QuickPair(const SheetBodies& bodies, const SheetPair& pair, const TrianglePair& t)
        : a(bodies[pair.first]),
          b(bodies[pair.second]),
          ta(a.mesh.triangles[t.first]),
          tb(b.mesh.triangles[t.second]),
          own_a(a.mesh.features[t.first].own),
          own_b(b.mesh.features[t.second].own),
          qa(a, ta, a.vertices[ta.vertex[0]].end),
          qb(b, tb, a.vertices[ta.vertex[0]].end),
          thickness(round_up(pair.thickness)),
          margin(round_up(pair.margin)),
          end_size(quick_max(qa.end_size(), qb.end_size())),
          size(quick_max(end_size, quick_max(qa.start_size(), qb.start_size()))) {}
};

/// Per pair of triangles: which of their features may be contacts, and their number, if a direction separates the triangles
/// as wholes, as it does nearly always; otherwise that it is open.
struct MaskFeatures {
    SheetBodies bodies;
    View<const SheetPair> pairs;
    View<const TrianglePair> triangles;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const TrianglePair t = read_whole(triangles[i]);
        masks[i] = mask(QuickPair(bodies, pairs[t.pair], t));
        counts[i] = bit_count(masks[i] & FeatureBits::all);
    }

private:
    PIERCE_HD static std::uint32_t mask(const QuickPair& p) {
        Company company = company_along(p.qb.end_normal(), p.qa.corner, p.qb.corner, p.margin, p.size);
        if (!company.is_settled())
            company.learn(company_along(p.qa.end_normal(), p.qa.corner, p.qb.corner, p.margin, p.size));
        if (company.is_settled()) return 0;
        if (!company.separate) return FeatureBits::open;

        const QuickPrism over_a(p.qa, p.margin, p.end_size), over_b(p.qb, p.margin, p.end_size);
        std::uint32_t bits = 0;
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (p.own_a >> k & 1 && over_b.may_hold(p.qa.corner[k].end)) bits |= 1u << (FeatureBits::vertex_of_first + k);
            if (p.own_b >> k & 1 && over_a.may_hold(p.qb.corner[k].end)) bits |= 1u << (FeatureBits::vertex_of_second + k);
        }
        for (std::uint32_t k = 0; k < 3; ++k)
            for (std::uint32_t l = 0; l < 3; ++l)
                if (p.own_a >> (3 + k) & 1 && p.own_b >> (3 + l) & 1 &&
                    may_cross_over(p.qa.corner[k].end, p.qa.corner[k == 2 ? 0 : k + 1].end, p.qb.corner[l].end,
                                   p.qb.corner[l == 2 ? 0 : l + 1].end, p.thickness, p.end_size))
                    bits |= 1u << (FeatureBits::edges + 3 * k + l);
        return bits == 0 ? 0 : bits | FeatureBits::separate;
    }
};

/// True for pairs of triangles that are still open.
struct IsOpen {
    View<const std::uint32_t> masks;

    PIERCE_HD bool operator()(std::uint32_t i) const { return masks[i] == FeatureBits::open; }
};

/// Per pair of triangles that is open: which of their features may meet or come close, and their number.
struct MaskOpenFeatures {
    SheetBodies bodies;
    View<const SheetPair> pairs;
    View<const TrianglePair> triangles;
    View<const std::uint32_t> open;
    View<std::uint32_t> masks, counts;  ///< of all pairs of triangles

    PIERCE_HD void operator()(std::uint32_t i) const {
        const TrianglePair t = read_whole(triangles[open[i]]);
        const SheetPair& pair = pairs[t.pair];
        const QuickPair p(bodies, pair, t);
        std::uint32_t bits = 0;
        for (std::uint32_t k = 0; k < 3; ++k) bits |= mask(p, k, pair.first == pair.second);
        masks[open[i]] = bits;
        counts[open[i]] = bit_count(bits);
    }

private:
    /// Of corner k, and edge k, of each of them, and the other triangle's features.
    PIERCE_HD static std::uint32_t mask(const QuickPair& p, std::uint32_t k, bool self) {
        const std::uint32_t next = k == 2 ? 0 : k + 1;
        const QuickPoint corner_a = p.qa.pick(k), corner_b = p.qb.pick(k), after_a = p.qa.pick(next),
                         after_b = p.qb.pick(next);
        std::uint32_t bits = 0;
        if (p.own_a >> k & 1 && !(self && has_vertex(p.tb, p.ta.vertex[k])) && may_touch(corner_a, p.qb, p))
            bits |= 1u << (FeatureBits::vertex_of_first + k);
        if (p.own_b >> k & 1 && !(self && has_vertex(p.ta, p.tb.vertex[k])) && may_touch(corner_b, p.qa, p))
            bits |= 1u << (FeatureBits::vertex_of_second + k);
        if (p.own_a >> (3 + k) & 1) {
            const std::uint32_t v = p.ta.vertex[k], w = p.ta.vertex[next];
            const QuickPoint mine[2] = {corner_a, after_a};
            for (std::uint32_t l = 0; l < 3; ++l) {
                if (!(p.own_b >> (3 + l) & 1)) continue;
                const std::uint32_t after = l == 2 ? 0 : l + 1, x = p.tb.vertex[l], y = p.tb.vertex[after];
                if (self && (v == x || v == y || w == x || w == y)) continue;
                const QuickPoint others[2] = {p.qb.pick(l), p.qb.pick(after)};
                if (may_touch(mine, others, p)) bits |= 1u << (FeatureBits::edges + 3 * k + l);
            }
            if (!(self && (has_vertex(p.tb, v) || has_vertex(p.tb, w))) &&
                may_pierce(corner_a.end, after_a.end, p.qb, p.end_size) && stays_pierced(p.a, v, w, p.b, p.tb))
                bits |= 1u << (FeatureBits::piercing_first + k);
        }
        if (p.own_b >> (3 + k) & 1 && !(self && (has_vertex(p.ta, p.tb.vertex[k]) || has_vertex(p.ta, p.tb.vertex[next]))) &&
            may_pierce(corner_b.end, after_b.end, p.qa, p.end_size) &&
            stays_pierced(p.b, p.tb.vertex[k], p.tb.vertex[next], p.a, p.ta))
            bits |= 1u << (FeatureBits::piercing_second + k);
        return bits;
    }

    PIERCE_HD static bool may_touch(const QuickPoint& corner, const QuickTriangle& face, const QuickPair& p) {
        const QuickPoint point[1] = {corner};
        const Vec3f directions[5] = {face.end_normal(), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, face.start_normal()};
        Company company;
        company.distant = !QuickPrism(face, p.margin, p.end_size).may_hold(corner.end);
        for (int k = 0; k < 5 && !company.is_settled(); ++k)
            company.learn(company_along(directions[k], point, face.corner, p.margin, p.size));
        return !company.is_settled();
    }

    PIERCE_HD static bool may_touch(const QuickPoint (&a)[2], const QuickPoint (&b)[2], const QuickPair& p) {
        const Vec3f directions[5] = {cross(a[1].end - a[0].end, b[1].end - b[0].end),
                                     {1, 0, 0},
                                     {0, 1, 0},
                                     {0, 0, 1},
                                     cross(a[1].start - a[0].start, b[1].start - b[0].start)};
        Company company;
        company.distant = !may_cross_over(a[0].end, a[1].end, b[0].end, b[1].end, p.thickness, p.end_size);
        for (int k = 0; k < 5 && !company.is_settled(); ++k)
            company.learn(company_along(directions[k], a, b, p.thickness, p.size));
        return !company.is_settled();
    }

    /// False if both ends are on one side of the triangle's plane for certain.
    PIERCE_HD static bool may_pierce(Vec3f p, Vec3f q, const QuickTriangle& face, float size) {
        const Vec3f n = face.end_normal();
        const float room = made_up_along(n, size);
        const float from = dot(n, p - face.corner[0].end), to = dot(n, q - face.corner[0].end);
        return !(from > room && to > room) && !(from < -room && to < -room);
    }

    PIERCE_HD static bool stays_pierced(const SheetBody& of_edge, std::uint32_t v, std::uint32_t w, const SheetBody& of_face,
                                        const Triangle& t) {
        const MovingPoint a = of_face.vertex(t.vertex[0]), b = of_face.vertex(t.vertex[1]), c = of_face.vertex(t.vertex[2]),
                          p = of_edge.vertex(v), q = of_edge.vertex(w);
        return pierces(p.end - a.end, q.end - a.end, {}, b.end - a.end, c.end - a.end) &&
               pierces(p.start - a.start, q.start - a.start, {}, b.start - a.start, c.start - a.start);
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
        std::uint32_t place = offsets[i];
        for (std::uint32_t mask = masks[i] & FeatureBits::all; mask != 0; mask &= mask - 1) {
            const TrianglePair t = read_whole(triangles[i]);
            FeaturePair f = feature(t, pairs[t.pair], lowest_bit(mask));
            f.separate = (masks[i] & FeatureBits::separate) != 0;
            write_whole(features[place++], f);
        }
    }

private:
    PIERCE_HD FeaturePair feature(const TrianglePair& t, const SheetPair& pair, std::uint32_t bit) const {
        const MeshView &first = bodies[pair.first].mesh, &second = bodies[pair.second].mesh;
        // In a body itself, which of the two it is matters to nobody.
        const bool self = pair.first == pair.second;
        if (bit < FeatureBits::vertex_of_second)
            return {t.pair, first.triangles[t.first].vertex[bit], t.second, FeatureKind::vertex_of_a};
        if (bit < FeatureBits::edges)
            return {t.pair, second.triangles[t.second].vertex[bit - FeatureBits::vertex_of_second], t.first,
                    self ? FeatureKind::vertex_of_a : FeatureKind::vertex_of_b};
        if (bit >= FeatureBits::piercing_second)
            return {t.pair, second.features[t.second].edge[bit - FeatureBits::piercing_second], t.first,
                    self ? FeatureKind::piercing_edge_of_a : FeatureKind::piercing_edge_of_b};
        if (bit >= FeatureBits::piercing_first)
            return {t.pair, first.features[t.first].edge[bit - FeatureBits::piercing_first], t.second,
                    FeatureKind::piercing_edge_of_a};
        const std::uint32_t e = first.features[t.first].edge[(bit - FeatureBits::edges) / 3],
                            f = second.features[t.second].edge[(bit - FeatureBits::edges) % 3];
        // The smaller one first where both are of one body: the same two are always the same.
        const bool turn = self && f < e;
        return {t.pair, turn ? f : e, turn ? e : f, FeatureKind::edges};
    }
};

}  // namespace pierce::stages
