#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "pierce/min_max.hpp"

/// edges, first part: which edges may reach the other body of their pair, by patches. If the
/// surfaces of two closed bodies cross, an edge of one of them crosses the other: vertices alone
/// may miss that.
namespace pierce::stages {

/// [length] How far from a target's surface edges matter: where they are moved against each other,
/// crossings may be that far away, and a few touch tolerances are for rounding.
PIERCE_HD inline double edge_margin(View<const DirectedPair> directed, std::uint32_t direction) {
    return (constants::nudge + constants::edge_tolerance) * touch_of_pair(directed, direction);
}

/// [length] How far the bodies of a pair may move until it is asked again which edges are near, if
/// steps remember.
PIERCE_HD inline double edge_skin(View<const BodyView> bodies, const DirectedPair& d) {
    const double edge = min_of(bodies[d.source].mesh.mean_edge_length,
                               bodies[d.target].mesh.mean_edge_length),
                 most = constants::edge_skin_most * edge, step = static_cast<double>(d.step);
    if (!(constants::edge_skin_wait * step < most)) return 0;
    return min_of(max_of(constants::edge_skin_steps * step, constants::edge_skin_least * edge),
                  most);
}

/// Per directed pair: whether the near edges of the last step are still those that may meet the
/// target, and until when those of this step will be.
struct RecallNearEdges {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const PairMemory> memory;
    View<const std::uint32_t> links;
    View<const NearEdgesOfPair> last;  ///< empty if the last step did not remember
    View<NearEdgesOfPair> now;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[i];
        NearEdgesOfPair of_pair;
        if (memory[i].known && last.size > 0) of_pair = last[2 * links[i / 2] + i % 2];
        of_pair.is_kept = of_pair.expiry > d.odometer;
        if (!of_pair.is_kept)
            of_pair = {.expiry = d.odometer + static_cast<float>(edge_skin(bodies, d))};
        now[i] = of_pair;
    }
};

/// Per block of patches: lists the patches with an edge that may reach the target's surface.
struct CullEdgeBlock {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> blocks;
    View<const NearEdgesOfPair> of_pairs;  ///< empty if steps do not remember

    static constexpr bool in_order = true;

    /// A bit for each.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const CullItem item = blocks[i];
        const DirectedPair& d = directed[item.directed];
        if (d.is_self()) return 0;  // of a body against itself, only vertices are tested
        const bool remembers = of_pairs.size > 0;
        if (remembers && of_pairs[item.directed].is_kept) return 0;
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const BoxLevels levels(target.mesh.triangles.size);
        const Frame place = source.motion == Motion::deforming
                                ? relative_frame(source.fit, target.space)
                                : d.to_space;
        const double margin = edge_margin(directed, item.directed) + source.deviation +
                              (remembers ? edge_skin(bodies, d) : 0.0);
        std::uint32_t mask = 0;
        for (std::uint32_t k = 0; k < block_length(source.mesh, item.index); ++k) {
            const QuickBox& edges = source.mesh.edge_boxes[item.index * constants::block_size + k];
            if (edges.empty()) continue;
            const bool near = for_each_group(target.box_nodes, levels,
                                             placed_box(edges, place, margin),
                                             [](std::uint32_t, std::uint32_t) { return true; });
            mask |= static_cast<std::uint32_t>(near) << k;
        }
        return mask;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t mask, std::uint32_t place,
                         CullItem* patches) const {
        for (; mask != 0; mask &= mask - 1)
            patches[place++] = {blocks[i].directed,
                                blocks[i].index * constants::block_size + lowest_bit(mask)};
    }

private:
    /// The box around a box in another frame, larger by `margin`.
    PIERCE_HD static QuickBox placed_box(const QuickBox& box, const Frame& place, double margin) {
        const Vec3d low = to_double(box.lower), high = to_double(box.upper);
        const Vec3d middle = place.to_parent(0.5 * (low + high)), half = 0.5 * (high - low);
        QuickBox placed;
        for (int r = 0; r < 3; ++r) {
            const Vec3d row = place.rotation.row[r];
            const double reach = std::fabs(row.x) * half.x + std::fabs(row.y) * half.y +
                                 std::fabs(row.z) * half.z + margin;
            placed.lower[r] = not_above(static_cast<float>(middle[r] - reach));
            placed.upper[r] = not_below(static_cast<float>(middle[r] + reach));
        }
        return placed;
    }
};

/// A few edges of a directed pair's source, one after the other.
struct EdgeGroup {
    std::uint32_t directed = 0;
    std::uint32_t first = 0;
    std::uint32_t count = 0;  ///< Offsets::count at most
};

/// Per kept patch: lists its edges, group after group.
struct ListEdgeGroups {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;

    static constexpr bool in_order = true;

    /// The number of edges.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const MeshView& mesh = mesh_of(i);
        return mesh.edge_offsets[patches[i].index + 1] - mesh.edge_offsets[patches[i].index];
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t edges) {
        return (edges + Offsets::count - 1) / Offsets::count;
    }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t edges, std::uint32_t place,
                         EdgeGroup* groups) const {
        const std::uint32_t first = mesh_of(i).edge_offsets[patches[i].index];
        for (std::uint32_t e = 0; e < edges; e += Offsets::count)
            groups[place++] = {patches[i].directed, first + e, min_of(Offsets::count, edges - e)};
    }

private:
    PIERCE_HD const MeshView& mesh_of(std::uint32_t i) const {
        return bodies[directed[patches[i].directed].source].mesh;
    }
};

}  // namespace pierce::stages
