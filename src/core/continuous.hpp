#pragma once

#include <limits>

#include "pierce/core/closest_place_on_triangle.hpp"
#include "pierce/core/moving_point.hpp"
#include "pierce/core/separating_direction.hpp"

/// When a vertex meets a face, or an edge an edge, while all their corners move in straight lines.
///
/// The search goes from one time to the next (conservative advancement, Mirtich 1996): the direction between the closest
/// points at a time separates the features for a while (separating_direction.hpp), and nothing can meet in it. Where that
/// advances too little, as the features turn, one of them is halved, and both halves are followed from there. Of adaptive
/// subdivision in time and place (Wang et al. 2021, doi 10.1145/3460775) this needs the part in place only: halves are
/// convex, too, and their corners, fixed combinations of the whole's, move in straight lines as well.
///
/// A meeting is never missed and none is reported late. Every part has a time up to which a direction, beyond rounding, has
/// separated it from the other feature ever since the start; halves take over that of their whole and cover it. A part is
/// left when that time has passed `last`: the end of the step, or a time after which a direction separates the features up
/// to there, or a meeting already found, which is no later than what the part has left. So any meeting is in a part that is
/// still waiting, or not before the one found; and when the search gives up, it reports the earliest time of a waiting part.
/// It is never used that closest points are closest, or directions accurate: any that separates is proof.
///
/// A reported meeting is near: it is reported where points of the two features, whose distance is `gap`, are closer than the
/// tolerance, or when the work that a search may take has run out.
namespace pierce {

/// When and where two moving features first meet.
struct Impact {
    double time = 0;      ///< not after the first meeting [0..1]
    double u = 0, v = 0;  ///< vertex and face: weights of b and c; edges: places along the first and the second
    /// Distance of the features at that time and place [length]. At most constants::meeting_tolerance times the largest
    /// coordinate of the other corners relative to the first, at the start or the end, unless the search gave up: a
    /// larger one means that nothing has met up to `time`, and nothing is known of what comes then.
    double gap = 0;
};

namespace continuous {

using separating::Corners;

/// A place on both features.
struct Place {
    double u = 0, v = 0;
};

/// A vertex and a part of a face.
struct VertexAndFace {
    static constexpr int firsts = 1;

    double u[3] = {0, 1, 0}, v[3] = {0, 0, 1};  ///< weights of the part's corners
    double width = 1;

    PIERCE_HD Corners part(const Corners& whole) const {
        const Vec3d a = whole.at[1], ab = whole.at[2] - a, ac = whole.at[3] - a;
        Corners c{{whole.at[0]}};
        for (int k = 0; k < 3; ++k) c.at[k + 1] = a + u[k] * ab + v[k] * ac;
        return c;
    }

    /// The closest place, within the part.
    PIERCE_HD static Place closest(const Corners& c) {
        const TrianglePlace place = closest_place_on_triangle(c.at[0], c.at[1], c.at[2], c.at[3]);
        return {place.second, place.third};
    }

    PIERCE_HD static Vec3d difference(const Corners& c, Place p) {
        return c.at[0] - c.at[1] - p.u * (c.at[2] - c.at[1]) - p.v * (c.at[3] - c.at[1]);
    }

    PIERCE_HD Place in_whole(Place p) const {
        const double w = max_of(1 - p.u - p.v, 0.0);
        return {w * u[0] + p.u * u[1] + p.v * u[2], w * v[0] + p.u * v[1] + p.v * v[2]};
    }

    /// Leaves the half with the place and returns the other; the longest edge at both times is halved.
    PIERCE_HD VertexAndFace halve(const Corners& now, const Corners& end, Place p) {
        int longest = 0;
        double most = -1;
        for (int k = 0; k < 3; ++k) {
            const int next = k == 2 ? 0 : k + 1;
            const double length =
                length_squared(now.at[next + 1] - now.at[k + 1]) + length_squared(end.at[next + 1] - end.at[k + 1]);
            if (!(length > most)) continue;
            most = length;
            longest = k;
        }
        const int next = longest == 2 ? 0 : longest + 1;
        const double weight[3] = {1 - p.u - p.v, p.u, p.v};
        const bool nearer_next = weight[next] > weight[longest];
        const double middle_u = 0.5 * (u[longest] + u[next]), middle_v = 0.5 * (v[longest] + v[next]);
        width *= 0.7071067811865476;
        VertexAndFace other = *this;
        const int moved = nearer_next ? longest : next, kept = nearer_next ? next : longest;
        u[moved] = middle_u;
        v[moved] = middle_v;
        other.u[kept] = middle_u;
        other.v[kept] = middle_v;
        return other;
    }
};

/// Parts of two edges.
struct TwoEdges {
    static constexpr int firsts = 2;

    double u[2] = {0, 1}, v[2] = {0, 1};  ///< places of the parts' ends along the edges
    double width = 1;

    PIERCE_HD Corners part(const Corners& whole) const {
        const Vec3d a = whole.at[0], along_a = whole.at[1] - a, b = whole.at[2], along_b = whole.at[3] - b;
        return {{a + u[0] * along_a, a + u[1] * along_a, b + v[0] * along_b, b + v[1] * along_b}};
    }

