#include "app/output/label_places.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

namespace pierce::app {
namespace {

// [pixels], of a picture whose text is about 13 high.
constexpr double gap = 3;        // between a marker and a label beside it
constexpr double clearance = 2;  // around a label
constexpr double ring = 5;       // from one distance that is tried to the next

// Costs, in pixels of distance that a place is worth.
constexpr double line_cost = 8;        // a line is more to look at than none
constexpr double doubt_cost = 20;      // beside another marker, as if it were that one's label
constexpr double crossing_cost = 250;  // of a line with a label, a marker or a line

constexpr double no_place = std::numeric_limits<double>::max();

constexpr int directions = 48;
constexpr int passes = 20;  // places hardly change after the third one
constexpr int orders = 64;  // of labels that are tried

// Beside a marker: right, then the corners to the right, above, below, and the left.
constexpr Spot sides[] = {{1, 0}, {1, -1}, {1, 1}, {0, -1}, {0, 1}, {-1, 0}, {-1, -1}, {-1, 1}};

Area grown(const Area& area, double by) {
    return {{area.low.x - by, area.low.y - by}, {area.high.x + by, area.high.y + by}};
}

bool within(const Area& area, const Area& frame) {
    return area.low.x >= frame.low.x && area.low.y >= frame.low.y && area.high.x <= frame.high.x &&
           area.high.y <= frame.high.y;
}

Spot closest(const Area& area, Spot p) {
    return {std::clamp(p.x, area.low.x, area.high.x), std::clamp(p.y, area.low.y, area.high.y)};
}

double distance(Spot a, Spot b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Twice the area of a triangle, positive on one side of a line.
double side_of(Spot a, Spot b, Spot c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool cross(const LabelPlace& a, const LabelPlace& b) {
    return a.led && b.led && side_of(a.from, a.to, b.from) * side_of(a.from, a.to, b.to) <= 0 &&
           side_of(b.from, b.to, a.from) * side_of(b.from, b.to, a.to) <= 0;
}

/// The place on one side of a marker, at a distance from it. `side` is on a square around (0, 0).
LabelPlace place_at(const Marker& marker, Spot side, double away) {
    const double reach = marker.radius + gap + away;
    const Spot middle{marker.at.x + side.x * (reach + marker.width / 2),
                      marker.at.y + side.y * (reach + marker.height / 2)};
    LabelPlace place{.box = {{middle.x - marker.width / 2, middle.y - marker.height / 2},
                             {middle.x + marker.width / 2, middle.y + marker.height / 2}},
                     .led = away > 0};
    place.to = closest(place.box, marker.at);
    const double length = distance(marker.at, place.to);
    const double part = marker.radius / length;
    place.from = {marker.at.x + part * (place.to.x - marker.at.x),
                  marker.at.y + part * (place.to.y - marker.at.y)};
    return place;
}

class Search {
public:
    Search(std::span<const Marker> markers, const Area& frame, std::span<const Area> taken)
        : markers_(markers),
          frame_(frame),
          taken_(taken),
          places_(markers.size()),
          placed_(markers.size()) {}

    /// Places for all, one label after the other.
    void place_all(std::span<const std::size_t> order) {
        for (std::size_t m : order) place(m);
        // The first labels did not know of the last ones: each in turn may find a cheaper place.
        bool moved = true;
        for (int pass = 0; pass < passes && moved; ++pass) {
            moved = false;
            for (std::size_t m : order) moved |= place(m);
        }
    }

    double cost() const {
        double sum = 0;
        for (std::size_t m = 0; m < markers_.size(); ++m) sum += cost(m, places_[m]);
        return sum;
    }

    const std::vector<LabelPlace>& places() const { return places_; }

private:
    /// Takes the cheapest place for a label. Returns true if it is another one than before.
    bool place(std::size_t m) {
        double least = placed_[m] ? cost(m, places_[m]) : no_place;
        bool moved = false;
        const auto try_place = [&](Spot side, double away, double rank, bool anywhere) {
            const LabelPlace found = place_at(markers_[m], side, away);
            if ((!anywhere && !within(found.box, frame_)) || !is_free(m, found.box)) return;
            const double its = cost(m, found) + rank;
            if (its >= least) return;
            least = its;
            places_[m] = found;
            placed_[m] = true;
            moved = true;
        };
        const auto try_around = [&](double away, bool anywhere) {
            for (int d = 0; d < directions; ++d) {
                const double angle = 2 * std::numbers::pi * d / directions;
                const double scale = std::numbers::sqrt2;
                try_place({std::clamp(scale * std::cos(angle), -1.0, 1.0),
                           std::clamp(scale * std::sin(angle), -1.0, 1.0)},
                          away, 0, anywhere);
            }
        };
        double rank = 0;
        for (const Spot& side : sides) try_place(side, 0, rank++, false);
        const double size = distance(frame_.low, frame_.high);
        for (double away = ring; away + line_cost < least && away < size; away += ring)
            try_around(away, false);
        for (double away = ring; least == no_place; away += ring) try_around(away, true);
        return moved;
    }

    bool is_free(std::size_t m, const Area& box) const {
        const Area wide = grown(box, clearance);
        for (const Marker& marker : markers_)
            if (overlap(wide, marker.area())) return false;
        for (const Area& area : taken_)
            if (overlap(wide, area)) return false;
        for (std::size_t k = 0; k < places_.size(); ++k)
            if (k != m && placed_[k] && overlap(wide, places_[k].box)) return false;
        return true;
    }

    double cost(std::size_t m, const LabelPlace& place) const {
        const Marker& own = markers_[m];
        const double away = distance(own.at, closest(place.box, own.at)) - own.radius;
        double sum = away + (place.led ? line_cost : 0);
        for (std::size_t k = 0; k < markers_.size(); ++k) {
            if (k == m) continue;
            const Marker& other = markers_[k];
            // A line out of a heap of markers cannot help to cross them.
            if (place.led && !overlap(own.area(), other.area()) &&
                crosses(place.from, place.to, other.area()))
                sum += crossing_cost;
            if (distance(other.at, closest(place.box, other.at)) - other.radius < away + gap)
                sum += doubt_cost / (place.led ? 2 : 1);
            if (!placed_[k]) continue;
            const LabelPlace& its = places_[k];
            if (place.led && crosses(place.from, place.to, grown(its.box, clearance)))
                sum += crossing_cost;
            if (its.led && crosses(its.from, its.to, grown(place.box, clearance)))
                sum += crossing_cost;
            if (cross(place, its)) sum += crossing_cost;
        }
        return sum;
    }

    std::span<const Marker> markers_;
    Area frame_;
    std::span<const Area> taken_;
    std::vector<LabelPlace> places_;
    std::vector<bool> placed_;
};

}  // namespace

bool overlap(const Area& a, const Area& b) {
    return a.low.x < b.high.x && b.low.x < a.high.x && a.low.y < b.high.y && b.low.y < a.high.y;
}

bool crosses(Spot from, Spot to, const Area& area) {
    double begin = 0, end = 1;
    const auto cut = [&](double p, double q, double low, double high) {
        if (p == q) {
            if (p <= low || p >= high) end = -1;
            return;
        }
        const double a = (low - p) / (q - p), b = (high - p) / (q - p);
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    };
    cut(from.x, to.x, area.low.x, area.high.x);
    cut(from.y, to.y, area.low.y, area.high.y);
    return begin < end;
}

std::vector<LabelPlace> label_places(std::span<const Marker> markers, const Area& frame,
                                     std::span<const Area> taken) {
    std::vector<std::size_t> order(markers.size());
    std::iota(order.begin(), order.end(), 0u);
    std::mt19937 random;  // always the same orders
    std::vector<LabelPlace> best;
    double least = no_place;
    for (int k = 0; k < orders; ++k) {
        Search search(markers, frame, taken);
        search.place_all(order);
        if (search.cost() < least) {
            least = search.cost();
            best = search.places();
        }
        for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    }
    return best;
}

}  // namespace pierce::app
