#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/crew.hpp"
#include "core/body/fetched_place.hpp"
#include "core/partition/part_scene.hpp"
#include "core/partition/partition.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/step_memory.hpp"
#include "pierce/backend.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {

/// A world that several backends share: each runs the steps of one part of the bodies. On the host,
/// a part in which nothing has changed rests.
class PartitionedBackend : public Backend {
public:
    /// Parts run at the same time, each on a thread of its own, or one after the other.
    enum class Order { at_once, in_turn };

    explicit PartitionedBackend(std::vector<Part> parts, Order order = Order::at_once);

    /// Sets which part owns each body, from the next step on, instead of a cut of space.
    void set_owners(std::vector<std::uint32_t> owners) { partition_.set_owners(std::move(owners)); }
    /// Gives a part's backend away. Nothing else may be called then.
    std::unique_ptr<Backend> release(std::uint32_t part) { return std::move(parts_[part].backend); }

    std::string description() const override;
    bool runs_on_device() const override;
    bool calls_pair_filters() const override;
    std::vector<PlannedPart> parts() const override;
    bool certificates_pay() const override;
    void set_stream(void* stream) override;
    DeviceContacts device_contacts(std::uint32_t part, std::uint32_t worlds) override;

    void step(const Scene& whole, StepStats& stats) override;
    bool can_rest() const override;
    void step_at_rest() override;
    View<const Contact> contacts() const override;
    View<const Pair> pairs() const override;
    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override;

    double measure_reach(View<const BodyView> bodies, View<const std::uint32_t> some,
                         View<const double> more, bool anew) override;
    void fetch_reach(View<const std::uint32_t> some, View<Box> reach) override;
    View<const FetchedPlace> fetch_places(View<const BodyView> bodies,
                                          View<const std::uint32_t> some) override;
    void fetch_bodies(View<BodyView> bodies) const override;
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const override;

    StepMemory memory() const override;
    void remember(const StepMemory& memory) override;
    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override;

private:
    struct Share {
        std::unique_ptr<Backend> backend;
        mutable PartScene scene;
        StepStats stats;
        std::uint32_t number = 0;
        std::uint64_t measured = 0;  ///< revision of the list that the backend knows
        double grown = 0;            ///< [length] the most that what it measures has
        bool was_still = false;      ///< nothing had changed in the last step
    };

    static bool runs_there(const Share& part) { return part.backend->runs_on_device(); }
    std::uint32_t part_of(View<const BodyView> bodies, Pair pair) const;

    void find_contacts(const Scene& whole, StepStats& stats);
    void step_part(const Scene& whole, Share& part, bool is_still);
    bool look_around(const Scene& whole, bool anew);
    void measure(const Scene& whole, Share& part);
    void hand_out(const Scene& whole, std::optional<StepMemory> given, bool moved);
    std::vector<StepMemory> memories() const;
    void fetch_seen_of(std::span<const std::uint32_t> owners, View<const BodyId> ids,
                       View<const View<SeenPatch>> seen) const;
    template <class Run>
    void for_each_part(bool at_once, const Run& run);
    void merge() const;

    Partition partition_;
    std::vector<Share> parts_;
    Order order_;
    Crew crew_;
    std::unique_ptr<Backend> outside_;
    std::uint64_t revision_ = 0;
    stages::PairKeys keys_;
    std::optional<StepMemory> given_;  ///< for the next step
    void* stream_ = nullptr;           ///< the caller's
    mutable bool merged_ = true;
    mutable std::vector<Contact> contacts_;
    mutable std::vector<Pair> pairs_;
};

}  // namespace pierce
