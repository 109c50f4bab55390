#include "pierce/partitioned_backend.hpp"

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

#include "core/base/crew.hpp"
#include "core/body/body_view.hpp"
#include "core/body/fetched_place.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/partition/contact_order.hpp"
#include "core/partition/memory_parts.hpp"
#include "core/partition/merged_lists.hpp"
#include "core/partition/part_scene.hpp"
#include "core/partition/part_stats.hpp"
#include "core/partition/partition.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/trace/ray.hpp"
#include "pierce/constants.hpp"
#include "pierce/contact.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/error.hpp"
#include "pierce/explain.hpp"
#include "pierce/plan.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {
namespace {

std::vector<double> shares_of(const std::vector<Part>& parts) {
    std::vector<double> shares;
    shares.reserve(parts.size());
    for (const Part& part : parts) shares.push_back(part.share);
    return shares;
}

class PartitionedBackend : public Backend {
public:
    explicit PartitionedBackend(std::vector<Part> parts)
        : partition_(shares_of(parts)), crew_(parts.size()) {
        for (Part& part : parts) {
            const auto number = static_cast<std::uint32_t>(parts_.size());
            parts_.push_back({.backend = std::move(part.backend),
                              .scene = PartScene(number),
                              .stats = {},
                              .number = number,
                              .measured = 0,
                              .grown = 0});
        }
    }

    std::string description() const override {
        std::string text = std::to_string(parts_.size()) + " parts";
        for (const Share& part : parts_) text += "; " + part.backend->description();
        return text;
    }
    bool runs_on_device() const override {
        return std::ranges::all_of(parts_, &PartitionedBackend::is_on_device);
    }
    bool calls_pair_filters() const override {
        return std::ranges::all_of(
            parts_, [](const Share& part) { return part.backend->calls_pair_filters(); });
    }
    std::vector<PlannedPart> parts() const override {
        std::vector<PlannedPart> all;
        all.reserve(parts_.size());
        for (const Share& part : parts_) {
            const auto [own, ghosts, triangles] = part.scene.sizes();
            all.push_back({.backend = part.backend->description(),
                           .on_device = is_on_device(part),
                           .share = partition_.shares()[part.number],
                           .bodies = own,
                           .ghosts = ghosts,
                           .triangles = triangles});
        }
        return all;
    }
    bool certificates_pay() const override {
        return std::ranges::all_of(
            parts_, [](const Share& part) { return part.backend->certificates_pay(); });
    }

    void set_stream(void* stream) override {
        for (Share& part : parts_) part.backend->set_stream(stream);
    }

    DeviceContacts device_contacts(std::uint32_t part, std::uint32_t worlds) override {
        if (part >= parts_.size())
            throw InputError("there is no part " + std::to_string(part) + " among " +
                             std::to_string(parts_.size()));
        return parts_[part].backend->device_contacts(0, worlds);
    }

    void step(const Scene& whole, StepStats& stats) override {
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

    bool step_at_rest() override {
        if (std::ranges::any_of(parts_, &PartitionedBackend::is_on_device)) return false;
        for (Share& part : parts_)
            if (!part.backend->step_at_rest()) return false;
        merged_ = false;
        return true;
    }

    View<const Contact> contacts() const override {
        merge();
        return view_of(contacts_);
    }
    View<const Pair> pairs() const override {
        merge();
        return view_of(pairs_);
    }

    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override {
        const std::uint32_t part = part_of(bodies, pair);
        if (part == parts_.size()) return {};
        return parts_[part].backend->certificate(bodies, pair, side, vertex);
    }

    /// Of several devices, each reads the memory of all.
    double measure_reach(View<const BodyView> bodies, View<const std::uint32_t> some,
                         View<const double> more, bool anew) override {
        if (!runs_on_device()) return Backend::measure_reach(bodies, some, more, anew);
        parts_[0].measured = 0;  // it measures its own bodies anew
        return parts_[0].backend->measure_reach(bodies, some, more, true);
    }
    void fetch_reach(View<const std::uint32_t> some, View<Box> reach) override {
        if (!runs_on_device()) return Backend::fetch_reach(some, reach);
        parts_[0].backend->fetch_reach(some, reach);
    }
    View<const FetchedPlace> fetch_places(View<const BodyView> bodies,
                                          View<const std::uint32_t> some) override {
        if (!runs_on_device()) return Backend::fetch_places(bodies, some);
        return parts_[0].backend->fetch_places(bodies, some);
    }

    void fetch_bodies(View<BodyView> bodies) const override {
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
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const override {
        fetch_seen_of(partition_.owners(), ids, seen);
    }

    StepMemory memory() const override {
        return given_ ? *given_ : join_memory(memories(), partition_.owners());
    }
    void remember(const StepMemory& memory) override { given_ = memory; }

    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        outside_->closest_hits(bodies, rays, hits);
    }

private:
    struct Share {
        std::unique_ptr<Backend> backend;
        mutable PartScene scene;
        StepStats stats;
        std::uint32_t number = 0;
        std::uint64_t measured = 0;  ///< revision of the list that the backend knows
        double grown = 0;            ///< [length] the most that what it measures has
    };

    static bool is_on_device(const Share& part) { return part.backend->runs_on_device(); }

    /// Which part looks at a pair; one more than there are if none does.
    std::uint32_t part_of(View<const BodyView> bodies, Pair pair) const {
        return part_of_pair(bodies[pair.a].motion, partition_.pair_part(pair.a),
                            bodies[pair.b].motion, partition_.pair_part(pair.b));
    }

    void find_contacts(const Scene& whole, StepStats& stats) {
        const bool anew = revision_ != whole.plan->revision;
        revision_ = whole.plan->revision;
        keys_ = {whole.world_begins.size > 0};
        const bool moved = look_around(whole, anew);
        std::optional<StepMemory> memory = std::exchange(given_, std::nullopt);
        const auto show_to = [&](Share& part) {
            part.scene.show(whole, partition_, anew || moved);
        };
        // How far predictions look depends on where bodies were in the last step, also ghosts.
        const bool predicts = whole.plan->settings.temporal == Temporal::paper;
        const bool hands_out = memory || moved || predicts;
        if (hands_out) {
            for (Share& part : parts_) show_to(part);
            hand_out(whole, std::move(memory), moved);
        }
        for_each_part(true, [&](Share& part) {
            const auto begin = std::chrono::steady_clock::now();
            part.stats = {};
            if (!hands_out) show_to(part);
            part.backend->step(part.scene.scene(whole), part.stats);
            part.stats.milliseconds = std::chrono::duration<double, std::milli>(
                                          std::chrono::steady_clock::now() - begin)
                                          .count();
        });
        std::vector<StepStats> of_parts;
        of_parts.reserve(parts_.size());
        for (const Share& part : parts_) of_parts.push_back(part.stats);
        add_parts(of_parts, stats);
    }

    /// Finds out what is near each part. Returns true if bodies have other owners.
    bool look_around(const Scene& whole, bool anew) {
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
                if (!m.bodies.empty())
                    part.backend->fetch_reach(view_of(m.bodies), partition_.reach());
            });
        for_each_part(whole.bodies.size >= constants::many_bodies,
                      [&](Share& part) { partition_.look_around(part.number); });
        return partition_.cut(whole);
    }

