#include "core/partition/partition.hpp"

#include <algorithm>

#include "core/body/body_view.hpp"
#include "core/body/reach.hpp"
#include "core/partition/body_reach.hpp"
#include "core/partition/region.hpp"
#include "core/partition/space_partition.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

bool is_on_device(const BodyView& body) {
    return body.device_positions != nullptr || body.device_pose.exists();
}

}  // namespace

Partition::Partition(std::vector<double> shares)
    : shares_(std::move(shares)),
      measured_(shares_.size()),
      near_(shares_.size()),
      loads_(shares_.size(), 0) {}

void Partition::begin(const Scene& scene, bool anew) {
    bool others_are_measured = anew;
    if (anew) {
        facts_.assign(scene.bodies.size, {});
        reach_.assign(scene.bodies.size, {});
        looked_.clear();
        for (std::uint32_t b = 0; b < scene.bodies.size; ++b) note(scene, b);
    } else {
        for (const std::uint32_t b : scene.changed) {
            const bool was_on_device = facts_[b].on_device;
            note(scene, b);
            others_are_measured = others_are_measured || was_on_device || facts_[b].on_device;
        }
    }
    if (others_are_measured) list_measured(scene);
}

void Partition::note(const Scene& scene, std::uint32_t b) {
    const BodyView& body = scene.bodies[b];
    const bool exists = static_cast<bool>(scene.ids[b]), active = exists && body.active;
    facts_[b] = {.weight = static_cast<float>(body.mesh.triangles.size),
                 .exists = exists,
                 .active = active,
                 .moves = body.motion != Motion::fixed,
                 .on_device = is_on_device(body)};
    reach_[b] = active && !facts_[b].on_device ? reach_on_host(body, scene.plan->settings) : Box{};
    if (b < looked_.size()) grown_ = std::max(grown_, growth_of(looked_[b], reach_[b]));
}

bool Partition::is_out_of_date(double grown) const {
    // Two bodies may come nearer to each other by twice as much.
    return looked_.empty() || !(2 * std::max(grown, grown_) <= spare());
}

void Partition::note_looked() {
    looked_ = reach_;
    grown_ = 0;
}

void Partition::list_measured(const Scene& scene) {
    for (Measured& m : measured_) m = {{}, {}, m.revision + 1};
    for (std::uint32_t b = 0; b < scene.bodies.size; ++b) {
        if (!facts_[b].active || !facts_[b].on_device) continue;
        Measured& m = measured_[b < owners_.size() ? owners_[b] : b % parts()];
        m.bodies.push_back(b);
        m.more.push_back(reach_beyond_points(scene.bodies[b], scene.plan->settings));
    }
    measures_ = std::ranges::any_of(measured_, [](const Measured& m) { return !m.bodies.empty(); });
}

void Partition::look_around(std::uint32_t part) {
    near_[part] = seen_from(part, spare(), &loads_[part]);
}

double Partition::worst_load() const {
    double worst = 0;
    for (std::uint32_t part = 0; part < parts(); ++part)
        worst = std::max(worst, loads_[part] / shares_[part]);
    return worst;
}

bool Partition::cut(const Scene& scene) {
    const bool same_bodies = planned_ == scene.plan->revision ||
                             std::ranges::equal(scene.ids, known_);
    planned_ = scene.plan->revision;
    note_looked();
    if (same_bodies && worst_load() <= constants::uneven_parts * worst_at_first_) return false;
    owners_before_ = owners_;
    // Ghosts are work, too: parts that see more of them get less.
    std::vector<double> shares = shares_;
    for (std::uint32_t round = 0; round < constants::cut_rounds; ++round) {
        divide(shares);
        double all = 0, wanted = 0;
        for (std::uint32_t part = 0; part < parts(); ++part) {
            look_around(part);
            all += loads_[part];
            wanted += shares_[part];
        }
        for (std::uint32_t part = 0; part < parts(); ++part)
            if (loads_[part] > 0) shares[part] *= all * shares_[part] / (wanted * loads_[part]);
    }
    worst_at_first_ = worst_load();
    known_.assign(scene.ids.begin(), scene.ids.end());
    list_measured(scene);
    return true;
}

void Partition::divide(const std::vector<double>& shares) {
    std::vector<WeightedPoint> points(facts_.size());
    Vec3d last;
    double extents = 0;
    for (std::uint32_t b = 0; b < facts_.size(); ++b) {
        const Box& box = reach_[b];
        extents += box.extent();
        // Bodies that take no part go with the one before them.
        if (!box.empty()) last = box.center();
        points[b] = {last, box.empty() ? 0 : facts_[b].weight};
    }
    mean_extent_ = extents / std::max<double>(1, static_cast<double>(facts_.size()));
    owners_ = divide_space(points, shares);
    owned_.assign(parts(), {});
    for (std::uint32_t b = 0; b < facts_.size(); ++b)
        if (facts_[b].exists)
            owned_[owners_[b]].push_back({.body = b,
                                          .cell = 0,
                                          .weight = facts_[b].active ? facts_[b].weight : 0,
                                          .moves = facts_[b].moves});
    const std::vector<double> equal(constants::part_cells, 1.0);
    for (std::vector<Owned>& owned : owned_) {
        std::vector<WeightedPoint> places;
        places.reserve(owned.size());
        for (const Owned& own : owned) places.push_back(points[own.body]);
        const std::vector<std::uint32_t> cells = divide_space(places, equal);
        for (std::size_t k = 0; k < owned.size(); ++k) owned[k].cell = cells[k];
    }
}

BodySet Partition::residents(std::uint32_t part) const {
    return seen_from(part, constants::spare_reach * mean_extent_, nullptr);
}

BodySet Partition::seen_from(std::uint32_t part, double more, double* load) const {
    BodySet seen(facts_.size(), 0);
    if (owned_.empty() || owners_.size() != facts_.size()) return seen;
    Region region(constants::part_cells, mean_extent_);
    double weight = 0;
    for (const Owned& own : owned_[part]) {
        seen[own.body] = 1;
        weight += own.weight;
        if (own.moves) region.add(own.cell, reach_[own.body]);
    }
    region.close(more);
    for (std::uint32_t b = 0; b < facts_.size(); ++b) {
        // Pairs of two moving bodies belong to the lower one of their parts.
        const bool may_be_pair = owners_[b] > part || (owners_[b] < part && !facts_[b].moves);
        if (!may_be_pair || !region.meets(reach_[b])) continue;
        seen[b] = 1;
        weight += facts_[b].weight;
    }
    if (load != nullptr) *load = weight;
    return seen;
}

}  // namespace pierce
