#include "core/partition/resting_backend.hpp"

#include <string>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/partition/partitioned_backend.hpp"
#include "core/partition/quiet_bodies.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/trace/ray.hpp"
#include "pierce/contact.hpp"
#include "pierce/explain.hpp"
#include "pierce/min_max.hpp"
#include "pierce/plan.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {
namespace {

constexpr std::uint32_t awake = 0, at_rest = 1;  ///< parts; the lower one has pairs of both

class RestingBackend : public Backend {
public:
    RestingBackend(std::function<std::unique_ptr<Backend>()> make, const RestRules& rules)
        : make_(std::move(make)),
          rules_(rules),
          one_(make_()),
          description_(one_->description()),
          patience_(rules.patience) {}

    std::string description() const override { return description_; }
    bool certificates_pay() const override { return now().certificates_pay(); }

    void step(const Scene& scene, StepStats& stats) override {
        try {
            follow(scene);
        } catch (...) {
            start_over();
            throw;
        }
        now().step(scene, stats);
        stats.part_milliseconds.clear();  // of parts that the caller knows nothing of
    }
    bool can_rest() const override { return now().can_rest(); }
    void step_at_rest() override {
        quiet_.note({});
        now().step_at_rest();
    }
    View<const Contact> contacts() const override { return now().contacts(); }
    std::shared_ptr<const Contact> keep_contacts() override { return now().keep_contacts(); }
    View<const Pair> pairs() const override { return now().pairs(); }
    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override {
        return now().certificate(bodies, pair, side, vertex);
    }
    void fetch_bodies(View<BodyView> bodies) const override { now().fetch_bodies(bodies); }
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const override {
        now().fetch_seen(ids, seen);
    }
    StepMemory memory() const override { return now().memory(); }
    void remember(const StepMemory& memory) override { now().remember(memory); }
    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        now().closest_hits(bodies, rays, hits);
    }

private:
    Backend& now() const {
        if (parts_) return *parts_;
        if (!one_) one_ = make_();
        return *one_;
    }
    /// After memory has run out where backends are exchanged: there are no contacts, and nothing is
    /// remembered.
    void start_over() {
        one_.reset();
        parts_.reset();
        owners_.clear();
        planned_ = 0;
    }

    /// Decides whether bodies at rest are a part in this step, and which bodies these are.
    void follow(const Scene& scene) {
        if (planned_ != scene.plan->revision) {
            planned_ = scene.plan->revision;
            join();
            quiet_ = QuietBodies(scene.bodies.size, rules_.steps);
        }
        quiet_.note(scene.changed);
        if (scene.bodies.size < rules_.bodies || !may_keep_contacts(*scene.plan, scene.pair_filter))
            return join();
        note_waste(scene.changed);
        if (waste_ < std::uint64_t{patience_} * scene.bodies.size) return;
        waste_ = 0;
        if (2 * quiet_.count() < scene.bodies.size) return join();
        divide(scene);
    }

    /// Counts the bodies at rest that this step looks at, and those that it does not.
    void note_waste(View<const std::uint32_t> changed) {
        bool wakes = !parts_;
        for (const std::uint32_t b : changed) wakes = wakes || owners_[b] == at_rest;
        const std::uint32_t saved = wakes ? 0 : min_of(resting_, quiet_.count());
        waste_ += quiet_.count() - saved;
        saved_ += saved;
    }
    /// Judges the last choice of parts.
    void judge() {
        const bool pays = saved_ >= std::uint64_t{rules_.patience} * owners_.size();
        patience_ = pays ? max_of(patience_ / 2, rules_.patience)
                         : min_of(2 * patience_, rules_.most_patience);
        saved_ = 0;
    }

    void divide(const Scene& scene) {
        std::vector<std::uint32_t> owners(scene.bodies.size);
        for (std::uint32_t b = 0; b < scene.bodies.size; ++b)
            owners[b] = quiet_.is_quiet(b) ? at_rest : awake;
        if (parts_ && owners == owners_) return;
        if (!parts_) {
            const StepMemory memory = now().memory();
            std::vector<Part> parts;
            parts.push_back({.backend = make_()});
            parts.push_back({.backend = std::move(one_)});
            parts_ = std::make_unique<PartitionedBackend>(std::move(parts),
                                                          PartitionedBackend::Order::in_turn);
            parts_->remember(memory);
        }
        if (!owners_.empty()) judge();
        owners_ = owners;
        resting_ = quiet_.count();
        parts_->set_owners(std::move(owners));
    }

    /// All bodies are one part again.
    void join() {
        waste_ = 0;
        if (!parts_) return;
        judge();
        owners_.clear();
        const StepMemory memory = parts_->memory();
        one_ = parts_->release(at_rest);
        parts_.reset();
        one_->remember(memory);
    }

    std::function<std::unique_ptr<Backend>()> make_;
    RestRules rules_;
    mutable std::unique_ptr<Backend> one_;       ///< null: parts_ has it, or it is to be made
    std::unique_ptr<PartitionedBackend> parts_;  ///< null: there is one part
    std::string description_;
    std::uint64_t planned_ = 0;  ///< revision of the plan of the last step
    QuietBodies quiet_;
    std::vector<std::uint32_t> owners_;  ///< of the parts; empty: there is one
    std::uint32_t resting_ = 0;          ///< bodies of the part at rest
    /// [bodies * steps] at rest: looked at since parts could last be chosen anew, and not looked at
    /// since they were.
    std::uint64_t waste_ = 0, saved_ = 0;
    std::uint32_t patience_;  ///< [steps] of all bodies, which waste_ must reach
};

}  // namespace

std::unique_ptr<Backend> resting_backend(std::function<std::unique_ptr<Backend>()> make,
                                         const RestRules& rules) {
    return std::make_unique<RestingBackend>(std::move(make), rules);
}

}  // namespace pierce
