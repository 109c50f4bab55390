#pragma once

#include <limits>

#include "core/device/quick_math.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/sheets/quick_triangle.hpp"
#include "core/step/sheets/sheet_search.hpp"

/// Sheets, second part: which vertices and triangles, and which edges, of two triangles may meet or
/// come close.
namespace pierce::stages {

/// An upper bound of the error of float32 in a product of four lengths. Let u be half an ulp and no
/// coordinate be above `size`. Differences of coordinates are below 2 size and off by 4 u size;
/// their cross product is below 8 size^2 and off by 48 u size^2; the cross product of that with
/// another difference is below 32 size^3 and off by 320 u size^3; and the dot product with one more
/// difference is off by 2600 u size^4.
PIERCE_HD inline float made_up_of_four(float size) {
    return constants::quick_product_rounding * (size * size) * (size * size);
}

/// The space over and under a triangle at the end of the step, as far as `margin` [length].
struct QuickPrism {
    Vec3f at[3], normal, inward[3];
    float margin = 0, made_up = 0, made_up_along_normal = 0;

    PIERCE_HD QuickPrism(Vec3f a, Vec3f b, Vec3f c, float reach, float size)
        : at{a, b, c}, normal(quick_cross(b - a, c - a)), margin(reach) {
        for (int k = 0; k < 3; ++k) inward[k] = quick_cross(normal, at[k == 2 ? 0 : k + 1] - at[k]);
        made_up = made_up_of_four(size);
        made_up_along_normal = made_up_along(normal, size);
    }

