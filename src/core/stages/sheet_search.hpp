#pragma once

#include "pierce/core/atomics.hpp"
#include "pierce/core/bits.hpp"
#include "pierce/core/body.hpp"
#include "pierce/core/first_crossing.hpp"
#include "pierce/core/moving_point.hpp"
#include "pierce/core/separating_direction.hpp"
#include "pierce/core/stages/pairs.hpp"

/// Sheets, first half: which vertices and triangles, and which edges, of a sheet and another body, or of a sheet alone, may
/// meet during the step or come closer than the thickness. Triangle by triangle through the other body's tree, whose boxes
/// hold the whole step; then feature by feature. Nothing that meets is left out.
namespace pierce::stages {

/// A vertex during the step, in world space.
PIERCE_HD inline MovingPoint moving_vertex(const BodyView& body, std::uint32_t v) {
    const Vec3d end = to_double(body.positions[v]);
    if (body.motion == Motion::deforming) return {to_double(body.start[v]), end};
    return {body.start_space.to_parent(end), body.space.to_parent(end)};
}

/// A triangle during the step, in world space, relative to `origin`.
struct MovingTriangle {
    MovingPoint corner[3];

    PIERCE_HD MovingTriangle(const BodyView& body, std::uint32_t triangle, Vec3d origin) {
        const Triangle& t = body.mesh.triangles[triangle];
        for (int k = 0; k < 3; ++k) {
            const MovingPoint p = moving_vertex(body, t.vertex[k]);
            corner[k] = {p.start - origin, p.end - origin};
        }
    }

    PIERCE_HD Box box() const {
        Box all;
        for (const MovingPoint& p : corner) {
            all.extend(p.start);
            all.extend(p.end);
        }
        return all;
    }
    PIERCE_HD Vec3d start_normal() const {
        return cross(corner[1].start - corner[0].start, corner[2].start - corner[0].start);
    }
    PIERCE_HD Vec3d end_normal() const { return cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end); }
};

/// True if along `n`, of any length, two convex features stay further apart than `margin`, one always ahead: differences of
/// corners are linear in time, so they do if they do at the start and at the end. `size`: no coordinate is larger.
template <int mine, int others>
PIERCE_HD bool stay_apart(Vec3d n, const MovingPoint (&a)[mine], const MovingPoint (&b)[others], double margin,
                          double size) {
    const double room =
        margin * length(n) + constants::motion_rounding * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z)) * size;
    double low[2][2], high[2][2];  // of a and b, at the start and at the end
    for (int k = 0; k < mine; ++k) {
        const double at[2] = {dot(n, a[k].start), dot(n, a[k].end)};
        for (int when = 0; when < 2; ++when) {
            low[0][when] = k == 0 ? at[when] : min_of(at[when], low[0][when]);
            high[0][when] = k == 0 ? at[when] : max_of(at[when], high[0][when]);
        }
    }
    for (int k = 0; k < others; ++k) {
        const double at[2] = {dot(n, b[k].start), dot(n, b[k].end)};
        for (int when = 0; when < 2; ++when) {
            low[1][when] = k == 0 ? at[when] : min_of(at[when], low[1][when]);
            high[1][when] = k == 0 ? at[when] : max_of(at[when], high[1][when]);
        }
    }
    return (low[0][0] - high[1][0] > room && low[0][1] - high[1][1] > room) ||
           (low[1][0] - high[0][0] > room && low[1][1] - high[0][1] > room);
}

/// How a sheet looks for what it meets, in a pair.
struct SheetPair {
    std::uint32_t first = 0, second = 0;  ///< bodies: a sheet whose triangles search, and the one whose tree is searched
    std::uint32_t side = 0;               ///< the first's side of the pair
    SelfCollision how = SelfCollision::on;
    bool searches = false;  ///< a sheet is part of it
    std::uint8_t padding[2] = {};
    double thickness = 0;  ///< [length]
    double margin = 0;     ///< [length] vertices this close to triangles matter; more than the thickness if some are through
};

/// Per pair: how it is searched, and how many triangles do so; none if no sheet is part of it. Reads how deep vertices were
/// on the wrong side in the last step.
struct PlanSheetPair {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<const std::uint32_t> links;
    View<const std::uint32_t> last_deepest;  ///< per pair of the last step, as the bits of a float32
    View<SheetPair> sheet_pairs;
    View<std::uint32_t> counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Pair pair = pairs[i];
        const Collision &a = bodies[pair.a].collision, &b = bodies[pair.b].collision;
        SheetPair s;
        s.side = a.sheet ? 0 : 1;
        s.first = pair.source(s.side);
        s.second = pair.target(s.side);
        if (pair.is_self()) s.how = a.self;
        s.thickness = s.margin = max_of(a.thickness, b.thickness);
        if (links[i] != no_pair && links[i] < last_deepest.size)
            s.margin += static_cast<double>(std::bit_cast<float>(last_deepest[links[i]]));
        s.searches = a.sheet || b.sheet;
        sheet_pairs[i] = s;
        counts[i] = s.searches ? bodies[s.first].mesh.triangles.size : 0;
    }
};

