#pragma once

#include <cstdint>

namespace pierce {

/// What a step may ask the executor that runs it. The answers decide how the step works, never what
/// it finds.
struct ExecutorTraits {
    bool host_reads = true;         ///< the host can read what stages read and write
    bool overlaps_updates = false;  ///< work beside the rest costs nothing: all trees are updated
                                    ///< and all sheets placed before the step knows which ones it
                                    ///< needs
    bool joins_stages = false;  ///< a stage costs a launch: items that are wanted are not listed
                                ///< first
    std::uint32_t bodies_at_once = 0;  ///< with up to so many bodies all pairs are tested; with
                                       ///< more, the bodies are sorted and swept
    std::uint32_t sweep_walks = 1;     ///< items that share a body's partners in the sweep
};

}  // namespace pierce
