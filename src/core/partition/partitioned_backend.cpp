#include "core/partition/partitioned_backend.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/fetched_place.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/partition/memory_parts.hpp"
#include "core/partition/merged_lists.hpp"
#include "core/partition/part_stats.hpp"
#include "core/trace/ray.hpp"
#include "pierce/constants.hpp"
#include "pierce/contact.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/error.hpp"
#include "pierce/explain.hpp"
#include "pierce/plan.hpp"
#include "pierce/reference_backends.hpp"

namespace pierce {
namespace {

std::vector<double> shares_of(const std::vector<Part>& parts) {
    std::vector<double> shares;
    shares.reserve(parts.size());
    for (const Part& part : parts) shares.push_back(part.share);
    return shares;
}

void check_part_count(std::size_t parts) {
    if (parts == 0 || parts > most_parts)
        throw InputError("a partitioned backend has 1 to " + std::to_string(most_parts) +
                         " parts, not " + std::to_string(parts));
}

}  // namespace

PartitionedBackend::PartitionedBackend(std::vector<Part> parts, Order order)
    : partition_(shares_of(parts)),
      order_(order),
      crew_(order == Order::at_once ? parts.size() : 1),
      outside_(bvh_backend()) {
    for (Part& part : parts) {
        const auto number = static_cast<std::uint32_t>(parts_.size());
        parts_.push_back({.backend = std::move(part.backend),
                          .scene = PartScene(number),
                          .stats = {},
                          .number = number,
                          .measured = 0,
                          .grown = 0,
                          .was_still = false});
    }
}

std::string PartitionedBackend::description() const {
    std::string text = std::to_string(parts_.size()) + " parts";
    for (const Share& part : parts_) text += "; " + part.backend->description();
    return text;
}
bool PartitionedBackend::runs_on_device() const {
    return std::ranges::all_of(parts_, &PartitionedBackend::runs_there);
}
bool PartitionedBackend::calls_pair_filters() const {
    return std::ranges::all_of(
        parts_, [](const Share& part) { return part.backend->calls_pair_filters(); });
}
std::vector<PlannedPart> PartitionedBackend::parts() const {
    std::vector<PlannedPart> all;
    all.reserve(parts_.size());
    for (const Share& part : parts_) {
        const auto [own, ghosts, triangles] = part.scene.sizes();
        all.push_back({.backend = part.backend->description(),
                       .on_device = runs_there(part),
                       .share = partition_.shares()[part.number],
                       .bodies = own,
                       .ghosts = ghosts,
                       .triangles = triangles});
    }
    return all;
}
bool PartitionedBackend::certificates_pay() const {
    return std::ranges::all_of(parts_,
                               [](const Share& part) { return part.backend->certificates_pay(); });
}

void PartitionedBackend::set_stream(void* stream) {
    try {
        for (Share& part : parts_) part.backend->set_stream(stream);
    } catch (...) {
        for (Share& part : parts_) part.backend->set_stream(stream_);
        throw;
    }
    stream_ = stream;
}

DeviceContacts PartitionedBackend::device_contacts(std::uint32_t part, std::uint32_t worlds) {
    if (part >= parts_.size())
        throw InputError("there is no part " + std::to_string(part) + " among " +
                         std::to_string(parts_.size()));
    return parts_[part].backend->device_contacts(0, worlds);
}

void PartitionedBackend::step(const Scene& whole, StepStats& stats) {
    // If a part fails, there are no contacts, and the next step remembers nothing.
    merged_ = true;
    contacts_.clear();
    pairs_.clear();
    try {
        find_contacts(whole, stats);
    } catch (...) {
        given_.emplace();
        revision_ = 0;  // all is looked at anew
        throw;
    }
    merged_ = false;
}

void PartitionedBackend::remember(const StepMemory& memory) {
    merged_ = true;
    contacts_.clear();
    pairs_.clear();
    given_ = memory;
}

bool PartitionedBackend::can_rest() const {
    return std::ranges::all_of(parts_, [](const Share& part) { return part.backend->can_rest(); });
}

void PartitionedBackend::step_at_rest() {
    for (Share& part : parts_) part.backend->step_at_rest();
    merged_ = false;
}

View<const Contact> PartitionedBackend::contacts() const {
    merge();
    return view_of(contacts_);
}
View<const Pair> PartitionedBackend::pairs() const {
    merge();
    return view_of(pairs_);
}

Certificate PartitionedBackend::certificate(View<const BodyView> bodies, Pair pair,
                                            std::uint32_t side, std::uint32_t vertex) const {
    const std::uint32_t part = part_of(bodies, pair);
    if (part == parts_.size()) return {};
    return parts_[part].backend->certificate(bodies, pair, side, vertex);
}

/// Of several devices, each reads the memory of all.
double PartitionedBackend::measure_reach(View<const BodyView> bodies,
                                         View<const std::uint32_t> some, View<const double> more,
                                         bool anew) {
    if (!runs_on_device()) return Backend::measure_reach(bodies, some, more, anew);
    parts_[0].measured = 0;  // it measures its own bodies anew
    return parts_[0].backend->measure_reach(bodies, some, more, true);
}
void PartitionedBackend::fetch_reach(View<const std::uint32_t> some, View<Box> reach) {
    if (!runs_on_device()) return Backend::fetch_reach(some, reach);
    parts_[0].backend->fetch_reach(some, reach);
}
View<const FetchedPlace> PartitionedBackend::fetch_places(View<const BodyView> bodies,
                                                          View<const std::uint32_t> some) {
    if (!runs_on_device()) return Backend::fetch_places(bodies, some);
    return parts_[0].backend->fetch_places(bodies, some);
}

void PartitionedBackend::fetch_bodies(View<BodyView> bodies) const {
    for (std::uint32_t p = 0; p < parts_.size(); ++p) {
        const View<BodyView> here = parts_[p].scene.bodies();
        parts_[p].backend->fetch_bodies(here);
        for (std::uint32_t b = 0; b < here.size && b < bodies.size; ++b) {
            if (partition_.owners()[b] != p) continue;
            static_cast<BodyBounds&>(bodies[b]) = here[b];
            bodies[b].space = here[b].space;
            bodies[b].active = here[b].active;
        }
    }
}
void PartitionedBackend::fetch_seen(View<const BodyId> ids,
                                    View<const View<SeenPatch>> seen) const {
    fetch_seen_of(partition_.owners(), ids, seen);
}

StepMemory PartitionedBackend::memory() const {
    return given_ ? *given_ : join_memory(memories(), partition_.owners());
}

void PartitionedBackend::closest_hits(View<const BodyView> bodies, View<const Ray> rays,
                                      View<Hit> hits) {
    outside_->closest_hits(bodies, rays, hits);
}

/// Which part looks at a pair; one more than there are if none does.
std::uint32_t PartitionedBackend::part_of(View<const BodyView> bodies, Pair pair) const {
    return part_of_pair(bodies[pair.a].motion, partition_.pair_part(pair.a), bodies[pair.b].motion,
                        partition_.pair_part(pair.b));
}

void PartitionedBackend::find_contacts(const Scene& whole, StepStats& stats) {
    const bool anew = revision_ != whole.plan->revision;
    revision_ = whole.plan->revision;
    keys_ = {whole.world_begins.size > 0};
    const bool moved = look_around(whole, anew);
    std::optional<StepMemory> memory = std::exchange(given_, std::nullopt);
    const auto show_to = [&](Share& part) { part.scene.show(whole, partition_, anew || moved); };
    // How far predictions look depends on where bodies were in the last step, also ghosts.
    const bool predicts = whole.plan->settings.temporal == Temporal::paper;
    const bool hands_out = memory || moved || predicts;
    if (hands_out) {
        for (Share& part : parts_) show_to(part);
        hand_out(whole, std::move(memory), moved);
    }
    for_each_part(true, [&](Share& part) {
        if (!hands_out) show_to(part);
        step_part(whole, part, !hands_out && may_keep_contacts(*whole.plan, whole.pair_filter));
    });
    std::vector<StepStats> of_parts;
    of_parts.reserve(parts_.size());
    for (const Share& part : parts_) of_parts.push_back(part.stats);
    add_parts(of_parts, stats);
}

void PartitionedBackend::step_part(const Scene& whole, Share& part, bool is_still) {
    const auto begin = std::chrono::steady_clock::now();
    const bool was_still = std::exchange(part.was_still, part.scene.is_still());
    if (is_still && was_still && part.was_still && part.backend->can_rest()) {
        part.backend->step_at_rest();
        part.stats.stages.clear();
    } else {
        part.stats = {};
        part.backend->step(part.scene.scene(whole), part.stats);
    }
    part.stats.milliseconds = std::chrono::duration<double, std::milli>(
                                  std::chrono::steady_clock::now() - begin)
                                  .count();
}

/// Finds out what is near each part. Returns true if bodies have other owners.
bool PartitionedBackend::look_around(const Scene& whole, bool anew) {
    partition_.begin(whole, anew);
    for_each_part(partition_.noted() >= constants::many_bodies,
                  [&](Share& part) { partition_.measure_on_host(whole, part.number); });
    double grown = 0;
    if (partition_.measures()) {
        for_each_part(true, [&](Share& part) { measure(whole, part); });
        for (const Share& part : parts_) grown = std::max(grown, part.grown);
    }
    if (!partition_.is_out_of_date(grown)) return false;
    if (partition_.measures())
        for_each_part(true, [&](Share& part) {
            const Measured& m = partition_.measured(part.number);
            if (!m.bodies.empty()) part.backend->fetch_reach(view_of(m.bodies), partition_.reach());
        });
    for_each_part(whole.bodies.size >= constants::many_bodies,
                  [&](Share& part) { partition_.look_around(part.number); });
    return partition_.cut(whole);
}

void PartitionedBackend::measure(const Scene& whole, Share& part) {
    const Measured& m = partition_.measured(part.number);
    part.grown = m.bodies.empty()
                     ? 0
                     : part.backend->measure_reach(whole.bodies, view_of(m.bodies), view_of(m.more),
                                                   part.measured != m.revision);
    part.measured = m.revision;
}

/// What is remembered goes with the pairs. `given`: what all parts are to remember, if that is
/// not what they do. `moved`: bodies have other owners.
void PartitionedBackend::hand_out(const Scene& whole, std::optional<StepMemory> given, bool moved) {
    const bool arrivals = std::ranges::any_of(
        parts_, [](const Share& part) { return !part.scene.arrived().empty(); });
    if (!given) {
        const std::span<const std::uint32_t> owners = moved ? partition_.owners_before()
                                                            : partition_.owners();
        if (owners.empty() || !(moved || arrivals)) return;
        given = join_memory(memories(), owners);
        fetch_seen_of(owners, whole.ids, whole.seen);
    }
    for (Share& part : parts_) {
        part.backend->remember(part_of_memory(*given, [&](Pair pair) {
            return pair.a < whole.bodies.size && pair.b < whole.bodies.size &&
                   part_of(whole.bodies, pair) == part.number;
        }));
        part.scene.copy_seen(whole);
    }
}

std::vector<StepMemory> PartitionedBackend::memories() const {
    std::vector<StepMemory> all;
    all.reserve(parts_.size());
    for (const Share& part : parts_) all.push_back(part.backend->memory());
    return all;
}

void PartitionedBackend::fetch_seen_of(std::span<const std::uint32_t> owners,
                                       View<const BodyId> ids,
                                       View<const View<SeenPatch>> seen) const {
    for (std::uint32_t p = 0; p < parts_.size(); ++p) {
        std::vector<BodyId> own(ids.begin(), ids.end());
        for (std::size_t b = 0; b < own.size(); ++b)
            if (b >= owners.size() || owners[b] != p) own[b] = {};
        parts_[p].backend->fetch_seen(view_of(std::as_const(own)), seen);
    }
}

/// Runs all parts, at once or in turn, and throws what the first of them has thrown.
template <class Run>
void PartitionedBackend::for_each_part(bool at_once, const Run& run) {
    if (at_once && order_ == Order::at_once)
        return crew_.run([&](std::size_t p) { run(parts_[p]); });
    for (Share& part : parts_) run(part);
}

/// Joins the parts' lists, each of which is sorted by pair.
void PartitionedBackend::merge() const {
    if (merged_) return;
    contacts_.clear();
    pairs_.clear();
    std::vector<PartLists> lists;
    lists.reserve(parts_.size());
    for (const Share& part : parts_)
        lists.emplace_back(part.backend->contacts(), part.backend->pairs(), part.scene.bodies());
    append_merged(
        lists,
        [&](std::size_t p, const Pair& pair) {
            return keys_.key(parts_[p].scene.bodies(), pair.a, pair.b);
        },
        contacts_, pairs_);
    merged_ = true;
}

std::unique_ptr<Backend> partitioned_backend(std::vector<Part> parts) {
    check_part_count(parts.size());
    double sum = 0;
    for (const Part& part : parts) {
        sum += part.share;
        if (!part.backend) throw InputError("a part of a partitioned backend has no backend");
        if (!(part.share > 0) || std::isinf(part.share))
            throw InputError("the share of a part must be positive and finite");
    }
    if (std::isinf(sum)) throw InputError("the shares of all parts together must be finite");
    return std::make_unique<PartitionedBackend>(std::move(parts));
}

std::unique_ptr<Backend> partitioned_backend(
    std::uint32_t parts, int threads,
    const std::function<std::unique_ptr<Backend>(int threads)>& make) {
    check_part_count(parts);
    if (!make) throw InputError("parts need a function that makes their backends");
    const auto processors = static_cast<int>(std::thread::hardware_concurrency());
    const int all = threads == 0 ? processors : threads,
              each = threads < 0 ? threads : std::max(1, all / static_cast<int>(parts));
    std::vector<Part> equal;
    equal.reserve(parts);
    for (std::uint32_t k = 0; k < parts; ++k) equal.push_back({.backend = make(each)});
    return partitioned_backend(std::move(equal));
}

std::unique_ptr<Backend> partitioned_backend(std::vector<std::unique_ptr<Backend>> devices,
                                             std::unique_ptr<Backend> host, double share) {
    std::vector<Part> parts;
    parts.reserve(devices.size() + 1);
    for (std::unique_ptr<Backend>& device : devices)
        parts.push_back({.backend = std::move(device)});
    parts.push_back({.backend = std::move(host), .share = share});
    return partitioned_backend(std::move(parts));
}

}  // namespace pierce
