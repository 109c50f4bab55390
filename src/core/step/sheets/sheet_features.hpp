#pragma once

#include "core/device/quick_math.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/contact_keys.hpp"
#include "core/step/sheets/cull_triangles.hpp"
#include "core/step/sheets/feature_bits.hpp"
#include "core/step/sheets/four_features.hpp"
#include "core/step/sheets/quick_prism.hpp"
#include "core/step/sheets/sheet_search.hpp"

/// Sheets, second part: which vertices and triangles, and which edges, of two triangles may meet or
/// come close.
namespace pierce::stages {

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

/// Two triangles with features that may be contacts.
struct alignas(16) MeetingTriangles {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;  ///< as in TrianglePair
    std::uint32_t features = 0;           ///< FeatureBits
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

#if defined(PIERCE_FOUR_LANES)
    /// What find() would find, four features at a time.
    void find_all(std::uint32_t begin, std::uint32_t end, std::uint32_t* found) const {
        for (std::uint32_t next = begin; begin < end; begin = next) {
            next = min_of(begin + FourFeatures::most, end);
            FourFeatures asked;
            for (std::uint32_t i = begin; i < next; ++i) {
                const TrianglePair &t = triangles[i],
                                   &later = triangles[min_of(i + ahead, end - 1)];
                read_ahead(drifting.items[later.first]);
                read_ahead(drifting.items[later.second]);
                const DriftingTriangle &first = drifting.items[t.first],
                                       &second = drifting.items[t.second];
                asked.add(first, second, pairs[t.pair].quick_thickness, pairs[t.pair].quick_margin,
                          t.separate ? FeatureBits::owned(first.own, second.own) : 0);
            }
            asked.answer(found);
            for (std::uint32_t i = begin; i < next; ++i, ++found)
                *found = !triangles[i].separate ? FeatureBits::open
                         : *found == 0          ? 0
                                                : *found | FeatureBits::separate;
        }
    }
#endif

private:
    static constexpr std::uint32_t ahead = 8;  ///< items whose triangles are read meanwhile

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
        for (std::uint32_t left = FeatureBits::owned(first.own, second.own) >> FeatureBits::edges;
             left != 0; left &= left - 1) {
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

    PIERCE_HD static std::uint32_t after(std::uint32_t k) { return k == 2 ? 0 : k + 1; }
    /// Corner k, without indexing by a value known only at run time: arrays indexed so do not stay
    /// in registers.
    PIERCE_HD static Vec3f pick(const Vec3f (&corner)[3], std::uint32_t k) {
        return k == 0 ? corner[0] : k == 1 ? corner[1] : corner[2];
    }
};

/// Per pair of triangles: its features, the keys they are sorted by, and their places, which are
/// sorted along with the keys.
struct ListFeatures {
    SheetBodies bodies;
    View<const SheetPair> pairs;
    View<const MeetingTriangles> triangles;
    SheetKey sheet_key;

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
                keys[at] = sheet_key.of(f.pair, f.kind, f.item);
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
