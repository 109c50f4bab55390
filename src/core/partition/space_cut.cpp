#include "core/partition/space_cut.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/partition/region.hpp"
#include "pierce/constants.hpp"

namespace pierce {

void SpaceCut::divide(std::span<const BodyFacts> bodies, std::span<const Box> reach,
                      std::span<const double> shares) {
    const std::vector<WeightedPoint> places = note_places(bodies, reach);
    owners_ = divide_space(places, {shares.begin(), shares.end()});
    list_owned(bodies, places, shares.size());
}

void SpaceCut::assign(std::span<const BodyFacts> bodies, std::span<const Box> reach,
                      std::vector<std::uint32_t> owners, std::uint32_t parts) {
    owners_ = std::move(owners);
    list_owned(bodies, note_places(bodies, reach), parts);
}

std::vector<WeightedPoint> SpaceCut::note_places(std::span<const BodyFacts> bodies,
                                                 std::span<const Box> reach) {
    std::vector<WeightedPoint> places(bodies.size());
    Vec3d last;
    double extents = 0;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        extents += reach[b].extent();
        // Bodies that take no part go with the one before them.
        if (!reach[b].empty()) last = reach[b].center();
        places[b] = {last, reach[b].empty() ? 0 : bodies[b].weight};
    }
    mean_extent_ = extents / std::max<double>(1, static_cast<double>(bodies.size()));
    return places;
}

void SpaceCut::list_owned(std::span<const BodyFacts> bodies, std::span<const WeightedPoint> places,
                          std::size_t parts) {
    owned_.assign(parts, {});
    for (std::uint32_t b = 0; b < bodies.size(); ++b)
        if (bodies[b].exists)
            owned_[owners_[b]].push_back(
                {.body = b, .cell = 0, .weight = bodies[b].active ? bodies[b].weight : 0});
    const std::vector<double> equal(constants::part_cells, 1.0);
    for (std::vector<Owned>& owned : owned_) {
        std::vector<WeightedPoint> own_places;
        own_places.reserve(owned.size());
        for (const Owned& own : owned) own_places.push_back(places[own.body]);
        const std::vector<std::uint32_t> cells = divide_space(own_places, equal);
        for (std::size_t k = 0; k < owned.size(); ++k) owned[k].cell = cells[k];
    }
}

BodySet SpaceCut::seen_from(std::uint32_t part, std::span<const BodyFacts> bodies,
                            std::span<const Box> reach, double more, double* load) const {
    BodySet seen(bodies.size(), 0);
    if (owned_.empty() || owners_.size() != bodies.size()) return seen;
    Region region(constants::part_cells, mean_extent_);
    double weight = 0;
    for (const Owned& own : owned_[part]) {
        seen[own.body] = 1;
        weight += own.weight;
        // What is a ghost of the whole scene may have changed since space was cut.
        const BodyFacts& facts = bodies[own.body];
        if (facts.moves && !facts.is_ghost) region.add(own.cell, reach[own.body]);
    }
    region.close(more);
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        // Pairs of two moving bodies belong to the lower one of their parts.
        const std::uint32_t other = pair_part(bodies[b], b);
        const bool may_be_pair = other > part || (other < part && !bodies[b].moves);
        if (!may_be_pair || seen[b] || !region.meets(reach[b])) continue;
        seen[b] = 1;
        weight += constants::ghost_work * bodies[b].weight;
    }
    if (load != nullptr) *load = weight;
    return seen;
}

std::vector<double> corrected_shares(std::vector<double> shares, std::span<const double> wanted,
                                     std::span<const double> loads) {
    const double all = std::accumulate(loads.begin(), loads.end(), 0.0),
                 all_wanted = std::accumulate(wanted.begin(), wanted.end(), 0.0);
    for (std::size_t part = 0; part < shares.size(); ++part)
        if (loads[part] > 0) shares[part] *= all * wanted[part] / (all_wanted * loads[part]);
    return shares;
}

}  // namespace pierce
