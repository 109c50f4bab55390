#pragma once

#include "pierce/core/body.hpp"
#include "pierce/core/patch.hpp"

/// Stage 4, vertex_cull: drops vertices that cannot be inside the other body: patches first, then vertices.
namespace pierce::stages {

/// One direction of a pair: rays from `source` into `target`.
struct DirectedPair {
    std::uint32_t source = 0;
    std::uint32_t target = 0;
    Frame to_fit;    ///< source space to the target's fit frame
    Frame to_space;  ///< source space to target space
};

/// Per directed pair (pair * 2 + side): the frames, and how many patches there are to test; none if the target has no
/// inside. Reads pairs and bodies; writes directed pairs and counts.
struct DirectPair {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<DirectedPair> directed;
    View<std::uint32_t> patch_counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Pair pair = pairs[i / 2];
        const DirectedPair d{pair.source(i % 2), pair.target(i % 2), {}, {}};
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        directed[i] = {d.source, d.target, relative_frame(source.space, target.fit),
                       relative_frame(source.space, target.space)};
        patch_counts[i] = target.mesh.clearance.steps.size > 0 ? patch_count(source.mesh) : 0;
    }
};

/// A patch of a directed pair's source.
struct PatchItem {
    std::uint32_t directed = 0;
    std::uint32_t patch = 0;
};

/// Per directed pair: lists its patches. Reads offsets; writes items.
struct ListPatches {
    View<const std::uint32_t> counts, offsets;
    View<PatchItem> items;

    PIERCE_HD void operator()(std::uint32_t i) const {
        for (std::uint32_t p = 0; p < counts[i]; ++p) items[offsets[i] + p] = {i, p};
    }
};

/// Per patch: 1 if some point of its sphere may be inside the target or touch it, else 0.
struct CullPatch {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const PatchItem> items;
    View<std::uint32_t> keep;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[items[i].directed];
        const BodyView& target = bodies[d.target];
        const PatchSphere sphere = bodies[d.source].patches[items[i].patch];
        keep[i] = !target.is_clear(d.to_fit.to_parent(sphere.center), sphere.radius + target.touch);
    }
};

/// Per patch: moves the kept ones together.
struct CompactPatches {
    View<const PatchItem> items;
    View<const std::uint32_t> keep, offsets;
    View<PatchItem> kept;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (keep[i]) kept[offsets[i]] = items[i];
    }
};

/// Per kept patch: a bit for every vertex that may be inside the target or touch it, and their number.
struct CullVertices {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const PatchItem> patches;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[patches[i].directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const PatchOffsets& offsets = source.patch_offsets[patches[i].patch];
        // float32 relative to the target's box: half an ulp of its extent, which the doubled touch tolerance covers.
        const Vec3d corner = target.mesh.clearance.box.lower;
        const Vec3f center = to_float(d.to_fit.to_parent(source.patches[patches[i].patch].center) - corner);
        const TurnedOffsets turned(offsets, d.to_fit.rotation);

        const double distance = 2 * target.touch;
        const Vec3f low = to_float(target.fit_box.inflated(distance).lower - corner);
        const Vec3f high = to_float(target.fit_box.inflated(distance).upper - corner);
        const ClearanceGridView& grid = target.mesh.clearance;
        const auto clear_steps = static_cast<float>((distance + target.deviation) / grid.step);
        const auto per_length = static_cast<float>(grid.per_length);
        std::int32_t cell[3][constants::patch_size];
        std::int32_t beyond[constants::patch_size] = {};
        for (int r = 0; r < 3; ++r) {
            const float last = static_cast<float>(grid.size[r]) - 1.0f;
            PIERCE_VECTOR_LOOP
            for (std::uint32_t k = 0; k < constants::patch_size; ++k) {
                const float x = center[r] + turned.at[r][k];
                cell[r][k] = static_cast<std::int32_t>(clamp_to(x * per_length, 0.0f, last));
                beyond[k] |= static_cast<std::int32_t>(x < low[r]) | static_cast<std::int32_t>(x > high[r]);
            }
        }

        std::uint32_t mask = 0, count = 0;
        for (std::uint32_t k = 0; k < patch_length(source.mesh, patches[i].patch); ++k) {
            if (beyond[k] || grid.steps_at(cell[0][k], cell[1][k], cell[2][k]) > clear_steps) continue;
            mask |= 1u << k;
            ++count;
        }
        masks[i] = mask;
        counts[i] = count;
    }
};

static_assert(constants::patch_size <= 32, "one bit of a mask per vertex of a patch");

}  // namespace pierce::stages
