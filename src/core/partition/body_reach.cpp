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

Box box_of_reach(const BodyView& body, const Settings& settings) {
    Box box;
    if (!body.active) return box;
    double travel = 0;
    if (body.motion == Motion::deforming) {
        for (const Vec3f p : body.positions) box.extend(to_double(p));
        for (std::uint32_t v = 0; v < body.start.size; ++v)
            travel = std::max(travel,
                              length(to_double(body.positions[v]) - to_double(body.start[v])));
    } else {
        for (int k = 0; k < 8; ++k) box.extend(body.space.to_parent(corner(body.mesh.box, k)));
        travel = largest_motion(body.start_space, body.space, body.mesh.box);
    }
    // Steps measure boxes in several frames, with a touch tolerance for each; the diagonal is at
    // most sqrt(3) times as long as that of a box in another frame, and 16 covers their sum.
    const double touch = 16 * constants::touch_tolerance * (box.extent() + box.max_coordinate());
    return box.inflated(touch + travel + longest_prediction(body, settings) +
                        body.collision.thickness + body.margin);
}

}  // namespace pierce
