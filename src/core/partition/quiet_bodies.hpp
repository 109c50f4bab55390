#pragma once

#include <cstdint>
#include <vector>

#include "core/device/view.hpp"

namespace pierce {

/// Which bodies have not changed in the last few steps. A step takes time for those that change in
/// it.
class QuietBodies {
public:
    QuietBodies() = default;
    /// All of them have just changed. `steps`: after how many steps a body is quiet; at least 1.
    QuietBodies(std::uint32_t bodies, std::uint32_t steps)
        : last_(bodies, 0), changed_in_(steps, 0) {
        changed_in_[0] = bodies;
    }

    /// Takes note of a step. `changed`: each body at most once.
    void note(View<const std::uint32_t> changed) {
        ++step_;
        std::uint32_t& now = changed_in_[step_ % changed_in_.size()];
        count_ += now;  // they changed last before as many steps
        now = 0;
        for (const std::uint32_t b : changed) {
            --(is_quiet(b) ? count_ : changed_in_[last_[b] % changed_in_.size()]);
            last_[b] = step_;
            ++now;
        }
    }
    bool is_quiet(std::uint32_t body) const { return step_ - last_[body] >= changed_in_.size(); }
    std::uint32_t count() const { return count_; }

private:
    std::uint64_t step_ = 0;
    std::vector<std::uint64_t> last_;  ///< per body, the step in which it last changed
    /// How many bodies changed last in each of the last steps.
    std::vector<std::uint32_t> changed_in_;
    std::uint32_t count_ = 0;
};

}  // namespace pierce
