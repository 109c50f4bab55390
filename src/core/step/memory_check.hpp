#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_memory.hpp"
#include "pierce/ids.hpp"

namespace pierce {

/// Throws InputError unless a step of these bodies may use the memory: whatever it says, nothing
/// outside of any list is read, and contacts name what there is.
void check(const StepMemory& memory, View<const BodyView> bodies, View<const BodyId> ids);

}  // namespace pierce