    /// False if a point is outside for certain.
    PIERCE_HD bool may_hold(Vec3f p) const {
        return !(quick_dot(inward[0], p - at[0]) < -made_up) &&
               !(quick_dot(inward[1], p - at[1]) < -made_up) &&
               !(quick_dot(inward[2], p - at[2]) < -made_up) &&
               !is_beyond(margin, std::fabs(quick_dot(normal, p - at[0])) - made_up_along_normal,
                          normal);
    }
};

/// False if the closest points of two segments' lines are certainly not within both segments, or
/// certainly further apart than `margin` [length].
PIERCE_HD inline bool may_cross_over(Vec3f p, Vec3f q, Vec3f r, Vec3f s, float margin, float size) {
    const Vec3f d = q - p, e = s - r, n = quick_cross(d, e), way = r - p;
    const float made_up = made_up_of_four(size);
    // The place along the first, times |n|^2, is way . (e x n); one less if `way` comes from the
    // second end. The place along the second is way . (d x n).
    const Vec3f beside_e = quick_cross(e, n), beside_d = quick_cross(d, n);
    return !(quick_dot(way, beside_e) < -made_up) && !(quick_dot(r - q, beside_e) > made_up) &&
           !(quick_dot(way, beside_d) < -made_up) && !(quick_dot(s - p, beside_d) > made_up) &&
           !is_beyond(margin, std::fabs(quick_dot(n, way)) - made_up_along(n, size), n);
}

/// What two features are.
enum class FeatureKind : std::uint8_t {
    vertex_of_a,         ///< a vertex of the pair's a, and a triangle of its b
    vertex_of_b,         ///< the other way round
    edges,               ///< an edge of a and an edge of b
    piercing_edge_of_a,  ///< an edge of a through a triangle of b, at the start of the step and at
                         ///< its end
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
    /// Their vertices, by their places among those of all bodies. A vertex and a triangle: the
    /// vertex and the corners. Edges: the ends of both. Other kinds do not use them.
    std::uint32_t vertex[4] = {};
};

/// The key of a feature: sheets' contacts and records are sorted by it. Those of one feature are
/// then in any order (OrderTies). `bits`: as many as a feature's number has at most.
PIERCE_HD inline std::uint64_t feature_key(std::uint32_t pair, FeatureKind kind, std::uint32_t item,
                                           std::uint32_t bits) {
    return std::uint64_t{pair} << (bits + 3) | static_cast<std::uint64_t>(kind) << bits | item;
}
PIERCE_HD inline std::uint32_t pair_of(std::uint64_t key, std::uint32_t bits) {
    return static_cast<std::uint32_t>(key >> (bits + 3));
}
static_assert(constants::max_elements <= std::uint32_t{1} << 30);

/// True if a segment runs through a triangle, from one side to the other. Strictly: touching is not
/// piercing.
PIERCE_HD inline bool pierces(Vec3d p, Vec3d q, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d n = cross(b - a, c - a);
    const double from = dot(n, p - a), to = dot(n, q - a);
    if (!((from > 0 && to < 0) || (from < 0 && to > 0))) return false;
    const Vec3d d = q - p;
    const double u = dot(d, cross(a - p, b - p)), v = dot(d, cross(b - p, c - p)),
                 w = dot(d, cross(c - p, a - p));
    return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

/// The features of two triangles that may meet or come close, a bit each. Of its corners and edges,
/// which it shares with other triangles, each triangle counts only those it owns
/// (TriangleFeatures::own).
struct FeatureBits {
    static constexpr std::uint32_t vertex_of_first = 0, vertex_of_second = 3;  ///< three each
    static constexpr std::uint32_t edges = 6;  ///< four for each edge of the first: one for each
                                               ///< edge of the second, and an unused one
    static constexpr std::uint32_t piercing_first = 18, piercing_second = 21;  ///< three each
    static constexpr std::uint32_t count = 24, all = (1u << count) - 1;
    static constexpr std::uint32_t open = 1u << 30;      ///< nothing is known yet
    static constexpr std::uint32_t separate = 1u << 31;  ///< the triangles do not meet
};

/// Two triangles with features that may be contacts.
struct alignas(16) MeetingTriangles {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;  ///< as in TrianglePair
    std::uint32_t features = 0;           ///< FeatureBits
};

/// Two triangles, ready to have their features looked at.
struct QuickPair {
    PlacedTriangle a, b;
    QuickTriangle qa, qb;
    float thickness, margin, end_size, size;

    PIERCE_HD QuickPair(const PlacedTriangle& first, const PlacedTriangle& second,
                        const SheetPair& pair)
        : a(first),
          b(second),
          qa(a, a.end[0]),
          qb(b, a.end[0]),
          thickness(pair.quick_thickness),
          margin(pair.quick_margin),
          end_size(telling_size(quick_max(qa.end_size(), qb.end_size()))),
          size(telling_size(quick_max(end_size, quick_max(qa.start_size(), qb.start_size())))) {}
};

/// Per pair of triangles: which of their features may be contacts, if it is known that the
/// triangles do not meet, as is nearly always the case; otherwise the pair is open. Pairs without
/// such features are left out.
struct FindFeatures {
    View<const SheetPair> pairs;
    Interleaved<const DriftingTriangle> drifting;
    View<const TrianglePair> triangles;

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const TrianglePair t = read_whole(triangles[i]);
        return t.separate ? mask(drifting.read(t.first), drifting.read(t.second), pairs[t.pair])
                          : FeatureBits::open;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t bits) { return bits != 0; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t bits, std::uint32_t place,
                         MeetingTriangles* meeting) const {
        if (bits == 0) return;
        const TrianglePair t = read_whole(triangles[i]);
        write_whole(meeting[place], {t.pair, t.first, t.second, bits});
    }

private:
    /// The corners of two triangles at the end of the step, relative to one of them.
    struct Ends {
        Vec3f of_first[3], of_second[3];
        float size = 0;  ///< no coordinate is larger
    };

    PIERCE_HD static std::uint32_t mask(const DriftingTriangle& first,
                                        const DriftingTriangle& second, const SheetPair& pair) {
        Ends ends;
        for (int k = 0; k < 3; ++k) {
            ends.of_first[k] = first.corner[k].end - first.corner[0].end;
            ends.of_second[k] = second.corner[k].end - first.corner[0].end;
            ends.size = quick_max(largest_of(ends.of_first[k]),
                                  quick_max(largest_of(ends.of_second[k]), ends.size));
        }
        const float thickness = pair.quick_thickness, margin = pair.quick_margin;
        std::uint32_t
            bits = vertices_over(ends.of_first, first.own, ends.of_second, margin, ends.size)
                       << FeatureBits::vertex_of_first |
                   vertices_over(ends.of_second, second.own, ends.of_first, margin, ends.size)
                       << FeatureBits::vertex_of_second;
        for (std::uint32_t left = edge_pairs(first.own, second.own); left != 0; left &= left - 1) {
            const std::uint32_t both = lowest_bit(left), k = both / 4, l = both % 4;
            if (may_cross_over(pick(ends.of_first, k), pick(ends.of_first, after(k)),
                               pick(ends.of_second, l), pick(ends.of_second, after(l)), thickness,
                               ends.size))
                bits |= 1u << (FeatureBits::edges + both);
        }
        return bits == 0 ? 0 : bits | FeatureBits::separate;
    }

    /// A bit for each own corner of one that may be over the other triangle: a loop over the own
    /// corners is shorter than one over all corners.
    PIERCE_HD static std::uint32_t vertices_over(const Vec3f (&corner)[3], std::uint32_t own,
                                                 const Vec3f (&other)[3], float margin,
                                                 float size) {
        std::uint32_t bits = own & 7;
        if (bits == 0) return 0;
        const QuickPrism prism(other[0], other[1], other[2], margin, size);
        for (std::uint32_t left = bits; left != 0; left &= left - 1) {
            const std::uint32_t k = lowest_bit(left);
            if (!prism.may_hold(pick(corner, k))) bits &= ~(1u << k);
        }
        return bits;
    }

    /// Four bits for each own edge of the first triangle: the second's own edges.
    PIERCE_HD static std::uint32_t edge_pairs(std::uint32_t first, std::uint32_t second) {
        const std::uint32_t others = second >> 3;
        return (first >> 3 & 1) * others | (first >> 4 & 1) * others << 4 |
               (first >> 5 & 1) * others << 8;
    }

    PIERCE_HD static std::uint32_t after(std::uint32_t k) { return k == 2 ? 0 : k + 1; }
    /// Corner k, without indexing by a value known only at run time: arrays indexed so do not stay
    /// in registers.
    PIERCE_HD static Vec3f pick(const Vec3f (&corner)[3], std::uint32_t k) {
        return k == 0 ? corner[0] : k == 1 ? corner[1] : corner[2];
    }
};

/// True for triangles of whose features nothing is known.
struct IsOpen {
    View<const MeetingTriangles> triangles;