    void measure(const Scene& whole, Share& part) {
        const Measured& m = partition_.measured(part.number);
        part.grown = m.bodies.empty() ? 0
                                      : part.backend->measure_reach(whole.bodies, view_of(m.bodies),
                                                                    view_of(m.more),
                                                                    part.measured != m.revision);
        part.measured = m.revision;
    }

    /// What is remembered goes with the pairs. `given`: what all parts are to remember, if that is
    /// not what they do. `moved`: bodies have other owners.
    void hand_out(const Scene& whole, std::optional<StepMemory> given, bool moved) {
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
            part.backend->remember(part_of_memory(*given, [&](std::uint64_t key) {
                const Pair pair = keys_.pair(key);
                return pair.a < whole.bodies.size && pair.b < whole.bodies.size &&
                       part_of(whole.bodies, pair) == part.number;
            }));
            part.scene.copy_seen(whole);
        }
    }

    std::vector<StepMemory> memories() const {
        std::vector<StepMemory> all;
        all.reserve(parts_.size());
        for (const Share& part : parts_) all.push_back(part.backend->memory());
        return all;
    }

    void fetch_seen_of(std::span<const std::uint32_t> owners, View<const BodyId> ids,
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
    void for_each_part(bool at_once, const Run& run) {
        if (at_once) return crew_.run([&](std::size_t p) { run(parts_[p]); });
        for (Share& part : parts_) run(part);
    }

    /// Joins the parts' lists, each of which is sorted by pair.
    void merge() const {
        if (merged_) return;
        merged_ = true;
        contacts_.clear();
        pairs_.clear();
        std::vector<View<const Contact>> of_rays, of_sheets;
        std::vector<View<const Pair>> pairs;
        for (const Share& part : parts_) {
            const View<const Contact> all = part.backend->contacts();
            const View<const BodyView> bodies = part.scene.bodies();
            const auto by_rays = static_cast<std::uint32_t>(
                std::partition_point(all.begin(), all.end(),
                                     [&](const Contact& c) { return is_by_ray(c, bodies); }) -
                all.begin());
            of_rays.push_back({all.data, by_rays});
            of_sheets.push_back({all.data + by_rays, all.size - by_rays});
            pairs.push_back(part.backend->pairs());
        }
        const auto key_of = [&](std::size_t p, const Pair& pair) {
            return keys_.key(parts_[p].scene.bodies(), pair.a, pair.b);
        };
        const auto key_of_contact = [&](std::size_t p, const Contact& c) {
            return key_of(p, {c.a.index, c.b.index});
        };
        append_merged(of_rays, key_of_contact, contacts_);
        append_merged(of_sheets, key_of_contact, contacts_);
        append_merged(pairs, key_of, pairs_);
    }

    Partition partition_;
    std::vector<Share> parts_;
    Crew crew_;
    std::unique_ptr<Backend> outside_ = bvh_backend();
    std::uint64_t revision_ = 0;
    stages::PairKeys keys_;
    std::optional<StepMemory> given_;  ///< for the next step
    mutable bool merged_ = true;
    mutable std::vector<Contact> contacts_;
    mutable std::vector<Pair> pairs_;
};

}  // namespace

std::unique_ptr<Backend> partitioned_backend(std::vector<Part> parts) {
    if (parts.empty()) throw InputError("a partitioned backend needs at least one part");
    for (const Part& part : parts) {
        if (!part.backend) throw InputError("a part of a partitioned backend has no backend");
        if (!(part.share > 0) || std::isinf(part.share))
            throw InputError("the share of a part must be positive and finite");
    }
    return std::make_unique<PartitionedBackend>(std::move(parts));
}

std::unique_ptr<Backend> partitioned_backend(
    std::uint32_t parts, int threads,
    const std::function<std::unique_ptr<Backend>(int threads)>& make) {
    if (parts == 0) return partitioned_backend({});
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
