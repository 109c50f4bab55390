#include "pierce/scenes/bullet_result.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>

#include <algorithm>
#include <chrono>

namespace pierce::scenes {

void TimedDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* overlapping, const btDispatcherInfo& info,
                                                btDispatcher* dispatcher) {
    const auto begin = std::chrono::steady_clock::now();
    btCollisionDispatcher::dispatchAllCollisionPairs(overlapping, info, dispatcher);
    milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    pairs = static_cast<std::uint32_t>(overlapping->getNumOverlappingPairs());
}

void register_baseline(btCollisionDispatcher& dispatcher) { btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher); }

FrameResult bullet_result(TimedDispatcher& dispatcher, const std::vector<bullet::BaselineShape>& shapes, Margin margins,
                          double detection_ms, double refit_ms, double epa_ms) {
    FrameResult result;
    result.update_ms = refit_ms + detection_ms - dispatcher.milliseconds;
    result.narrow_ms = dispatcher.milliseconds - epa_ms;
    result.response_ms = epa_ms;
    result.total_ms = refit_ms + detection_ms;
    result.stages = {{"update", result.update_ms}, {"narrow", result.narrow_ms}, {"epa", result.response_ms}};
    result.pairs = dispatcher.pairs;
    double sum = 0;
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
        const auto a = static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex());
        const auto b = static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex());
        const double margin = margins == Margin::counts ? 0.0 : shapes[a].margin() + shapes[b].margin();
        bool touches = false;
        for (int i = 0; i < manifold.getNumContacts(); ++i) {
            const double distance = manifold.getContactPoint(i).getDistance() + margin;
            if (distance > 0) continue;
            touches = true;
            ++result.contacts;
            sum -= distance;
            result.penetration_max = std::max(result.penetration_max, -distance);
        }
        if (!touches) continue;
        result.touching.emplace_back(std::min(a, b), std::max(a, b));
    }
    if (result.contacts > 0) result.penetration_mean = sum / result.contacts;
    std::ranges::sort(result.touching);
    result.touching.erase(std::unique(result.touching.begin(), result.touching.end()), result.touching.end());
    return result;
}

}  // namespace pierce::scenes
