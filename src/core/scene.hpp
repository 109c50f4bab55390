#pragma once

#include "pierce/core/body.hpp"
#include "pierce/core/contact.hpp"
#include "pierce/core/plan.hpp"
#include "pierce/core/stages/bounds.hpp"

namespace pierce {

/// All that a step reads of a world, and what it keeps up to date there: bounds and fitted frames of its bodies.
struct Scene {
    View<BodyView> bodies;
    View<const BodyId> ids;
    View<const stages::BlockItem> block_items;  ///< of deforming bodies
    View<const stages::BlockRange> ranges;      ///< per deforming body, its blocks
    View<const View<PatchBlock>> blocks;        ///< per body, where a deforming body's spheres go
    View<const View<Offsets>> patches;          ///< per body, where its vertices' offsets go
    View<const View<SeenPatch>> seen;           ///< per body, where its shape of the last step is kept; empty: nowhere
    Settings settings;
    const Plan* plan = nullptr;
    View<const std::uint32_t> forgets_sides;  ///< one number; not 0: nothing of the last step is known to sheets
};

}  // namespace pierce