    PIERCE_HD static Place closest(const Corners& c) {
        const SegmentPlaces places = closest_points_of_segments(c.at[0], c.at[1], c.at[2], c.at[3]);
        return {places.first, places.second};
    }

    PIERCE_HD static Vec3d difference(const Corners& c, Place p) {
        return c.at[0] + p.u * (c.at[1] - c.at[0]) - c.at[2] - p.v * (c.at[3] - c.at[2]);
    }

    PIERCE_HD Place in_whole(Place p) const { return {u[0] + p.u * (u[1] - u[0]), v[0] + p.v * (v[1] - v[0])}; }

    PIERCE_HD TwoEdges halve(const Corners& now, const Corners& end, Place p) {
        const double first = length_squared(now.at[1] - now.at[0]) + length_squared(end.at[1] - end.at[0]);
        const double second = length_squared(now.at[3] - now.at[2]) + length_squared(end.at[3] - end.at[2]);
        width *= 0.7071067811865476;
        TwoEdges other = *this;
        const bool at_first = first > second;
        double* const mine = at_first ? u : v;
        double* const others = at_first ? other.u : other.v;
        const int moved = (at_first ? p.u : p.v) > 0.5 ? 0 : 1;
        mine[moved] = others[1 - moved] = 0.5 * (mine[0] + mine[1]);
        return other;
    }
};

/// Corners relative to the first one, which stands still then: differences are exact or rounded once, however far from the
/// origin they are taken, and a movement that all corners share is gone.
PIERCE_HD inline void relative_corners(const MovingPoint& p, const MovingPoint& q, const MovingPoint& r,
                                       const MovingPoint& s, Corners& start, Corners& end) {
    start = {{{}, q.start - p.start, r.start - p.start, s.start - p.start}};
    end = {{{}, q.end - p.end, r.end - p.end, s.end - p.end}};
}

/// The first meeting of two features that no axis separates.
template <class Features>
class Search {
public:
    static constexpr int firsts = Features::firsts;

    PIERCE_HD Search(const Corners& start, const Corners& end, double size)
        : start_(start), end_(end), size_(size), tolerance_(constants::meeting_tolerance * size) {}

    PIERCE_HD bool run(Impact& impact) {
        // The direction at the start decides most, and the one at the end most of the rest.
        double t = separating::separated_until<firsts>(start_, end_, 0, direction(start_), size_);
        if (t > 1) return false;
        const double back = separating::separated_until<firsts>(end_, start_, 0, direction(end_), size_);
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
        double since;
        int depth;
    };

    /// From the closest point of the second feature to that of the first.
    PIERCE_HD static Vec3d direction(const Corners& corners) {
        return Features::difference(corners, Features::closest(corners));
    }

    /// Follows one part until it meets, or no longer can before what is known; false if work has run out at `t`.
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
            // The gap shrinks fast where features meet without turning much. Where it does not, parts turn less; time
            // steps as long as a part is wide cost least, as what the part turns by in a step is the product.
            if (!(gap <= 0.5 * previous) && !(gain >= features.width) && depth < constants::meeting_halvings) {
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
        impact_ = {t, whole.u, whole.v, gap};
        last_ = t;
        found_ = true;
    }

    /// Reports the earliest time that has not been passed.
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
    double last_ = 1;  ///< nothing first meets after it
    bool found_ = false;
    Impact impact_;
    Waiting waiting_[constants::meeting_halvings];
    int depth_ = 0, advances_ = 0;
};

template <class Features>
PIERCE_HD bool meet(const MovingPoint& p, const MovingPoint& q, const MovingPoint& r, const MovingPoint& s, Impact& impact) {
    Corners start, end;
    relative_corners(p, q, r, s, start, end);
    const double size = max_of(separating::size_of(start), separating::size_of(end));
    if (separating::axis_separates<Features::firsts>(start, end, size)) return false;
    return Search<Features>(start, end, size).run(impact);
}

}  // namespace continuous

/// True if a moving vertex meets a moving face during the step, or comes as close as the tolerance (Impact::gap); touching
/// counts. A face may lack area. False is certain.
PIERCE_HD inline bool vertex_meets_face(const MovingPoint& p, const MovingPoint& a, const MovingPoint& b,
                                        const MovingPoint& c, Impact& impact) {
    return continuous::meet<continuous::VertexAndFace>(p, a, b, c, impact);
}

/// True if the moving edge from `a0` to `a1` meets the one from `b0` to `b1` during the step, or comes as close as the
/// tolerance (Impact::gap); touching counts. Edges may be parallel, or points. False is certain.
PIERCE_HD inline bool edges_meet(const MovingPoint& a0, const MovingPoint& a1, const MovingPoint& b0, const MovingPoint& b1,
                                 Impact& impact) {
    return continuous::meet<continuous::TwoEdges>(a0, a1, b0, b1, impact);
}

}  // namespace pierce
