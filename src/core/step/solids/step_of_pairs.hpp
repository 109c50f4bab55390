#pragma once

#include <cstdint>

#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/directed_pair.hpp"

namespace pierce {

/// What the stages of reproject, edges, separation and margin read of a step, and the marks that
/// they set.
template <Executor E>
struct StepOfPairs {
    const Scene& scene;
    typename E::Count count;  ///< of pairs
    View<const Pair> pairs;
    View<const stages::DirectedPair> directed;  ///< two per pair, like the next one
    View<const PairMemory> memory;              ///< empty if steps do not remember
    View<const std::uint32_t> links;
    stages::PairMarks marks;
};

}  // namespace pierce
