#pragma once

#include <utility>

#include "core/body/body_view.hpp"
#include "core/device/loops.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "pierce/min_max.hpp"

/// edges, first part: which edges may reach the other body of their pair, by patches, then one by
/// one. If the surfaces of two closed bodies cross, an edge of one of them crosses the other:
/// vertices alone may miss that.
namespace pierce::stages {

/// Per block: a bit for every patch with an edge that may reach the target, and their number.
struct CullEdgeBlock {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> blocks;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[blocks[i].directed];
        masks[i] = counts[i] = 0;
        if (d.is_self())
            return;  // of a body against itself, only vertices are tested; a sheet has no clearance
                     // either
        const BodyView& source = bodies[d.source];
        const std::uint32_t b = blocks[i].index, count = block_length(source.mesh, b);
        const PatchBlock& block = source.blocks[b];
        // An edge starts in its patch's ball and is as long as in the rest shape, up to the
        // deviation of its two ends.
        float radius[constants::block_size] = {};
        float longest_edge = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const float edge = source.mesh.edge_reach[b * constants::block_size + k];
            radius[k] = block.radius[k] + edge;
            longest_edge = max_of(edge, longest_edge);
        }
        const double span = static_cast<double>(block.reach) + static_cast<double>(longest_edge);
        const BallsNearby<> balls(bodies[d.target], d.to_fit, block.center, block.offsets, radius,
                                  span, 2 * source.deviation + constants::touch_tolerance * span);
        masks[i] = balls.near & first_bits(count);
        counts[i] = bit_count(masks[i]);
    }
};

/// Per block: lists the patches it keeps. Reads masks and offsets.
struct ListEdgePatches {
    View<const CullItem> blocks;
    View<const std::uint32_t> masks, offsets;
    View<CullItem> patches;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        std::uint32_t slot = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1)
            patches[slot++] = {blocks[i].directed,
                               blocks[i].index * constants::block_size + lowest_bit(mask)};
    }
};

/// A few edges of a directed pair's source, one after the other.
struct EdgeGroup {
    std::uint32_t directed = 0;
    std::uint32_t first = 0;
    std::uint32_t count = 0;  ///< Offsets::count at most
};

/// Per kept patch: how many groups of edges it has.
struct CountEdgeGroups {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;
    View<std::uint32_t> counts;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeshView& mesh = bodies[directed[patches[i].directed].source].mesh;
        const std::uint32_t edges = mesh.edge_offsets[patches[i].index + 1] -
                                    mesh.edge_offsets[patches[i].index];
        counts[i] = (edges + Offsets::count - 1) / Offsets::count;
    }
};

/// Per kept patch: lists its groups.
struct ListEdgeGroups {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;
    View<const std::uint32_t> offsets;
    View<EdgeGroup> groups;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeshView& mesh = bodies[directed[patches[i].directed].source].mesh;
        const std::uint32_t last = mesh.edge_offsets[patches[i].index + 1];
        std::uint32_t slot = offsets[i];
        for (std::uint32_t e = mesh.edge_offsets[patches[i].index]; e < last; e += Offsets::count)
            groups[slot++] = {patches[i].directed, e, min_of(Offsets::count, last - e)};
    }
};

/// Per group: a bit for every edge whose ball, around its middle and as wide as it is long, may
/// reach the target.
struct CullEdgeGroup {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeGroup> groups;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const EdgeGroup group = groups[i];
        const DirectedPair& d = directed[group.directed];
        const BodyView& source = bodies[d.source];
        const Vec3d center = to_double(source.positions[source.mesh.edges[group.first].vertex[0]]);
        const Vec3f c = to_float(center);  // a float32 position: nothing is lost
        Offsets middles, halves;
        for (std::uint32_t k = 0; k < group.count; ++k) {
            const Edge& edge = source.mesh.edges[group.first + k];
            const Vec3f a = source.positions[edge.vertex[0]] - c,
                        b = source.positions[edge.vertex[1]] - c;
            middles.set(k, 0.5f * (a + b));
            halves.set(k, 0.5f * (b - a));
        }
        float radius[Offsets::count], span = 0;
        PIERCE_VECTOR_LOOP
        for (std::uint32_t k = 0; k < Offsets::count; ++k)
            radius[k] = std::sqrt(halves.x[k] * halves.x[k] + halves.y[k] * halves.y[k] +
                                  halves.z[k] * halves.z[k]);
        for (std::uint32_t k = 0; k < group.count; ++k) span = max_of(radius[k], span);
        const double reach = static_cast<double>(longest(middles)) + static_cast<double>(span);
        const BallsNearby<> balls(bodies[d.target], d.to_fit, center, middles, radius, reach,
                                  constants::touch_tolerance * reach);
        masks[i] = balls.near & first_bits(group.count);
        counts[i] = bit_count(masks[i]);
    }
};

