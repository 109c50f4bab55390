#include "truth/meeting.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <optional>
#include <tuple>

#include "truth/bounded_polynomial.hpp"
#include "truth/exact_continuous.hpp"

namespace pierce::truth {
namespace {

/// How often a stretch of time is halved before rational numbers decide: bounds of rounding are
/// reached long before.
constexpr int most_halvings = 40;

using Line = BoundedPolynomial<1>;
template <std::size_t degree>
using Vector = std::array<BoundedPolynomial<degree>, 3>;

Vector<1> operator-(const MovingPoint& a, const MovingPoint& b) {
    Vector<1> v;
    for (int k = 0; k < 3; ++k)
        v[static_cast<std::size_t>(k)] = Line{
            {Interval(a.start[k]) - b.start[k], Interval(a.end[k]) - b.end[k]}};
    return v;
}

template <std::size_t m, std::size_t n>
Vector<m + n> cross(const Vector<m>& a, const Vector<n>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

template <std::size_t m, std::size_t n>
BoundedPolynomial<m + n> dot(const Vector<m>& a, const Vector<n>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Two features meet when they lie in one plane, their volume being zero, and no place is negative.
/// All places are zero where they have no common normal; what is then is not said here.
struct Question {
    BoundedPolynomial<3> volume;
    std::array<BoundedPolynomial<4>, 4> places;
    std::size_t place_count;
};

Question question(Features features, const std::array<MovingPoint, 4>& c) {
    Question q;
    if (features == Features::vertex_and_face) {
        const Vector<1> ab = c[2] - c[1], bc = c[3] - c[2], ca = c[1] - c[3];
        const Vector<1> ap = c[0] - c[1], bp = c[0] - c[2], cp = c[0] - c[3];
        const Vector<2> normal = cross(bc, ca);
        q.volume = dot(normal, ap);
        q.places = {
            dot(normal, cross(ab, ap)), dot(normal, cross(bc, bp)), dot(normal, cross(ca, cp)), {}};
        q.place_count = 3;
    } else {
        const Vector<1> a = c[1] - c[0], b = c[3] - c[2], between = c[2] - c[0];
        const Vector<2> normal = cross(a, b);
        q.volume = dot(normal, between);
        const BoundedPolynomial<4> size = dot(normal, normal),
                                   first = dot(normal, cross(between, b)),
                                   second = dot(normal, cross(between, a));
        q.places = {first, size - first, second, size - second};
        q.place_count = 4;
    }
    return q;
}

/// Whether they meet in the question's stretch of time; nothing if rounding hides it.
std::optional<bool> answer(const Question& q, int halvings) {
    if (q.volume.is_positive() || q.volume.is_negative()) return false;
    bool all_positive = true;
    for (std::size_t k = 0; k < q.place_count; ++k) {
        // Not zero: so there is a normal.
        if (q.places[k].is_negative()) return false;
        all_positive = all_positive && q.places[k].is_positive();
    }
    const Interval from = q.volume.first(), to = q.volume.last();
    const bool turns = (from.is_positive() && to.is_negative()) ||
                       (from.is_negative() && to.is_positive());
    if (all_positive && turns) return true;
    if (halvings == 0) return std::nullopt;

    Question low{{}, {}, q.place_count}, high = low;
    std::tie(low.volume, high.volume) = q.volume.halves();
    for (std::size_t k = 0; k < q.place_count; ++k)
        std::tie(low.places[k], high.places[k]) = q.places[k].halves();
    const std::optional<bool> first = answer(low, halvings - 1);
    if (first && *first) return true;
    // What the first half hides would be lost in more halves of halves.
    const std::optional<bool> second = answer(high, first ? halvings - 1 : 0);
    if (second && *second) return true;
    return first && second ? std::optional(false) : std::nullopt;
}

/// Number is double or Interval: a guess, or proof.
template <class Number>
bool is_ahead(Vec3d n, int firsts, const std::array<MovingPoint, 4>& c) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(firsts); ++i)
        for (auto j = static_cast<std::size_t>(firsts); j < 4; ++j)
            for (const auto when : {&MovingPoint::start, &MovingPoint::end}) {
                const Vec3d &p = c[i].*when, &q = c[j].*when;
                const Interval d(Number(n.x) * (Number(p.x) - q.x) +
                                 Number(n.y) * (Number(p.y) - q.y) +
                                 Number(n.z) * (Number(p.z) - q.z));
                if (!d.is_positive()) return false;
            }
    return true;
}

/// True if along `n` one feature is ahead of the other at the start and at the end: and so it is in
/// between, as differences of corners move in straight lines.
bool separates(Vec3d n, int firsts, const std::array<MovingPoint, 4>& c) {
    if (pierce::dot(n, c[0].start - c[3].start) < 0) n = -n;
    return is_ahead<double>(n, firsts, c) && is_ahead<Interval>(n, firsts, c);
}

/// Any direction that separates is proof, so these need not be accurate.
bool are_apart(Features features, const std::array<MovingPoint, 4>& c) {
    const int firsts = features == Features::vertex_and_face ? 1 : 2;
    for (const Vec3d axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
        if (separates(axis, firsts, c)) return true;
    for (const auto when : {&MovingPoint::start, &MovingPoint::end}) {
        const auto at = [&](std::size_t k) { return c[k].*when; };
        const Vec3d normal = firsts == 1 ? pierce::cross(at(2) - at(1), at(3) - at(1))
                                         : pierce::cross(at(1) - at(0), at(3) - at(2));
        if (separates(normal, firsts, c)) return true;
        // In the plane of a face, across its sides; of edges, across each.
        if (firsts == 1) {
            for (std::size_t k = 1; k < 4; ++k)
                if (separates(pierce::cross(normal, at(k == 3 ? 1 : k + 1) - at(k)), firsts, c))
                    return true;
        } else {
            for (std::size_t k : {0u, 2u}) {
                const Vec3d along = at(k + 1) - at(k), between = at(k == 0 ? 2 : 0) - at(k);
                if (separates(pierce::cross(along, normal), firsts, c) ||
                    separates(pierce::cross(along, pierce::cross(between, along)), firsts, c))
                    return true;
            }
        }
    }
    return false;
}

/// True if they share a point at the start or at the end; those that lack an extent are not looked
/// at.
bool share_point_at_an_end(Features features, const std::array<MovingPoint, 4>& c) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    for (const auto when : {&MovingPoint::start, &MovingPoint::end}) {
        const auto at = [&](std::size_t k) {
            const Vec3d& p = c[k].*when;
            return Kernel::Point_3(p.x, p.y, p.z);
        };
        if (features == Features::vertex_and_face) {
            const Kernel::Triangle_3 face(at(1), at(2), at(3));
            if (!face.is_degenerate() && face.has_on(at(0))) return true;
        } else {
            const Kernel::Segment_3 a(at(0), at(1)), b(at(2), at(3));
            if (!a.is_degenerate() && !b.is_degenerate() && CGAL::do_intersect(a, b)) return true;
        }
    }
    return false;
}

}  // namespace

bool features_meet(Features features, const std::array<MovingPoint, 4>& corners,
                   MeetingCounts* counts) {
    MeetingCounts ignored;
    MeetingCounts& count = counts != nullptr ? *counts : ignored;
    if (are_apart(features, corners)) {
        ++count.apart;
        return false;
    }
    if (const std::optional<bool> known = answer(question(features, corners), most_halvings)) {
        ++count.bounded;
        return *known;
    }
    if (share_point_at_an_end(features, corners)) {
        ++count.ends;
        return true;
    }
    ++count.exact;
    const ExactCorners exactly = exact(corners);
    return features == Features::vertex_and_face
               ? first_meeting_of_vertex_and_face(exactly).has_value()
               : first_meeting_of_edges(exactly).has_value();
}

}  // namespace pierce::truth