    PIERCE_HD bool find(std::uint32_t i) const {
        return triangles[i].features == FeatureBits::open;
    }
    PIERCE_HD static std::uint32_t count(bool open) { return open; }
    PIERCE_HD void write(std::uint32_t i, bool open, std::uint32_t place,
                         std::uint32_t* list) const {
        if (open) list[place] = i;
    }
};

/// Per pair of triangles that is open: which of their features may meet or come close.
struct FindOpenFeatures {
    SheetBodies bodies;
    View<const SheetPair> pairs;
    View<const std::uint32_t> open;
    View<MeetingTriangles> triangles;  ///< all

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeetingTriangles t = read_whole(triangles[open[i]]);
        const SheetPair& pair = pairs[t.pair];
        const OpenPair p(t, pair, bodies[pair.first], bodies[pair.second]);
        std::uint32_t bits = 0;
        for (std::uint32_t k = 0; k < 3; ++k) bits |= mask(p, k, pair.first == pair.second);
        triangles[open[i]].features = bits;
    }

private:
    /// Two triangles and their bodies.
    struct OpenPair : QuickPair {
        SheetBody of_a, of_b;
        const Triangle &ta, &tb;

        PIERCE_HD OpenPair(const MeetingTriangles& t, const SheetPair& pair,
                           const SheetBody& body_a, const SheetBody& body_b)
            : QuickPair(body_a.placed(body_a.triangle_at(t.first)),
                        body_b.placed(body_b.triangle_at(t.second)), pair),
              of_a(body_a),
              of_b(body_b),
              ta(body_a.mesh.triangles[a.triangle]),
              tb(body_b.mesh.triangles[b.triangle]) {}
    };

