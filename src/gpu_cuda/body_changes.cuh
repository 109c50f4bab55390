#pragma once

#include "core/base/usable.hpp"
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

/// Where the caller has put a body.
struct PlacedBody {
    std::uint32_t body = 0;
    BodyInput input;
};

/// Copies, per body that has changed, where the caller has put it. The step itself finds out where
/// deforming bodies are.
struct ApplyInput {
    View<const PlacedBody> placed;
    View<BodyView> bodies;

    PIERCE_HD void operator()(std::uint32_t i) const {
        BodyView& body = bodies[placed[i].body];
        static_cast<BodyInput&>(body) = placed[i].input;
        if (body.motion != Motion::deforming && body.active) body.fit = body.space;
    }
};

/// A body whose pose the caller keeps in device memory.
struct PosedBody {
    std::uint32_t body = 0;
    bool takes_part = true;  ///< unless its pose is unusable
};

/// Per such body: reads its pose.
struct ReadPose {
    View<const PosedBody> posed;
    View<BodyView> bodies;

    PIERCE_HD void operator()(std::uint32_t i) const {
        BodyView& body = bodies[posed[i].body];
        const Pose pose = body.device_pose.read();
        body.active = posed[i].takes_part && is_usable(pose);
        if (body.active) body.fit = body.space = body.start_space = frame_of(pose);
    }
};

}  // namespace pierce::cuda
