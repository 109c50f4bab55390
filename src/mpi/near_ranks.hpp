#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/mesh_build/box_tree.hpp"
#include "pierce/box.hpp"

namespace pierce::mpi {

/// How near a body is to what another rank's bodies reach.
enum class Nearness : std::uint8_t {
    leaving,  ///< so far that it only stays a ghost where it is one
    nearly,   ///< so near that it comes along where other ghosts come
    near      ///< it may be a pair
};

/// A body that is near another rank.
struct NearBody {
    std::uint32_t number = 0;
    Nearness nearness = Nearness::leaving;
};

/// Finds the ranks that a body is near, by one tree over all ranks' boxes.
class NearRanks {
public:
    NearRanks() : NearRanks({}, {}) {}
    /// `boxes`: what ranks reach; `owners`: the rank of each of them.
    NearRanks(std::vector<Box> boxes, std::vector<std::uint32_t> owners)
        : boxes_(boxes), owners_(std::move(owners)), tree_(std::move(boxes)) {}

    /// Notes, in the list of every rank that a body is near, how near it is. `near`: per rank,
    /// where bodies are noted one after the other. `spare`: [length] how far bodies that are nearly
    /// near are away at most, and half of what those are that are leaving.
    void note(std::uint32_t number, const Box& reach, double spare,
              std::vector<std::vector<NearBody>>& near) const {
        if (reach.empty()) return;
        const Box nearly = reach.inflated(spare);
        tree_.for_each_in(reach.inflated(2 * spare), [&](std::uint32_t i) {
            const Nearness found = overlap(boxes_[i], reach)    ? Nearness::near
                                   : overlap(boxes_[i], nearly) ? Nearness::nearly
                                                                : Nearness::leaving;
            std::vector<NearBody>& of_rank = near[owners_[i]];
            if (of_rank.empty() || of_rank.back().number != number)
                of_rank.push_back({number, found});
            else
                of_rank.back().nearness = std::max(of_rank.back().nearness, found);
        });
    }

private:
    std::vector<Box> boxes_;
    std::vector<std::uint32_t> owners_;
    BoxTree tree_;
};

}  // namespace pierce::mpi
