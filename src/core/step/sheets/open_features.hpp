#pragma once

#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/sheets/piercing_edge.hpp"
#include "core/step/sheets/quick_prism.hpp"
#include "core/step/sheets/quick_triangle.hpp"
#include "core/step/sheets/sheet_features.hpp"
#include "core/step/sheets/sheet_search.hpp"

/// Sheets, second part, continued: the features of triangles that may meet during the step.
namespace pierce::stages {

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
        const float room = made_up_across(n, size);
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

}  // namespace pierce::stages
