#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/body/scene.hpp"
#include "pierce/box.hpp"

namespace pierce {

/// Which part owns each body of a scene, and which bodies each part has to see.
class Partition {
public:
    /// `shares`: of the work, per part.
    explicit Partition(std::vector<double> shares) : shares_(std::move(shares)) {}

    /// Follows the bodies. Space is cut anew when there are other bodies, and when a part has to
    /// see much more than after the last cut; then it returns true: bodies may have other owners.
    /// `anew`: bodies were added, removed or changed.
    bool update(const Scene& scene, bool anew);

    /// Each body's part.
    std::span<const std::uint32_t> owners() const { return owners_; }
    /// The bodies that a part owns, and those that are near enough to be a pair with one of them.
    const std::vector<bool>& near(std::uint32_t part) const { return near_[part]; }
    /// The same, but looking so much further that they are likely to be enough for later steps.
    std::vector<bool> residents(const Scene& scene, std::uint32_t part) const;

private:
    void divide(const Scene& scene);
    void look_around(const Scene& scene);
    /// The bodies of a part, and those that come within `more` [length] of its reach.
    std::vector<bool> seen_from(const Scene& scene, std::uint32_t part, double more) const;

    std::vector<double> shares_;
    std::vector<Box> boxes_;  ///< per body, of its reach; empty if it takes no part
    double mean_extent_ = 0;  ///< of these boxes
    std::vector<std::uint32_t> owners_;
    std::vector<BodyId> known_;            ///< per body, whom the owner was chosen for
    std::vector<std::vector<bool>> near_;  ///< per part
    double worst_ = 0;                     ///< the largest load of a part, for its share
    double worst_at_first_ = 0;            ///< the same after the last cut
};

}  // namespace pierce