    /// The bits of corner k and edge k of each triangle with the features of the other triangle.
    PIERCE_HD static std::uint32_t mask(const OpenPair& p, std::uint32_t k, bool self) {
        const std::uint32_t next = k == 2 ? 0 : k + 1;
        const QuickPoint corner_a = p.qa.pick(k), corner_b = p.qb.pick(k),
                         after_a = p.qa.pick(next), after_b = p.qb.pick(next);
        std::uint32_t bits = 0;
        if (p.a.own >> k & 1 && !(self && has_vertex(p.tb, p.ta.vertex[k])) &&
            may_touch(corner_a, p.qb, p))
            bits |= 1u << (FeatureBits::vertex_of_first + k);
        if (p.b.own >> k & 1 && !(self && has_vertex(p.ta, p.tb.vertex[k])) &&
            may_touch(corner_b, p.qa, p))
            bits |= 1u << (FeatureBits::vertex_of_second + k);
        if (p.a.own >> (3 + k) & 1) {
            const std::uint32_t v = p.ta.vertex[k], w = p.ta.vertex[next];
            const QuickPoint mine[2] = {corner_a, after_a};
            for (std::uint32_t l = 0; l < 3; ++l) {
                if (!(p.b.own >> (3 + l) & 1)) continue;
                const std::uint32_t after = l == 2 ? 0 : l + 1, x = p.tb.vertex[l],
                                    y = p.tb.vertex[after];
                if (self && (v == x || v == y || w == x || w == y)) continue;
                const QuickPoint others[2] = {p.qb.pick(l), p.qb.pick(after)};
                if (may_touch(mine, others, p)) bits |= 1u << (FeatureBits::edges + 4 * k + l);
            }
            if (!(self && (has_vertex(p.tb, v) || has_vertex(p.tb, w))) &&
                may_pierce(corner_a.end, after_a.end, p.qb, p.end_size) &&
                stays_pierced(p.of_a, v, w, p.of_b, p.tb))
                bits |= 1u << (FeatureBits::piercing_first + k);
        }
        if (p.b.own >> (3 + k) & 1 &&
            !(self && (has_vertex(p.ta, p.tb.vertex[k]) || has_vertex(p.ta, p.tb.vertex[next]))) &&
            may_pierce(corner_b.end, after_b.end, p.qa, p.end_size) &&
            stays_pierced(p.of_b, p.tb.vertex[k], p.tb.vertex[next], p.of_a, p.ta))
            bits |= 1u << (FeatureBits::piercing_second + k);
        return bits;
    }

    PIERCE_HD static bool may_touch(const QuickPoint& corner, const QuickTriangle& face,
                                    const QuickPair& p) {
        const QuickPoint point[1] = {corner};
        const Vec3f directions[5] = {
            face.end_normal(), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, face.start_normal()};
        Company company;
        company.distant = !QuickPrism(face.corner[0].end, face.corner[1].end, face.corner[2].end,
                                      p.margin, p.end_size)
                               .may_hold(corner.end);
        for (int k = 0; k < 5 && !company.is_settled(); ++k)
            company.learn(company_along(directions[k], point, face.corner, p.margin, p.size));
        return !company.is_settled();
    }

    PIERCE_HD static bool may_touch(const QuickPoint (&a)[2], const QuickPoint (&b)[2],
                                    const QuickPair& p) {
        const Vec3f directions[5] = {quick_cross(a[1].end - a[0].end, b[1].end - b[0].end),
                                     {1, 0, 0},
                                     {0, 1, 0},
                                     {0, 0, 1},
                                     quick_cross(a[1].start - a[0].start, b[1].start - b[0].start)};
        Company company;
        company.distant = !may_cross_over(a[0].end, a[1].end, b[0].end, b[1].end, p.thickness,
                                          p.end_size);
        for (int k = 0; k < 5 && !company.is_settled(); ++k)
            company.learn(company_along(directions[k], a, b, p.thickness, p.size));
        return !company.is_settled();
    }

    /// False if both ends are certainly on one side of the triangle's plane.
    PIERCE_HD static bool may_pierce(Vec3f p, Vec3f q, const QuickTriangle& face, float size) {
        const Vec3f n = face.end_normal();
        const float room = made_up_along(n, size);
        const float from = quick_dot(n, p - face.corner[0].end),
                    to = quick_dot(n, q - face.corner[0].end);
        return !(from > room && to > room) && !(from < -room && to < -room);
    }

    PIERCE_HD static bool stays_pierced(const SheetBody& of_edge, std::uint32_t v, std::uint32_t w,
                                        const SheetBody& of_face, const Triangle& t) {
        const MovingPoint a = of_face.vertex(t.vertex[0]), b = of_face.vertex(t.vertex[1]),
                          c = of_face.vertex(t.vertex[2]), p = of_edge.vertex(v),
                          q = of_edge.vertex(w);
        return pierces(p.end - a.end, q.end - a.end, {}, b.end - a.end, c.end - a.end) &&
               pierces(p.start - a.start, q.start - a.start, {}, b.start - a.start,
                       c.start - a.start);
    }
};

