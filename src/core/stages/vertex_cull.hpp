#pragma once

#include <bit>

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

/// Per directed pair (pair * 2 + side): the frames, and how many blocks of patches there are to test; none if the target
/// has no inside. Reads pairs and bodies; writes directed pairs and counts.
struct DirectPair {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<DirectedPair> directed;
    View<std::uint32_t> block_counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Pair pair = pairs[i / 2];
        const DirectedPair d{pair.source(i % 2), pair.target(i % 2), {}, {}};
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        directed[i] = {d.source, d.target, relative_frame(source.space, target.fit),
                       relative_frame(source.space, target.space)};
        block_counts[i] = target.mesh.clearance.steps.size > 0 ? block_count(source.mesh) : 0;
    }
};

/// A block of patches, or a patch, of a directed pair's source.
struct CullItem {
    std::uint32_t directed = 0;
    std::uint32_t index = 0;
};

/// Per directed pair: lists its blocks. Reads counts and offsets; writes items.
struct ListBlocks {
    View<const std::uint32_t> counts, offsets;
    View<CullItem> items;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        for (std::uint32_t b = 0; b < counts[i]; ++b) items[offsets[i] + b] = {i, b};
    }
};

/// A bit for every ball that may reach the target's solid or touch it: it overlaps the target's box, and the clearance of
/// its centre, less the deviation, is not larger than its radius. The balls' centres are `center` and offsets from it,
/// turned and placed by `to_fit`; `reach` is how far they go from `center` at most. Points, if `radius` is null.
PIERCE_HD inline std::uint32_t near_balls(const BodyView& target, const Frame& to_fit, Vec3d center, const Offsets& offsets,
                                          const float* radius, double reach) {
    const ClearanceGridView& grid = target.mesh.clearance;
    const Vec3d corner = grid.box.lower;
    const Vec3d in_grid = to_fit.to_parent(center) - corner;
    const Vec3f c = to_float(in_grid);
    const TurnedOffsets turned(offsets, to_fit.rotation);
    // Rounded to float32 are the centre, the rotation, the offsets and their sums: an ulp of their size each at most.
    const double rounding =
        4 * constants::float_ulp * (std::fabs(in_grid.x) + std::fabs(in_grid.y) + std::fabs(in_grid.z) + reach);
    const auto margin = static_cast<float>(2 * target.touch + rounding);
    const Vec3f low = to_float(target.fit_box.lower - corner), high = to_float(target.fit_box.upper - corner);
    const auto per_length = static_cast<float>(grid.per_length);
    float beyond[Offsets::count] = {}, near[Offsets::count];
    std::int32_t cell[3][Offsets::count];
    for (int r = 0; r < 3; ++r) {
        const float last = static_cast<float>(grid.size[r]) - 1.0f;
        PIERCE_VECTOR_LOOP
        for (std::uint32_t k = 0; k < Offsets::count; ++k) {
            const float x = c[r] + turned.at[r][k];
            cell[r][k] = static_cast<std::int32_t>(clamp_to(x * per_length, 0.0f, last));
            const float gap = max_of(max_of(low[r] - x, x - high[r]), 0.0f);
            beyond[k] += gap * gap;
        }
    }
    for (std::uint32_t k = 0; k < Offsets::count; ++k) near[k] = (radius != nullptr ? radius[k] : 0.0f) + margin;
    const auto deviation = static_cast<float>(target.deviation);
    const auto step = static_cast<float>(grid.step);
    std::uint32_t mask = 0;
    for (std::uint32_t k = 0; k < Offsets::count; ++k) {
        if (beyond[k] > near[k] * near[k]) continue;
        const float clearance = step * static_cast<float>(grid.steps_at(cell[0][k], cell[1][k], cell[2][k]));
        mask |= static_cast<std::uint32_t>(clearance <= near[k] + deviation) << k;
    }
    return mask;
}

/// The lowest `count` bits.
PIERCE_HD inline std::uint32_t first_bits(std::uint32_t count) { return count < 32 ? (1u << count) - 1u : ~0u; }

/// Per block: a bit for every patch that may hold a vertex inside the target or touching it, and their number.
struct CullBlock {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> blocks;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[blocks[i].directed];
        const BodyView& source = bodies[d.source];
        const PatchBlock& block = source.blocks[blocks[i].index];
        masks[i] = near_balls(bodies[d.target], d.to_fit, block.center, block.offsets, block.radius, block.reach) &
                   first_bits(block_length(source.mesh, blocks[i].index));
        counts[i] = static_cast<std::uint32_t>(std::popcount(masks[i]));
    }
};

/// Per block: lists the patches it keeps. Reads masks and offsets; writes patches.
struct ListPatches {
    View<const CullItem> blocks;
    View<const std::uint32_t> masks, offsets;
    View<CullItem> patches;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        std::uint32_t slot = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1)
            patches[slot++] = {blocks[i].directed,
                               blocks[i].index * constants::block_size + static_cast<std::uint32_t>(std::countr_zero(mask))};
    }
};

/// Per kept patch: a bit for every vertex that may be inside the target or touch it, and their number.
struct CullVertices {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[patches[i].directed];
        const BodyView& source = bodies[d.source];
        const std::uint32_t p = patches[i].index;
        const PatchBlock& block = source.blocks[p / constants::block_size];
        masks[i] = near_balls(bodies[d.target], d.to_fit, patch_center(source.blocks, p), source.patches[p], nullptr,
                              block.radius[p % constants::block_size]) &
                   first_bits(patch_length(source.mesh, p));
        counts[i] = static_cast<std::uint32_t>(std::popcount(masks[i]));
    }
};

static_assert(constants::patch_size <= 32 && constants::block_size <= 32, "a bit of a mask each");

}  // namespace pierce::stages
