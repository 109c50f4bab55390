#pragma once

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"

namespace pierce::cuda {

/// A body that has got another mesh, and where the step keeps what it measures of it.
struct ChangedBody {
    std::uint32_t body = 0;
    BodyView view;
    View<PatchBlock> blocks;
    View<Offsets> patches;
    View<SeenPatch> seen;
    View<BoxNode> box_nodes;
};

/// Per changed body: makes it what it is now. Where a deforming body is stays known from the last
/// step.
struct ReplaceBody {
    View<const ChangedBody> changed;
    View<BodyView> bodies;
    View<View<PatchBlock>> blocks;
    View<View<Offsets>> patches;
    View<View<SeenPatch>> seen;
    View<View<BoxNode>> box_nodes;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ChangedBody& now = changed[i];
        BodyView& body = bodies[now.body];
        if (now.view.motion == Motion::deforming)
            static_cast<BodyShape&>(body) = now.view;
        else
            body = now.view;
        blocks[now.body] = now.blocks;
        patches[now.body] = now.patches;
        seen[now.body] = now.seen;
        box_nodes[now.body] = now.box_nodes;
    }
};

/// Copies, per body, where the caller has put it. The step itself finds out where deforming bodies
/// are.
struct ApplyInput {
    View<const BodyInput> inputs;
    View<BodyView> bodies;

    PIERCE_HD void operator()(std::uint32_t i) const {
        BodyView& body = bodies[i];
        static_cast<BodyInput&>(body) = inputs[i];
        if (body.motion != Motion::deforming && body.active) body.fit = body.space;
    }
};

}  // namespace pierce::cuda
