#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_memory.hpp"
#include "pierce/ids.hpp"

namespace pierce {

/// Throws InputError unless a step of these bodies may use the memory: whatever the memory says,
/// the step then reads nothing outside of any list, and contacts name only what exists. Pairs that
/// are not what they were are forgotten, as nobody can tell what they will be.
void check(StepMemory& memory, View<const BodyView> bodies, View<const BodyId> ids);

}  // namespace pierce
