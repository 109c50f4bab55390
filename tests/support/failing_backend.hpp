#pragma once

#include <stdexcept>
#include <string>

#include "pierce/reference_backends.hpp"
#include "support/forwarding_backend.hpp"

namespace pierce::test {

/// Throws in its third step, unless it is not to fail.
class FailingBackend : public ForwardingBackend {
public:
    explicit FailingBackend(bool fails = true) : ForwardingBackend(bvh_backend()), fails_(fails) {}
    std::string description() const override { return "fails"; }
    void step(const Scene& scene, StepStats& stats) override {
        if (++steps_ == 3 && fails_) throw std::runtime_error("the device is gone");
        ForwardingBackend::step(scene, stats);
    }

private:
    bool fails_;
    int steps_ = 0;
};

}  // namespace pierce::test
