#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/partition/space_partition.hpp"
#include "pierce/box.hpp"

namespace pierce {

/// Per body: 1 if it belongs to a set of bodies, else 0.
using BodySet = std::vector<std::uint8_t>;

/// What has to be known of a body, but for what it reaches, to cut space.
struct BodyFacts {
    float weight = 0;  ///< [triangles]
    bool exists = false, active = false, moves = false, on_device = false;
    bool is_ghost = false;  ///< it belongs to a part of another scene
};

/// Space that is cut into parts by the bodies in it: whom each part owns, and what it has to see.
/// Bodies are given per number; what a body that takes no part reaches is an empty box.
class SpaceCut {
public:
    /// Cuts space anew. `shares`: of the work, per part.
    void divide(std::span<const BodyFacts> bodies, std::span<const Box> reach,
                std::span<const double> shares);

    /// The same with parts that are given: each body's owner.
    void assign(std::span<const BodyFacts> bodies, std::span<const Box> reach,
                std::vector<std::uint32_t> owners, std::uint32_t parts);

    std::uint32_t parts() const { return static_cast<std::uint32_t>(owned_.size()); }
    /// Each body's part; empty before the first divide().
    std::span<const std::uint32_t> owners() const { return owners_; }
    /// The part that counts for a body's pairs: its owner, and parts() for a ghost of the whole
    /// scene, which is itself the part of another one. Such ghosts come after that part's own
    /// bodies, so their pairs with those belong to these bodies' owners, and none has the others.
    std::uint32_t pair_part(const BodyFacts& facts, std::uint32_t body) const {
        return facts.is_ghost ? parts() : owners_[body];
    }
    /// [length] Of what bodies reach, when space was cut.
    double mean_extent() const { return mean_extent_; }

    /// The bodies of a part, and those that come within `more` [length] of its reach.
    /// `load`: where the weight of all these goes, ghosts counted in part; null: nowhere.
    BodySet seen_from(std::uint32_t part, std::span<const BodyFacts> bodies,
                      std::span<const Box> reach, double more, double* load) const;

private:
    /// A body of a part, and one of the part's cells, which are compact, too.
    struct Owned {
        std::uint32_t body = 0, cell = 0;
        float weight = 0;
    };

    /// Places of all bodies, with their weights.
    std::vector<WeightedPoint> note_places(std::span<const BodyFacts> bodies,
                                           std::span<const Box> reach);
    void list_owned(std::span<const BodyFacts> bodies, std::span<const WeightedPoint> places,
                    std::size_t parts);

    std::vector<std::uint32_t> owners_;
    std::vector<std::vector<Owned>> owned_;  ///< per part
    double mean_extent_ = 0;
};

/// The shares to ask for next: ghosts are work, too, and parts that see more of them get less.
/// `shares`: what was asked for; `wanted`: of all work; `loads`: what parts have to see.
std::vector<double> corrected_shares(std::vector<double> shares, std::span<const double> wanted,
                                     std::span<const double> loads);

}  // namespace pierce
