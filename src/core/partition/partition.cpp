#include "core/partition/partition.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/body/body_view.hpp"
#include "core/body/reach.hpp"
#include "core/partition/body_reach.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

bool is_on_device(const BodyView& body) {
    return body.device_positions != nullptr || body.device_pose.exists();
}

}  // namespace

Partition::Partition(std::vector<double> shares)
    : shares_(std::move(shares)),
      grown_(shares_.size(), 0),
      measured_(shares_.size()),
      near_(shares_.size()),
      loads_(shares_.size(), 0) {}

void Partition::begin(const Scene& scene, bool anew) {
    bool others_are_measured = anew;
    if (anew) {
        facts_.assign(scene.bodies.size, {});
        reach_.assign(scene.bodies.size, {});
        looked_.clear();
        noted_.resize(scene.bodies.size);
        std::iota(noted_.begin(), noted_.end(), 0u);
    } else {
        noted_.assign(scene.changed.begin(), scene.changed.end());
    }
    for (const std::uint32_t b : noted_) {
        const bool was_on_device = facts_[b].on_device;
        note(scene, b);
        others_are_measured = others_are_measured || was_on_device || facts_[b].on_device;
    }
    if (others_are_measured) list_measured(scene);
}

void Partition::note(const Scene& scene, std::uint32_t b) {
    const BodyView& body = scene.bodies[b];
    const bool exists = static_cast<bool>(scene.ids[b]);
    facts_[b] = {.weight = static_cast<float>(body.mesh.triangles.size),
                 .exists = exists,
                 .active = exists && body.active,
                 .moves = body.motion != Motion::fixed,
                 .on_device = is_on_device(body),
                 .is_ghost = body.part != scene.part};
}

void Partition::measure_on_host(const Scene& scene, std::uint32_t part) {
    const std::size_t first = noted_.size() * part / parts(),
                      last = noted_.size() * (part + 1) / parts();
    for (std::size_t k = first; k < last; ++k) {
        const std::uint32_t b = noted_[k];
        reach_[b] = facts_[b].active && !facts_[b].on_device
                        ? reach_on_host(scene.bodies[b], scene.plan->settings)
                        : Box{};
        if (b < looked_.size())
            grown_[part] = std::max(grown_[part], growth_of(looked_[b], reach_[b]));
    }
}

bool Partition::is_out_of_date(double grown) const {
    // Two bodies may come nearer to each other by twice as much.
    for (const double of_part : grown_) grown = std::max(grown, of_part);
    return given_ || looked_.empty() || !(2 * grown <= spare());
}

void Partition::note_looked() {
    looked_ = reach_;
    grown_.assign(parts(), 0);
}

void Partition::list_measured(const Scene& scene) {
    for (Measured& m : measured_) m = {{}, {}, m.revision + 1};
    for (std::uint32_t b = 0; b < scene.bodies.size; ++b) {
        if (!facts_[b].active || !facts_[b].on_device) continue;
        Measured& m = measured_[b < owners().size() ? owners()[b] : b % parts()];
        m.bodies.push_back(b);
        m.more.push_back(reach_beyond_points(scene.bodies[b], scene.plan->settings));
    }
    measures_ = std::ranges::any_of(measured_, [](const Measured& m) { return !m.bodies.empty(); });
}

void Partition::look_around(std::uint32_t part) {
    near_[part] = space_.seen_from(part, facts_, reach_, spare(), &loads_[part]);
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
    if (given_) {
        owners_before_.assign(owners().begin(), owners().end());
        space_.assign(facts_, reach_, std::move(*given_), parts());
        given_.reset();
        is_given_ = true;
        for (std::uint32_t part = 0; part < parts(); ++part) look_around(part);
        return note_owners(scene);
    }
    if (same_bodies && is_given_) return false;
    is_given_ = false;
    if (same_bodies && worst_load() <= constants::uneven_parts * worst_at_first_) return false;
    owners_before_.assign(owners().begin(), owners().end());
    std::vector<double> shares = shares_;
    for (std::uint32_t round = 0; round < constants::cut_rounds; ++round) {
        space_.divide(facts_, reach_, shares);
        for (std::uint32_t part = 0; part < parts(); ++part) look_around(part);
        shares = corrected_shares(std::move(shares), shares_, loads_);
    }
    worst_at_first_ = worst_load();
    return note_owners(scene);
}

bool Partition::note_owners(const Scene& scene) {
    known_.assign(scene.ids.begin(), scene.ids.end());
    list_measured(scene);
    return true;
}

BodySet Partition::residents(std::uint32_t part) const {
    return space_.seen_from(part, facts_, reach_, 2 * spare(), nullptr);
}

}  // namespace pierce