/// An edge of a directed pair's source.
struct EdgeItem {
    std::uint32_t directed = 0;
    std::uint32_t edge = 0;
};

/// Per group: lists the edges it keeps.
struct ListEdges {
    View<const EdgeGroup> groups;
    View<const std::uint32_t> masks, offsets;
    View<EdgeItem> items;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        std::uint32_t slot = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1)
            items[slot++] = {groups[i].directed, groups[i].first + lowest_bit(mask)};
    }
};

/// A part of a segment by distances from its first end [length]; empty if it ends before it begins.
struct Span {
    double begin = 0, end = -1;

    PIERCE_HD bool empty() const { return end < begin; }
};

/// The segment from `a` to `b`, given in the target's fit frame, without the parts at both ends
/// that are certainly outside of the target's solid. It marches inward by the distance proved at
/// each place.
PIERCE_HD inline Span part_near(const BodyView& target, Vec3d a, Vec3d b) {
    const double size = length(b - a);
    const Vec3d direction = normalized(b - a);
    const auto free = [&](double at) {
        const Vec3d p = a + at * direction;
        return max_of(target.fit_box.distance(p), target.mesh.clearance()(p) - target.deviation) -
               2 * target.touch;
    };
    Span span{0, size};
    if (size > 0 && size < constants::march_cells * target.mesh.clearance_at.cell) return span;
    // A march step that is lost in rounding is the last one.
    for (double step;
         (step = free(span.begin)) > constants::march_share * (span.end - span.begin);) {
        const double before = std::exchange(span.begin, span.begin + step);
        if (span.empty() || !(span.begin > before)) return span;
    }
    for (double step; (step = free(span.end)) > constants::march_share * (span.end - span.begin);) {
        const double before = std::exchange(span.end, span.end - step);
        if (span.empty() || !(span.end < before)) return span;
    }
    return span;
}

/// Per edge: the part of it that may be inside the target.
struct CullEdge {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<Span> spans;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[items[i].directed];
        const BodyView& source = bodies[d.source];
        const Edge& edge = source.mesh.edges[items[i].edge];
        spans[i] = part_near(bodies[d.target],
                             d.to_fit.to_parent(to_double(source.positions[edge.vertex[0]])),
                             d.to_fit.to_parent(to_double(source.positions[edge.vertex[1]])));
    }
};

/// True for edges with a part that may be inside the target.
struct MayReach {
    View<const Span> spans;

    PIERCE_HD bool operator()(std::uint32_t i) const { return !spans[i].empty(); }
};

/// What is known of an edge so far, from one crossing to the next.
struct Segment {
    std::uint32_t item = 0;
    std::uint32_t chords = 0;  ///< found so far
    double enter = 0;          ///< [length] along the ray, where the target was last entered
    bool crossed = false;      ///< at least once
    bool inside = false;       ///< beyond the last crossing
    std::uint8_t padding[6] = {};
};

/// Per edge that may reach its target: the ray along it.
struct GenerateSegments {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<const Span> spans;
    View<const std::uint32_t> slots;  ///< places in items and spans
    View<Segment> segments;
    View<Ray> rays;
    View<std::uint32_t> active;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t slot = slots[i];
        const DirectedPair& d = directed[items[slot].directed];
        const BodyView& source = bodies[d.source];
        const Edge& edge = source.mesh.edges[items[slot].edge];
        const Vec3d a = d.to_space.to_parent(to_double(source.positions[edge.vertex[0]]));
        const Vec3d b = d.to_space.to_parent(to_double(source.positions[edge.vertex[1]]));
        Ray ray;
        ray.direction = normalized(b - a);
        ray.origin = a + spans[slot].begin * ray.direction;
        ray.t_max = length_squared(ray.direction) > 0 ? spans[slot].end - spans[slot].begin : -1.0;
        ray.target = d.target;
        ray.touch = d.touch;
        rays[i] = ray;
        segments[i] = {};
        segments[i].item = slot;
        active[i] = i;
    }
};

}  // namespace pierce::stages