/// Per pair: marks the body whose tree is searched.
struct MarkSearched {
    View<const SheetPair> pairs;
    View<std::uint32_t> wanted;  ///< per body

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (pairs[i].searches) atomic_mark(wanted[pairs[i].second]);
    }
};

/// A triangle of a pair's first body.
struct SheetItem {
    std::uint32_t pair = 0;
    std::uint32_t triangle = 0;
};

/// The item at a place in the list of all triangles of all pairs' first bodies; `offsets`: where each pair's begin, ones
/// past the last pair.
PIERCE_HD inline SheetItem sheet_item(View<const std::uint32_t> offsets, std::uint32_t place) {
    std::uint32_t low = 0, high = offsets.size;
    while (high - low > 1) {
        const std::uint32_t middle = low + (high - low) / 2;
        (offsets[middle] <= place ? low : high) = middle;
    }
    return {low, place - offsets[low]};
}

/// True for triangles that come near the other body's box.
struct IsNearBody {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const std::uint32_t> offsets;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        const SheetItem item = sheet_item(offsets, i);
        const SheetPair& pair = pairs[item.pair];
        if (pair.first == pair.second) return true;
        const BodyView& other = bodies[pair.second];
        const MovingTriangle mine(bodies[pair.first], item.triangle, {});
        return overlap(mine.box(), other.world_box.inflated(other.travel + pair.margin + other.touch));
    }
};

/// Two triangles whose features are to be tested.
struct TrianglePair {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;  ///< triangles of the pair's first and second body
    std::uint32_t found = 0;  ///< 0: all their features; else which of the first's vertices has met the second by a ray:
                              ///< bit k: vertex k along its velocity, bit 3 + k: against it
};

/// Per near triangle: the triangles it may meet, counted or written. In a body itself, each two once.
struct FindTriangles {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const std::uint32_t> item_offsets, items;
    View<std::uint32_t> counts;  ///< written if `found` is empty
    View<const std::uint32_t> offsets;
    View<TrianglePair> found;

    template <class Show>
    PIERCE_HD void operator()(std::uint32_t i, const Show& show) const {
        const SheetItem item = sheet_item(item_offsets, items[i]);
        const SheetPair& pair = pairs[item.pair];
        std::uint32_t count = 0;
        const auto add = [&](std::uint32_t other, std::uint32_t bits) {
            if (found.data != nullptr) found[offsets[i] + count] = {item.pair, item.triangle, other, bits};
            ++count;
        };
        if (pair.how == SelfCollision::on)
            find_all(item, pair, show, add);
        else
            find_by_rays(item, pair, show, add);
        if (found.data == nullptr) counts[i] = count;
    }

private:
    template <class Show, class Add>
    PIERCE_HD void find_all(const SheetItem& item, const SheetPair& pair, const Show& show, const Add& add) const {
        const BodyView &first = bodies[pair.first], &second = bodies[pair.second];
        const Vec3d origin = moving_vertex(first, first.mesh.triangles[item.triangle].vertex[0]).end;
        const MovingTriangle mine(first, item.triangle, origin);
        const Box box = mine.box().inflated(pair.margin);
        const double size = box.max_coordinate();
        const Vec3d normal = mine.end_normal();
        const bool self = pair.first == pair.second;
        show(pair.second, search_box(first, second, item.triangle, pair.margin), [&](std::uint32_t t) {
            if (self && t <= item.triangle) return;
            const MovingTriangle other(second, t, origin);
            const Box others = other.box();
            if (!overlap(box, others)) return;
            const double largest = max_of(size, others.max_coordinate());
            if (stay_apart(normal, mine.corner, other.corner, pair.margin, largest) ||
                stay_apart(other.end_normal(), mine.corner, other.corner, pair.margin, largest))
                return;
            add(t, 0);
        });
    }

    /// Around the triangle during the step, in the space of the second body's positions. While it moves there, so does that
    /// body, but no point of it further from where it ends than its travel.
    PIERCE_HD static Box search_box(const BodyView& first, const BodyView& second, std::uint32_t triangle, double margin) {
        const bool deforms = second.motion == Motion::deforming;
        Box box;
        for (std::uint32_t v : first.mesh.triangles[triangle].vertex) {
            const MovingPoint p = moving_vertex(first, v);
            box.extend(deforms ? p.start : second.space.to_local(p.start));
            box.extend(deforms ? p.end : second.space.to_local(p.end));
        }
        return box.inflated(margin + second.touch + (deforms ? 0.0 : second.travel));
    }

