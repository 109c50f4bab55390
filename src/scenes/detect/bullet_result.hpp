#pragma once

#include <btBulletCollisionCommon.h>

#include "pierce/bullet/baseline_shapes.hpp"
#include "pierce/bullet/sheet_response.hpp"
#include "scenes/detect/method.hpp"

namespace pierce::scenes {

/// Bullet's dispatcher with a clock on the narrow phase.
class TimedDispatcher : public btCollisionDispatcher {
public:
    using btCollisionDispatcher::btCollisionDispatcher;

    void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                   btDispatcher* dispatcher) override;

    double milliseconds = 0;  ///< of the last step
    std::uint32_t pairs = 0;  ///< overlapping boxes in the last step
};

/// Makes GImpact shapes known to a dispatcher.
void register_baseline(btCollisionDispatcher& dispatcher);

/// Whether the margin that Bullet puts around a mesh belongs to the body.
enum class Margin { counts, left_out };

/// How long a step of Bullet's own detection took and what it found. An object's user index is its
/// index in `shapes`. A point counts as a contact if the bodies, with or without Bullet's margins,
/// overlap there.
FrameResult bullet_result(TimedDispatcher& dispatcher,
                          const std::vector<bullet::BaselineShape>& shapes, Margin margins,
                          double detection_ms, double refit_ms, double epa_ms);

/// A step's result, with the times of all detections of the step added up.
FrameResult sheet_result(FrameResult result, const bullet::SheetReport& report);

/// The points of all manifolds at which bodies overlap.
std::vector<MethodContact> bullet_contacts(const btCollisionDispatcher& dispatcher,
                                           const std::vector<bullet::BaselineShape>& shapes,
                                           Margin margins);

}  // namespace pierce::scenes
