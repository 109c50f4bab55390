#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/body/body_view.hpp"
#include "core/step/common/step_memory.hpp"

namespace pierce {

/// What all parts remember, as one backend would have it. `owners`: each body's part.
StepMemory join_memory(std::span<const StepMemory> parts, std::span<const std::uint32_t> owners);

/// What one part needs of it: the pairs that `is_here(pair)` says are looked at there.
StepMemory part_of_memory(const StepMemory& all, const std::function<bool(Pair)>& is_here);

}  // namespace pierce
