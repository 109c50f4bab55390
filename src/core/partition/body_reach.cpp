#include "core/partition/body_reach.hpp"

#include <algorithm>

#include "core/geometry/motion_bound.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

Vec3d corner(const Box& box, int k) {
    return {(k & 1 ? box.upper : box.lower).x, (k & 2 ? box.upper : box.lower).y,
            (k & 4 ? box.upper : box.lower).z};
}

/// How far predictions look at most (stages::MeasureReach).
double longest_prediction(const BodyView& body, const Settings& settings) {
    if (settings.temporal != Temporal::paper || !settings.predict) return 0;
    return settings.prediction_distance >= 0
               ? 0.5 * settings.prediction_distance
               : 0.5 * constants::prediction_limit * body.mesh.mean_edge_length;
}

}  // namespace

PlacedBox placed_box(const BodyView& body) {
    PlacedBox place;
    if (body.motion == Motion::deforming) {
        for (const Vec3f p : body.positions) place.box.extend(to_double(p));
        for (std::uint32_t v = 0; v < body.start.size; ++v)
            place.travel = std::max(
                place.travel, length(to_double(body.positions[v]) - to_double(body.start[v])));
    } else {
        for (int k = 0; k < 8; ++k)
            place.box.extend(body.space.to_parent(corner(body.mesh.box, k)));
        place.travel = largest_motion(body.start_space, body.space, body.mesh.box);
    }
    return place;
}

double reach_beyond_box(const BodyView& body, const Settings& settings) {
    return longest_prediction(body, settings) + body.collision.thickness + body.margin;
}

Box box_of_reach(const PlacedBox& place, double more) {
    if (place.box.empty()) return {};
    // Steps measure boxes in several frames, with a touch tolerance for each; the diagonal is at
    // most sqrt(3) times as long as that of a box in another frame, and 16 covers their sum.
    const double touch = 16 * constants::touch_tolerance *
                         (place.box.extent() + place.box.max_coordinate());
    return place.box.inflated(touch + place.travel + more);
}

}  // namespace pierce
