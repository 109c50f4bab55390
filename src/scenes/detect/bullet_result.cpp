#include "scenes/detect/bullet_result.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>

#include <algorithm>
#include <chrono>

#include "pierce/bullet/bullet_convert.hpp"

namespace pierce::scenes {

void TimedDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* overlapping,
                                                const btDispatcherInfo& info,
                                                btDispatcher* dispatcher) {
    const auto begin = std::chrono::steady_clock::now();
    btCollisionDispatcher::dispatchAllCollisionPairs(overlapping, info, dispatcher);
    milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                             begin)
                       .count();
    pairs = static_cast<std::uint32_t>(overlapping->getNumOverlappingPairs());
}

void register_baseline(btCollisionDispatcher& dispatcher) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
}

std::vector<MethodContact> bullet_contacts(const btCollisionDispatcher& dispatcher,
                                           const std::vector<bullet::BaselineShape>& shapes,
                                           Margin margins) {
    std::vector<MethodContact> list;
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
        const btPersistentManifold& manifold = *const_cast<btCollisionDispatcher&>(dispatcher)
                                                    .getManifoldByIndexInternal(m);
        const auto first = static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex());
        const auto second = static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex());
        const double margin = margins == Margin::counts
                                  ? 0.0
                                  : shapes[first].margin() + shapes[second].margin();
        for (int i = 0; i < manifold.getNumContacts(); ++i) {
            const btManifoldPoint& point = manifold.getContactPoint(i);
            const double distance = point.getDistance() + margin;
            if (distance > 0) continue;
            // Bullet's normal points from its second body to its first.
            const Vec3d normal = bullet::from_bullet(point.m_normalWorldOnB);
            MethodContact c{.a = std::min(first, second),
                            .b = std::max(first, second),
                            .source = 0,
                            .vertex = no_vertex,
                            .depth = -distance,
                            .normal = first < second ? -normal : normal};
            c.source = c.a;
            list.push_back(c);
        }
    }
    return list;
}

FrameResult bullet_result(TimedDispatcher& dispatcher,
                          const std::vector<bullet::BaselineShape>& shapes, Margin margins,
                          double detection_ms, double refit_ms, double epa_ms) {
    FrameResult result;
    result.update_ms = refit_ms + detection_ms - dispatcher.milliseconds;
    result.narrow_ms = dispatcher.milliseconds - epa_ms;
    result.response_ms = epa_ms;
    result.total_ms = refit_ms + detection_ms;
    result.times = {
        {"update", result.update_ms}, {"narrow", result.narrow_ms}, {"epa", result.response_ms}};
    result.pairs = dispatcher.pairs;
    double sum = 0;
    for (const MethodContact& c : bullet_contacts(dispatcher, shapes, margins)) {
        ++result.contacts;
        sum += c.depth;
        result.penetration_max = std::max(result.penetration_max, c.depth);
        result.touching.emplace_back(c.a, c.b);
        if (c.depth > 0) result.penetrating.emplace_back(c.a, c.b);
    }
    if (result.contacts > 0) result.penetration_mean = sum / result.contacts;
    for (auto* pairs : {&result.touching, &result.penetrating}) {
        std::ranges::sort(*pairs);
        pairs->erase(std::unique(pairs->begin(), pairs->end()), pairs->end());
    }
    return result;
}

FrameResult sheet_result(FrameResult result, const bullet::SheetReport& report) {
    result.times.clear();
    result.name_stages(report.stages);
    result.times.push_back({"response", report.response_ms});
    result.response_ms = report.response_ms;
    result.total_ms = report.detection_ms + report.response_ms;
    result.crossings = report.crossings;
    result.remembered = report.remembered;
    result.tangled = report.tangled;
    result.rounds = report.rounds;
    result.pulled_back = report.pulled_back;
    result.held_bodies = report.held_bodies;
    result.crossings_left = report.crossings_left;
    return result;
}

}  // namespace pierce::scenes
