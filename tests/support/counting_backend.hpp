#pragma once

#include <memory>
#include <utility>

#include "support/forwarding_backend.hpp"

namespace pierce::test {

/// What several backends were asked for.
struct Calls {
    int backends = 0, steps = 0, rests = 0;
};

/// Counts what it passes on.
class CountingBackend : public ForwardingBackend {
public:
    CountingBackend(std::unique_ptr<Backend> inner, Calls& calls)
        : ForwardingBackend(std::move(inner)), calls_(calls) {
        ++calls_.backends;
    }
    void step(const Scene& scene, StepStats& stats) override {
        ++calls_.steps;
        ForwardingBackend::step(scene, stats);
    }
    bool can_rest() const override { return inner().can_rest(); }
    void step_at_rest() override {
        ++calls_.rests;
        inner().step_at_rest();
    }

private:
    Calls& calls_;
};

}  // namespace pierce::test
