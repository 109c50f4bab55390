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

std::vector<std::uint32_t> World::State::own_on_device(
    const std::function<bool(std::uint32_t number)>& wanted) const {
    std::vector<std::uint32_t> bodies;
    for (const std::uint32_t b : own)
        if (inside.bodies.slots()[b].thing.is_on_device() && wanted(b)) bodies.push_back(b);
    return bodies;
}

void World::State::fetch_places(const std::vector<std::uint32_t>& bodies) {
    fetched.clear();
    if (bodies.empty()) return;
    const View<const FetchedPlace> places = inside.backend->fetch_places(
        view_of(std::as_const(inside.views)), view_of(bodies));
    for (std::uint32_t k = 0; k < places.size; ++k) fetched[bodies[k]] = places[k];
}

bool World::State::is_usable_there(std::uint32_t b) const {
    const auto place = fetched.find(b);
    if (place == fetched.end()) return true;
    const auto& [pose, positions, start] = place->second;
    if (inside.bodies.slots()[b].thing.motion != Motion::deforming) return is_usable(pose);
    return is_usable(std::span(positions.data, positions.size)) &&
           is_usable(std::span(start.data, start.size));
}

/// Brings the places that others have to know from device memory. Bodies whose places there are
/// unusable are near nobody.
void World::State::bring_places(std::vector<std::vector<NearBody>>& near) {
    std::vector<std::uint32_t> bodies;
    for (const std::vector<NearBody>& of_rank : near)
        for (const NearBody& body : of_rank)
            if (entry(body.number).is_on_device()) bodies.push_back(body.number);
    std::ranges::sort(bodies);
    bodies.erase(std::ranges::unique(bodies).begin(), bodies.end());
    fetch_places(bodies);
    for (std::vector<NearBody>& of_rank : near)
        std::erase_if(of_rank, [&](const NearBody& b) { return !is_usable_there(b.number); });
}

}  // namespace pierce::mpi
