#pragma once

#include <limits>

#include "core/geometry/moving_features.hpp"
#include "core/geometry/moving_point.hpp"
#include "pierce/min_max.hpp"

/// Finds when a vertex meets a face, or an edge meets an edge, while all their corners move in
/// straight lines.
///
/// The search advances from one time to the next (conservative advancement, Mirtich 1996). The
/// direction between the closest points at a time separates the features for a while
/// (separating_direction.hpp), and during that while the features cannot meet. Where this advances
/// too little, because the features turn, the search halves one feature and follows both halves
/// from that time. Of adaptive subdivision in time and place (Wang et al. 2021, doi
/// 10.1145/3460775) the search needs only the subdivision in place: halves are convex, too, and
/// their corners move in straight lines as well, because they are fixed combinations of the whole
/// feature's corners.
///
/// The search never misses a meeting and never reports one late. Every part has a time: from the
/// start up to that time, directions have separated the part from the other feature beyond
/// rounding. Halves take over the time of their whole and cover the whole. The search leaves a part
/// when the part's time has passed `last`. `last` is the end of the step, or a time after which a
/// direction separates the features up to the end of the step, or the time of a meeting already
/// found, which is no later than what the part has left. So any meeting is in a part that still
/// waits, or is not before the one found. When the search gives up, it reports the earliest time of
/// a waiting part. The proof does not need the closest points to be closest, or directions to be
/// accurate: any direction that separates is proof.
///
/// The search reports a meeting where points of the two features, whose distance is `gap`, are
/// closer than the tolerance, or when the work that a search may take has run out.
namespace pierce {

/// When and where two moving features first meet.
struct Impact {
    double time = 0;      ///< not after the first meeting [0..1]
    double u = 0, v = 0;  ///< vertex and face: weights of b and c; edges: places along the first
                          ///< and the second
    /// Distance of the features at that time and place [length]. It is at most
    /// constants::meeting_tolerance times the largest coordinate of the other corners relative to
    /// the first, at the start or the end, unless the search gave up. A larger distance means that
    /// nothing has met up to `time`, and that later times are unknown.
    double gap = 0;
};

namespace continuous {

/// The first meeting of two features that no axis separates.
template <class Features>
class Search {
public:
    static constexpr int firsts = Features::firsts;

    PIERCE_HD Search(const Corners& start, const Corners& end, double size)
        : start_(start), end_(end), size_(size), tolerance_(constants::meeting_tolerance * size) {}

    PIERCE_HD bool run(Impact& impact) {
        // The direction at the start decides most cases, and the direction at the end decides most
        // of the rest.
        double t = separating::separated_until<firsts>(start_, end_, 0, direction(start_), size_);
        if (t > 1) return false;
        const double back = separating::separated_until<firsts>(end_, start_, 0, direction(end_),
                                                                size_);
        if (back > 1) return false;
        last_ = 1 - back;

        Features features;
        int depth = 0;
        for (;;) {
            if (!pass(features, t, depth)) {
                give_up(features, t);
                break;
            }
            if (depth_ == 0) break;
            --depth_;
            features = waiting_[depth_].features;
            t = waiting_[depth_].since;
            depth = waiting_[depth_].depth;
        }
        if (found_) impact = impact_;
        return found_;
    }

    /// How often the search advanced: its work.
    PIERCE_HD int advances() const { return advances_; }

private:
    struct Waiting {
        Features features;
        double since = 0;
        int depth = 0;
    };

    /// From the closest point of the second feature to that of the first.
    PIERCE_HD static Vec3d direction(const Corners& corners) {
        return Features::difference(corners, Features::closest(corners));
    }

    /// Follows one part until it meets the other feature, or can no longer meet it before `last_`;
    /// false if work has run out at `t`.
    PIERCE_HD bool pass(Features& features, double& t, int depth) {
        Corners start = features.part(start_), end = features.part(end_);
        double previous = std::numeric_limits<double>::infinity(), gain = 0;
        while (t < last_ || (t == last_ && !found_)) {
            if (++advances_ > constants::meeting_advances) return false;
            const Corners now = separating::between(start, end, t);
            const Place place = Features::closest(now);
            const Vec3d n = Features::difference(now, place);
            const double gap = length(n);
            if (gap <= tolerance_) {
                report(features, t, place, gap);
                return true;
            }
            // The gap shrinks fast where features meet without turning much. Where it does not, a
            // part is halved, as smaller parts turn less. Time steps as long as a part is wide cost
            // least, because a part turns in a step by the product of both.
            if (!(gap <= 0.5 * previous) && !(gain >= features.width) &&
                depth < constants::meeting_halvings) {
                waiting_[depth_++] = {features.halve(now, end, place), t, ++depth};
                start = features.part(start_);
                end = features.part(end_);
                previous = std::numeric_limits<double>::infinity();
                continue;
            }
            const double next = separating::separated_until<firsts>(now, end, t, n, size_);
            if (!(next > t) && depth == constants::meeting_halvings) return false;
            gain = next - t;
            previous = gap;
            t = next;
        }
        return true;
    }

