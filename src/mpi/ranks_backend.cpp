#include "pierce/mpi/ranks_backend.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/reach.hpp"
#include "core/body/scene.hpp"
#include "core/partition/memory_parts.hpp"
#include "core/partition/merged_lists.hpp"
#include "core/partition/part_scene.hpp"
#include "core/partition/part_stats.hpp"
#include "core/partition/partition.hpp"
#include "core/step/common/pairs.hpp"
#include "core/trace/ray.hpp"
#include "mpi/communicator.hpp"
#include "mpi/failure.hpp"
#include "mpi/items.hpp"
#include "mpi/messages.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/explain.hpp"
#include "pierce/plan.hpp"
#include "pierce/reference_backends.hpp"

namespace pierce::mpi {
namespace {

/// What a rank has found in a step.
struct RankResult {
    std::vector<Contact> by_rays, of_sheets;
    std::vector<Pair> pairs;
    StepStats stats;
};

/// The numbers of a step, but for how long stages took, and what took part in it.
struct Numbers {
    std::uint32_t status = step_ok;
    std::uint64_t triangle_tests = 0;
    double milliseconds = 0, device_milliseconds = 0, penetration_mean = 0, penetration_max = 0;
    PartScene::Sizes sizes;
};

class RanksBackend : public Backend {
public:
    RanksBackend(MPI_Comm ranks, std::unique_ptr<Backend> backend)
        : comm_(ranks),
          backend_(all_have(std::move(backend))),
          partition_(std::vector<double>(static_cast<std::size_t>(comm_.size()), 1.0)),
          scene_(static_cast<std::uint32_t>(comm_.rank())),
          certificates_pay_(all_say(backend_->certificates_pay())),
          calls_pair_filters_(all_say(backend_->calls_pair_filters())) {
        const auto on_device = static_cast<std::uint8_t>(backend_->runs_on_device());
        const std::vector<std::uint8_t> all_on_device = comm_.all_gather(on_device);
        const std::vector<std::string> descriptions = comm_.all_gather(backend_->description());
        for (std::size_t rank = 0; rank < descriptions.size(); ++rank)
            planned_.push_back(
                {.backend = descriptions[rank], .on_device = all_on_device[rank] != 0});
    }

    std::string description() const override {
        return std::to_string(comm_.size()) + " ranks; " + backend_->description();
    }
    /// All ranks have one plan.
    bool certificates_pay() const override { return certificates_pay_; }
    bool calls_pair_filters() const override { return calls_pair_filters_; }
    std::vector<PlannedPart> parts() const override { return planned_; }

    void step(const Scene& whole, StepStats& stats) override {
        contacts_.clear();
        pairs_.clear();
        try {
            find_contacts(whole, stats);
        } catch (...) {
            given_.emplace();
            revision_ = 0;  // all is looked at anew
            throw;
        }
    }

    View<const Contact> contacts() const override { return view_of(contacts_); }
    View<const Pair> pairs() const override { return view_of(pairs_); }

    /// Known for the pairs of this rank only.
    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override {
        if (part_of(bodies, pair) != part()) return {};
        return backend_->certificate(bodies, pair, side, vertex);
    }

    void fetch_bodies(View<BodyView> bodies) const override {
        const View<BodyView> here = scene_.bodies();
        backend_->fetch_bodies(here);
        for (std::uint32_t b = 0; b < here.size && b < bodies.size; ++b)
            if (here[b].active) static_cast<BodyBounds&>(bodies[b]) = here[b];
        // Of bodies that no pair here can have, nothing has been measured.
        for (std::uint32_t b = 0; b < bodies.size; ++b)
            if (bodies[b].active && !(b < here.size && here[b].active)) measure_outside(bodies[b]);
    }
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const override {
        gather_seen(partition_.owners(), ids, seen);
    }

    StepMemory memory() const override {
        return given_ ? *given_ : gathered_memory(partition_.owners());
    }
    void remember(const StepMemory& memory) override {
        contacts_.clear();
        pairs_.clear();
        given_ = memory;
    }

    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        outside_->closest_hits(bodies, rays, hits);
    }

private:
    /// Throws on all ranks if one has no backend.
    std::unique_ptr<Backend> all_have(std::unique_ptr<Backend> mine) const {
        if (!all_say(mine != nullptr)) throw InputError("a rank has no backend");
        return mine;
    }
    bool all_say(bool mine) const {
        return std::ranges::count(comm_.all_gather(static_cast<std::uint8_t>(mine)), 0) == 0;
    }
    std::uint32_t part() const { return static_cast<std::uint32_t>(comm_.rank()); }
    std::uint32_t part_of(View<const BodyView> bodies, Pair pair) const {
        const std::span<const std::uint32_t> owners = partition_.owners();
        return part_of_pair(bodies[pair.a].motion, owners[pair.a], bodies[pair.b].motion,
                            owners[pair.b]);
    }
    /// The bounds of a body in which no frame is fitted to a deforming body.
    static void measure_outside(BodyView& body) {
        if (body.motion != Motion::deforming) {
            body.world_box = placed_box(body.mesh.box, body.space).box;
            return;
        }
        Box box;
        double furthest = 0;
        for (std::uint32_t v = 0; v < body.positions.size; ++v) {
            const Vec3d at = to_double(body.positions[v]);
            box.extend(at);
            furthest = std::max(furthest, length(at - to_double(body.mesh.positions[v])));
        }
        body.fit = {};
        body.touch = constants::touch_tolerance * box.extent();
        body.world_box = body.fit_box = box.inflated(body.touch);
        body.deviation = furthest + body.touch;
    }

