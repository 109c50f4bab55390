#pragma once

#include <cstdint>

#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"

namespace pierce {

/// Decides when a refitted tree should be rebuilt, by rent or buy: it adds up the triangle tests
/// that rays needed beyond those of the fresh tree, and asks for a rebuild once these tests would
/// have paid for one. This costs at most twice as much as the best schedule chosen in hindsight.
/// The policy uses counts, not clocks, so that it decides the same in every run.
class RefitPolicy {
public:
    /// A tree was built or rebuilt.
    PIERCE_HD void restart() { *this = {}; }

    /// Rays were traced through the tree and needed this many triangle tests.
    PIERCE_HD void record(std::uint64_t rays, std::uint64_t tests) {
        if (baseline_rays_ < constants::rebuild_baseline_rays) {
            baseline_rays_ += rays;
            baseline_tests_ += tests;
            return;
        }
        const double fresh = static_cast<double>(baseline_tests_) /
                             static_cast<double>(baseline_rays_);
        excess_ += static_cast<double>(tests) - fresh * static_cast<double>(rays);
        if (excess_ < 0) excess_ = 0;
    }

    PIERCE_HD bool should_rebuild(std::uint32_t triangle_count) const {
        return excess_ > constants::rebuild_cost * static_cast<double>(triangle_count);
    }

private:
    std::uint64_t baseline_rays_ = 0, baseline_tests_ = 0;
    double excess_ = 0;
};

}  // namespace pierce
