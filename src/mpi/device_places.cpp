#include <algorithm>
#include <span>
#include <utility>

#include "core/partition/body_reach.hpp"
#include "mpi/world_state.hpp"

/// Own bodies whose places are in device memory: what they reach, and where they are for others.
namespace pierce::mpi {

/// Measures the reach of own bodies whose places are in device memory.
void World::State::measure_on_device() {
    bool anew = false;
    for (const std::uint32_t b : inside.refreshed) anew = anew || entry(b).is_on_device();
    std::vector<std::uint32_t> bodies;
    std::vector<double> more;
    for (const std::uint32_t b : own) {
        if (!inside.views[b].active || !entry(b).is_on_device()) continue;
        bodies.push_back(b);
        more.push_back(reach_beyond_points(inside.views[b], inside.plan.settings));
    }
    anew = anew || bodies != on_device;
    on_device = std::move(bodies);
    if (on_device.empty()) return;
    const View<const std::uint32_t> some = view_of(std::as_const(on_device));
    inside.backend->measure_reach(view_of(std::as_const(inside.views)), some,
                                  view_of(std::as_const(more)), anew);
    inside.backend->fetch_reach(some, view_of(reach));
}

void World::State::bring_places(std::vector<std::vector<NearBody>>& near) {
    std::vector<std::uint32_t> bodies;
    for (const std::vector<NearBody>& of_rank : near)
        for (const NearBody& body : of_rank) bodies.push_back(body.number);
    std::ranges::sort(bodies);
    bodies.erase(std::ranges::unique(bodies).begin(), bodies.end());
    inside.bring_places(bodies);
    for (std::vector<NearBody>& of_rank : near)
        std::erase_if(of_rank, [&](const NearBody& b) { return !entry(b.number).is_placed(); });
}

}  // namespace pierce::mpi