    template <class Run>
    void together(const Run& run) const {
        const std::exception_ptr failure = failure_of(run);
        if (any_failed(comm_, failure)) throw_failure(comm_, failure);
    }
    /// What each rank makes; throws on all ranks if one fails.
    template <class Make>
    std::vector<std::string> made_by_all(const Make& make) const {
        std::string bytes;
        together([&] { bytes = make(); });
        return comm_.all_gather(bytes);
    }

    void find_contacts(const Scene& whole, StepStats& stats) {
        const bool anew = revision_ != whole.plan->revision;
        revision_ = whole.plan->revision;
        keys_ = {whole.world_begins.size > 0};
        bool moved = false;
        together([&] {
            partition_.begin(whole, anew);
            for (std::uint32_t p = 0; p < partition_.parts(); ++p)
                partition_.measure_on_host(whole, p);
            if (!partition_.is_out_of_date(0)) return;
            for (std::uint32_t p = 0; p < partition_.parts(); ++p) partition_.look_around(p);
            moved = partition_.cut(whole);
        });
        together([&] { scene_.show(whole, partition_, anew || moved); });
        hand_out(whole, moved);
        RankResult found;
        together([&] {
            const auto begin = std::chrono::steady_clock::now();
            backend_->step(scene_.scene(whole), found.stats);
            found.stats.milliseconds = std::chrono::duration<double, std::milli>(
                                           std::chrono::steady_clock::now() - begin)
                                           .count();
        });
        share(whole, found.stats, stats);
    }

    /// What is remembered goes with the pairs.
    void hand_out(const Scene& whole, bool moved) {
        std::optional<StepMemory> given = std::exchange(given_, std::nullopt);
        // How far predictions look depends on where bodies were in the last step, also ghosts.
        bool arrivals = false;
        if (!given && whole.plan->settings.temporal == Temporal::paper) {
            const auto mine = static_cast<std::uint8_t>(!scene_.arrived().empty());
            arrivals = std::ranges::count(comm_.all_gather(mine), 1) > 0;
        }
        if (!given) {
            const std::span<const std::uint32_t> owners = moved ? partition_.owners_before()
                                                                : partition_.owners();
            if (owners.empty() || !(moved || arrivals)) return;
            given = gathered_memory(owners);
            gather_seen(owners, whole.ids, whole.seen);
        }
        together([&] {
            backend_->remember(part_of_memory(*given, [&](Pair pair) {
                return pair.a < whole.bodies.size && pair.b < whole.bodies.size &&
                       part_of(whole.bodies, pair) == part();
            }));
            scene_.copy_seen(whole);
        });
    }

    StepMemory gathered_memory(std::span<const std::uint32_t> owners) const {
        std::vector<std::string> all = made_by_all([&] {
            StepMemory mine = backend_->memory();
            return to_bytes(mine);
        });
        StepMemory joined;
        together([&] {
            std::vector<StepMemory> of_ranks;
            for (std::string& bytes : all)
                of_ranks.push_back(from_bytes<StepMemory>(std::move(bytes)));
            joined = join_memory(of_ranks, owners);
        });
        return joined;
    }

    /// How deforming bodies looked in the last step, which their owners know.
    void gather_seen(std::span<const std::uint32_t> owners, View<const BodyId> ids,
                     View<const View<SeenPatch>> seen) const {
        const auto is_told = [&](std::uint32_t b, std::uint32_t by) {
            return b < owners.size() && owners[b] == by && seen[b].size > 0;
        };
        const std::vector<std::string> all = made_by_all([&] {
            std::vector<BodyId> own(ids.begin(), ids.end());
            for (std::size_t b = 0; b < own.size(); ++b)
                if (b >= owners.size() || owners[b] != part()) own[b] = {};
            backend_->fetch_seen(view_of(std::as_const(own)), seen);
            std::string bytes;
            for (std::uint32_t b = 0; b < seen.size; ++b)
                if (is_told(b, part()))
                    append_items<SeenPatch>(bytes, {seen[b].data, seen[b].size});
            return bytes;
        });
        together([&] {
            for (std::uint32_t from = 0; from < all.size(); ++from) {
                std::size_t at = 0;
                for (std::uint32_t b = 0; b < seen.size; ++b) {
                    if (!is_told(b, from)) continue;
                    std::vector<SeenPatch> patches;
                    take_items(all[from], at, patches);
                    std::ranges::copy(patches, seen[b].begin());
                }
            }
        });
    }