    PIERCE_HD void report(const Features& features, double t, Place place, double gap) {
        const Place whole = features.in_whole(place);
        impact_ = {.time = t, .u = whole.u, .v = whole.v, .gap = gap};
        last_ = t;
        found_ = true;
    }

    /// Reports the earliest time that a waiting part has not passed.
    PIERCE_HD void give_up(Features& features, double t) {
        for (; depth_ > 0; --depth_)
            if (waiting_[depth_ - 1].since < t) {
                t = waiting_[depth_ - 1].since;
                features = waiting_[depth_ - 1].features;
            }
        if (found_ && impact_.time <= t) return;
        const Corners now = separating::between(features.part(start_), features.part(end_), t);
        const Place place = Features::closest(now);
        report(features, t, place, length(Features::difference(now, place)));
    }

    Corners start_, end_;
    double size_, tolerance_;
    double last_ = 1;  ///< the features do not first meet after it
    bool found_ = false;
    Impact impact_;
    Waiting waiting_[constants::meeting_halvings];
    int depth_ = 0, advances_ = 0;
};

/// The corners of two moving features, ready for the tests.
template <class Features>
struct Question {
    Corners start, end;
    double size;

    PIERCE_HD Question(const MovingPoint& p, const MovingPoint& q, const MovingPoint& r,
                       const MovingPoint& s) {
        relative_corners(p, q, r, s, start, end);
        size = max_of(separating::size_of(start), separating::size_of(end));
    }

    /// True if an axis, or the direction between the features at the start or at the end, proves
    /// that they do not meet.
    PIERCE_HD bool is_settled() const {
        if (separating::axis_separates<Features::firsts>(start, end, size)) return true;
        const Vec3d first = Features::difference(start, Features::closest(start));
        if (separating::separated_until<Features::firsts>(start, end, 0, first, size) > 1)
            return true;
        const Vec3d last = Features::difference(end, Features::closest(end));
        return separating::separated_until<Features::firsts>(end, start, 0, last, size) > 1;
    }

    PIERCE_HD bool meets(Impact& impact) const {
        if (separating::axis_separates<Features::firsts>(start, end, size)) return false;
        return Search<Features>(start, end, size).run(impact);
    }
};

}  // namespace continuous

/// True if a moving vertex meets a moving face during the step, or comes as close as the tolerance
/// (Impact::gap); touching counts. A face may lack area. False is certain.
PIERCE_HD inline bool vertex_meets_face(const MovingPoint& p, const MovingPoint& a,
                                        const MovingPoint& b, const MovingPoint& c,
                                        Impact& impact) {
    return continuous::Question<continuous::VertexAndFace>(p, a, b, c).meets(impact);
}

/// True if the moving edge from `a0` to `a1` meets the one from `b0` to `b1` during the step, or
/// comes as close as the tolerance (Impact::gap); touching counts. Edges may be parallel, or
/// points. False is certain.
PIERCE_HD inline bool edges_meet(const MovingPoint& a0, const MovingPoint& a1,
                                 const MovingPoint& b0, const MovingPoint& b1, Impact& impact) {
    return continuous::Question<continuous::TwoEdges>(a0, a1, b0, b1).meets(impact);
}

/// True if it is cheap to see that a moving vertex and a moving face do not meet. False proves
/// nothing.
PIERCE_HD inline bool vertex_surely_misses_face(const MovingPoint& p, const MovingPoint& a,
                                                const MovingPoint& b, const MovingPoint& c) {
    return continuous::Question<continuous::VertexAndFace>(p, a, b, c).is_settled();
}

/// The same for two moving edges.
PIERCE_HD inline bool edges_surely_miss(const MovingPoint& a0, const MovingPoint& a1,
                                        const MovingPoint& b0, const MovingPoint& b1) {
    return continuous::Question<continuous::TwoEdges>(a0, a1, b0, b1).is_settled();
}

}  // namespace pierce
