#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce {

/// What the moving bodies of a part reach: a box around those of each cell, and large bodies by
/// themselves, so that one of those does not make all bodies near.
class Region {
public:
    Region(std::uint32_t cells, double mean_extent)
        : large_(constants::large_body * mean_extent), cells_(cells) {}

    void add(std::uint32_t cell, const Box& box) {
        if (length_squared(box.upper - box.lower) > large_ * large_)
            single_.push_back(box);
        else
            cells_[cell].extend(box);
    }
    /// To be called once, when all boxes were added.
    void close(double more) {
        for (std::vector<Box>* boxes : {&cells_, &single_})
            for (Box& box : *boxes) {
                if (box.empty()) continue;
                box = box.inflated(more);
                all_.extend(box);
            }
    }
    bool meets(const Box& box) const {
        const auto meets_box = [&](const Box& one) { return overlap(one, box); };
        return overlap(all_, box) &&
               (std::ranges::any_of(cells_, meets_box) || std::ranges::any_of(single_, meets_box));
    }

    /// All of it, without empty boxes.
    std::vector<Box> boxes() const {
        std::vector<Box> all = cells_;
        all.insert(all.end(), single_.begin(), single_.end());
        std::erase_if(all, [](const Box& box) { return box.empty(); });
        return all;
    }
    /// A box around all of it.
    const Box& all() const { return all_; }

private:
    double large_ = 0;
    Box all_;
    std::vector<Box> cells_, single_;
};

}  // namespace pierce