    /// The closest triangle along the velocity of each vertex of its own, and against it, within the way it has come; the
    /// triangles around the vertex left aside.
    template <class Show, class Add>
    PIERCE_HD void find_by_rays(const SheetItem& item, const SheetPair& pair, const Show& show, const Add& add) const {
        const BodyView& body = bodies[pair.first];
        const Triangle& t = body.mesh.triangles[item.triangle];
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (!(body.mesh.features[item.triangle].own >> k & 1)) continue;
            const MovingPoint p = moving_vertex(body, t.vertex[k]);
            const double speed = length(p.end - p.start);
            if (!(speed > 0)) continue;
            for (std::uint32_t against = 0; against < 2; ++against) {
                const Vec3d direction = (against ? -1.0 : 1.0) / speed * (p.end - p.start);
                // What moves the other way counts, too, where velocities are relative.
                const double reach = pair.how == SelfCollision::published ? speed : speed + body.travel;
                Box box;
                box.extend(p.end);
                box.extend(p.end + reach * direction);
                double nearest = reach;
                std::uint32_t triangle = no_triangle;
                show(pair.second, box.inflated(body.touch), [&](std::uint32_t other) {
                    const Triangle& o = body.mesh.triangles[other];
                    if (has_vertex(o, t.vertex[k])) return;
                    const Crossing crossing =
                        cross_triangle({p.end, direction}, to_double(body.positions[o.vertex[0]]),
                                       to_double(body.positions[o.vertex[1]]), to_double(body.positions[o.vertex[2]]));
                    if (crossing.kind != Crossing::transversal || crossing.t < 0 || crossing.t > nearest) return;
                    if (crossing.t == nearest && other > triangle) return;
                    nearest = crossing.t;
                    triangle = other;
                });
                if (triangle != no_triangle) add(triangle, 1u << (k + 3 * against));
            }
        }
    }
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
    std::uint32_t ray = 0;    ///< 0: continuous; 1: found along the vertex' velocity; 2: against it
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
        const TrianglePair& t = triangles[i];
        masks[i] = t.found != 0 ? t.found : mask(t, pairs[t.pair]);
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
            features[place++] = t.found != 0 ? by_ray(t, pair, bit) : feature(t, pair, bit);
        }
    }

private:
    PIERCE_HD FeaturePair by_ray(const TrianglePair& t, const SheetPair& pair, std::uint32_t bit) const {
        const Triangle& first = bodies[pair.first].mesh.triangles[t.first];
        return {t.pair, FeatureKind::vertex_of_a, first.vertex[bit % 3], t.second, 1 + bit / 3};
    }

    PIERCE_HD FeaturePair feature(const TrianglePair& t, const SheetPair& pair, std::uint32_t bit) const {
        const MeshView &first = bodies[pair.first].mesh, &second = bodies[pair.second].mesh;
        // In a body itself, which of the two it is matters to nobody.
        const bool first_is_a = pair.side == 0, second_is_a = pair.side == 1 || pair.first == pair.second;
        const auto of = [](bool a, FeatureKind kind_of_a) {
            return a ? kind_of_a : static_cast<FeatureKind>(static_cast<std::uint32_t>(kind_of_a) + 1);
        };
        if (bit < first_faces)
            return {t.pair, of(first_is_a, FeatureKind::vertex_of_a), first.triangles[t.first].vertex[bit], t.second, 0};
        if (bit < first_edges)
            return {t.pair, of(second_is_a, FeatureKind::vertex_of_a), second.triangles[t.second].vertex[bit - first_faces],
                    t.first, 0};
        if (bit < first_piercing) {
            const std::uint32_t k = (bit - first_edges) / 3, l = (bit - first_edges) % 3;
            const std::uint32_t e = first.features[t.first].edge[k], f = second.features[t.second].edge[l];
            // The smaller one first where both are of one body: the same two are always the same.
            const bool turn = pair.first == pair.second ? f < e : pair.side == 1;
            return {t.pair, FeatureKind::edges, turn ? f : e, turn ? e : f, 0};
        }
        const std::uint32_t k = bit - first_piercing;
        if (k < 3)
            return {t.pair, of(first_is_a, FeatureKind::piercing_edge_of_a), first.features[t.first].edge[k], t.second, 0};
        return {t.pair, of(second_is_a, FeatureKind::piercing_edge_of_a), second.features[t.second].edge[k - 3], t.first, 0};
    }
};

}  // namespace pierce::stages
