#pragma once

#include <cstdint>
#include <functional>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/step_memory.hpp"
#include "pierce/ids.hpp"

namespace pierce {

/// Throws InputError unless a step of these bodies may use the memory: whatever the memory says,
/// the step then reads nothing outside of any list, and contacts name only what exists. A pair that
/// is not what it was may become so again, so it is checked with what it had. `mesh_with(key)`: a
/// mesh that no body has now; null if there is none. Pairs of bodies or meshes that are no more are
/// forgotten.
void check(StepMemory& memory, View<const BodyView> bodies, View<const BodyId> ids,
           const std::function<const MeshView*(std::uint64_t key)>& mesh_with);

}  // namespace pierce
