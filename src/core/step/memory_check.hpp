#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_memory.hpp"
#include "pierce/ids.hpp"

namespace pierce {

/// Throws InputError unless a step of these bodies may use the memory: whatever the memory says,
/// the step then reads nothing outside of any list, and contacts name only what exists.
void check(const StepMemory& memory, View<const BodyView> bodies, View<const BodyId> ids);

}  // namespace pierce