/// Per pair of triangles: its features, the keys they are sorted by, and their places, which are
/// sorted along with the keys.
struct ListFeatures {
    SheetBodies bodies;
    View<const SheetPair> pairs;
    View<const MeetingTriangles> triangles;
    std::uint32_t key_bits = 0;  ///< of a feature's number

    PIERCE_HD std::uint32_t find(std::uint32_t i) const { return triangles[i].features; }
    PIERCE_HD static std::uint32_t count(std::uint32_t bits) {
        return bit_count(bits & FeatureBits::all);
    }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t bits, std::uint32_t place,
                         FeaturePair* features, std::uint64_t* keys, std::uint32_t* order) const {
        write_bits<FeatureBits::count>(
            bits, i, place,
            [&](std::uint32_t item, std::uint32_t mask, std::uint32_t bit, std::uint32_t at) {
                const MeetingTriangles t = read_whole(triangles[item]);
                FeaturePair f = feature(t, bit);
                f.separate = (mask & FeatureBits::separate) != 0;
                write_whole(features[at], f);
                keys[at] = feature_key(f.pair, f.kind, f.item, key_bits);
                order[at] = at;
            });
    }

private:
    PIERCE_HD FeaturePair feature(const MeetingTriangles& t, std::uint32_t bit) const {
        const SheetPair pair = read_whole(pairs[t.pair]);
        const SheetBody body_a = bodies[pair.first], body_b = bodies[pair.second];
        const MeshView &first = body_a.mesh, &second = body_b.mesh;
        const std::uint32_t a = body_a.triangle_at(t.first), b = body_b.triangle_at(t.second);
        const std::uint32_t at_first = bodies.vertex_offsets[pair.first],
                            at_second = bodies.vertex_offsets[pair.second];
        // For a body against itself, it does not matter which of the two holds the vertex.
        const bool self = pair.is_self();
        FeaturePair f;
        f.pair = t.pair;
        if (bit < FeatureBits::vertex_of_second) {
            f.item = first.triangles[a].vertex[bit];
            f.other = b;
            f.kind = FeatureKind::vertex_of_a;
            set_vertices(f, at_first + f.item, second.triangles[b], at_second);
        } else if (bit < FeatureBits::edges) {
            f.item = second.triangles[b].vertex[bit - FeatureBits::vertex_of_second];
            f.other = a;
            f.kind = self ? FeatureKind::vertex_of_a : FeatureKind::vertex_of_b;
            set_vertices(f, at_second + f.item, first.triangles[a], at_first);
        } else if (bit < FeatureBits::piercing_first) {
            const std::uint32_t mine = first.features[a].edge[(bit - FeatureBits::edges) / 4],
                                others = second.features[b].edge[(bit - FeatureBits::edges) % 4];
            // If both edges are of one body, the smaller one comes first, so that the same two
            // edges always make the same pair.
            const bool turn = self && others < mine;
            f.item = turn ? others : mine;
            f.other = turn ? mine : others;
            f.kind = FeatureKind::edges;
            for (int k = 0; k < 2; ++k) {
                f.vertex[k] = at_first + first.edges[f.item].vertex[k];
                f.vertex[2 + k] = at_second + second.edges[f.other].vertex[k];
            }
        } else if (bit < FeatureBits::piercing_second) {
            f.item = first.features[a].edge[bit - FeatureBits::piercing_first];
            f.other = b;
            f.kind = FeatureKind::piercing_edge_of_a;
        } else {
            f.item = second.features[b].edge[bit - FeatureBits::piercing_second];
            f.other = a;
            f.kind = self ? FeatureKind::piercing_edge_of_a : FeatureKind::piercing_edge_of_b;
        }
        return f;
    }

    PIERCE_HD static void set_vertices(FeaturePair& f, std::uint32_t vertex, const Triangle& t,
                                       std::uint32_t offset) {
        f.vertex[0] = vertex;
        for (int k = 0; k < 3; ++k) f.vertex[k + 1] = offset + t.vertex[k];
    }
};

}  // namespace pierce::stages
