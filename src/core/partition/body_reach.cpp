#include "core/partition/body_reach.hpp"

#include <algorithm>

#include "core/body/reach.hpp"
#include "core/geometry/motion_bound.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// How far predictions look at most (stages::MeasurePredictionRange).
double longest_prediction(const BodyView& body, const Settings& settings) {
    if (settings.temporal != Temporal::paper || !settings.predict) return 0;
    return settings.prediction_distance >= 0
               ? 0.5 * settings.prediction_distance
               : 0.5 * constants::prediction_limit * body.mesh.mean_edge_length;
}

/// Where a body is whose place the host knows.
PlacedBox place_on_host(const BodyView& body) {
    PlacedBox place;
    if (body.motion == Motion::deforming) {
        for (const Vec3f p : body.positions) place.box.extend(to_double(p));
        for (std::uint32_t v = 0; v < body.start.size; ++v)
            place.travel = std::max(
                place.travel, length(to_double(body.positions[v]) - to_double(body.start[v])));
    } else {
        place = placed_box(body.mesh.box, body.space);
        place.travel = largest_motion(body.start_space, body.space, body.mesh.box);
    }
    return place;
}

}  // namespace

double reach_beyond_points(const BodyView& body, const Settings& settings) {
    return longest_prediction(body, settings) + body.collision.thickness + body.margin +
           body.memory;
}

Box reach_on_host(const BodyView& body, const Settings& settings) {
    return reach_of(place_on_host(body), reach_beyond_points(body, settings));
}

}  // namespace pierce