    /// Tells all ranks what this one has found, and joins the lists.
    void share(const Scene& whole, const StepStats& mine, StepStats& stats) {
        const std::vector<std::string> all = made_by_all([&] { return result(whole, mine); });
        together([&] { join(whole, all, stats); });
    }
    std::string result(const Scene& whole, const StepStats& mine) const {
        const PartLists lists(backend_->contacts(), backend_->pairs(), whole.bodies);
        std::string bytes;
        const auto append = [&]<class Item>(View<const Item> list) {
            append_items<Item>(bytes, {list.data, list.size});
        };
        append(lists.by_rays);
        append(lists.of_sheets);
        append(lists.pairs);
        std::vector<std::uint32_t> counts;
        for (const auto count : added_counts()) counts.push_back(mine.*count);
        append_items<std::uint32_t>(bytes, counts);
        const std::vector<Numbers> numbers{{.status = mine.status,
                                            .triangle_tests = mine.triangle_tests,
                                            .milliseconds = mine.milliseconds,
                                            .device_milliseconds = mine.device_milliseconds,
                                            .penetration_mean = mine.penetration_mean,
                                            .penetration_max = mine.penetration_max,
                                            .sizes = scene_.sizes()}};
        append_items<Numbers>(bytes, numbers);
        append_items<StageTime>(bytes, mine.stages);
        return bytes;
    }
    void join(const Scene& whole, std::span<const std::string> results, StepStats& stats) {
        std::vector<RankResult> all;
        for (const std::string& its : results) {
            RankResult& found = all.emplace_back();
            std::size_t at = 0;
            take_items(its, at, found.by_rays);
            take_items(its, at, found.of_sheets);
            take_items(its, at, found.pairs);
            std::vector<std::uint32_t> counts;
            take_items(its, at, counts);
            for (std::size_t k = 0; k < counts.size(); ++k)
                found.stats.*added_counts()[k] = counts[k];
            std::vector<Numbers> of_rank;
            take_items(its, at, of_rank);
            const Numbers& its_numbers = of_rank.at(0);
            found.stats.status = its_numbers.status;
            found.stats.triangle_tests = its_numbers.triangle_tests;
            found.stats.milliseconds = its_numbers.milliseconds;
            found.stats.device_milliseconds = its_numbers.device_milliseconds;
            found.stats.penetration_mean = its_numbers.penetration_mean;
            found.stats.penetration_max = its_numbers.penetration_max;
            PlannedPart& planned = planned_[all.size() - 1];
            planned.bodies = its_numbers.sizes.own;
            planned.ghosts = its_numbers.sizes.ghosts;
            planned.triangles = its_numbers.sizes.triangles;
            take_items(its, at, found.stats.stages);
        }
        std::vector<PartLists> of_all;
        std::vector<StepStats> of_ranks;
        for (const RankResult& found : all) {
            of_all.emplace_back(view_of(found.by_rays), view_of(found.of_sheets),
                                view_of(found.pairs));
            of_ranks.push_back(found.stats);
        }
        const auto key_of = [&](std::size_t, const Pair& pair) {
            return keys_.key(whole.bodies, pair.a, pair.b);
        };
        append_merged(of_all, key_of, contacts_, pairs_);
        add_parts(of_ranks, stats);
    }

    Communicator comm_;
    std::unique_ptr<Backend> backend_;
    Partition partition_;
    mutable PartScene scene_;
    bool certificates_pay_, calls_pair_filters_;
    std::unique_ptr<Backend> outside_ = bvh_backend();
    std::uint64_t revision_ = 0;
    stages::PairKeys keys_;
    std::optional<StepMemory> given_;   ///< for the next step
    std::vector<PlannedPart> planned_;  ///< of all ranks, with the sizes of the last step
    std::vector<Contact> contacts_;
    std::vector<Pair> pairs_;
};

}  // namespace

std::unique_ptr<Backend> ranks_backend(MPI_Comm ranks, std::unique_ptr<Backend> backend) {
    return std::make_unique<RanksBackend>(ranks, std::move(backend));
}

}  // namespace pierce::mpi
