#pragma once

#include <memory>
#include <string>
#include <utility>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/trace/ray.hpp"
#include "pierce/backend.hpp"
#include "pierce/explain.hpp"
#include "pierce/step_stats.hpp"

namespace pierce::test {

/// Passes what a step needs on to another backend. It takes every step, also where nothing has
/// changed.
class ForwardingBackend : public Backend {
public:
    explicit ForwardingBackend(std::unique_ptr<Backend> inner) : inner_(std::move(inner)) {}

    std::string description() const override { return inner_->description(); }
    void step(const Scene& scene, StepStats& stats) override { inner_->step(scene, stats); }
    View<const Contact> contacts() const override { return inner_->contacts(); }
    View<const Pair> pairs() const override { return inner_->pairs(); }
    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override {
        return inner_->certificate(bodies, pair, side, vertex);
    }
    void fetch_bodies(View<BodyView> bodies) const override { inner_->fetch_bodies(bodies); }
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const override {
        inner_->fetch_seen(ids, seen);
    }
    StepMemory memory() const override { return inner_->memory(); }
    void remember(const StepMemory& memory) override { inner_->remember(memory); }
    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        inner_->closest_hits(bodies, rays, hits);
    }

protected:
    Backend& inner() const { return *inner_; }

private:
    std::unique_ptr<Backend> inner_;
};

}  // namespace pierce::test
