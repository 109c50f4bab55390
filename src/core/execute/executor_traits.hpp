#pragma once

#include <cstdint>

namespace pierce {

/// What a step may ask of the executor that runs it: how, never what it is to find.
struct ExecutorTraits {
    bool host_reads = true;         ///< the host can read what stages read and write
    bool overlaps_updates = false;  ///< work beside the rest is for nothing: all trees are updated
                                    ///< and all sheets placed before it is known which are wanted
    std::uint32_t bodies_at_once = 0;  ///< up to so many bodies all pairs are looked at; with more,
                                       ///< they are sorted and swept
    std::uint32_t sweep_walks = 1;     ///< items that share a body's partners in the sweep
};

}  // namespace pierce
