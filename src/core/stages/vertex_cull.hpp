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
        patch_counts[i] = target.mesh.closed ? patch_count(source.mesh) : 0;
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
        keep[i] = !(target.clearance(d.to_fit.to_parent(sphere.center)) > sphere.radius + target.touch);
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
        const std::uint32_t* vertex = source.mesh.patch_vertices.data + patches[i].patch * constants::patch_size;
        std::uint32_t mask = 0, count = 0;
        for (std::uint32_t k = 0; k < patch_length(source.mesh, patches[i].patch); ++k) {
            const Vec3d p = d.to_fit.to_parent(to_double(source.positions[vertex[k]]));
            const bool keep = !(target.clearance(p) > target.touch);
            mask |= static_cast<std::uint32_t>(keep) << k;
            count += keep;
        }
        masks[i] = mask;
        counts[i] = count;
    }
};

static_assert(constants::patch_size <= 32, "one bit of a mask per vertex of a patch");

}  // namespace pierce::stages
