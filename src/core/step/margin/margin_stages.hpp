#pragma once

#include "core/body/body_view.hpp"
#include "core/device/bits.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/geometry/closest_place_on_triangle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/step/common/records.hpp"
#include "core/step/margin/normal_at.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/join_batch.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"
#include "pierce/min_max.hpp"

/// margin, first part: vertices that are outside of the other body, and nearer to it than the
/// pair's margin.
namespace pierce::stages {

/// [length] How near a directed pair's source and target are in contact without overlapping: the
/// larger one of the two bodies' margins; 0 if nothing is looked for.
PIERCE_HD inline double margin_of(View<const BodyView> bodies, const DirectedPair& d) {
    const BodyView &source = bodies[d.source], &target = bodies[d.target];
    const bool looks = !d.is_self() && !d.still && target.is_solid() && !source.collision.sheet &&
                       target.mesh.has_extent();
    return looks ? max_of(source.margin, target.margin) : 0.0;
}

/// Per directed pair with a margin: lists its source's blocks of patches.
struct ListMarginBlocks {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        return margin_of(bodies, directed[i]) > 0 ? block_count(bodies[directed[i].source].mesh)
                                                  : 0;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         CullItem* blocks) const {
        write_blocks(i, found, place, blocks);
    }
};

/// Per block: lists the patches that may hold a vertex nearer to the target than the margin.
template <class Share = AllOfSixteen>
struct CullMarginBlock {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> blocks;

    /// A bit for each.
    PIERCE_HD std::uint32_t find(std::uint32_t item) const {
        const CullItem at = blocks[Share::group_of(item)];
        const DirectedPair& d = directed[at.directed];
        const BodyView& source = bodies[d.source];
        const PatchBlock& block = source.blocks[at.index];
        const BallsNearby<Share> balls(bodies[d.target], d.to_fit, block.center, block.offsets,
                                       block.radius, static_cast<double>(block.reach),
                                       margin_of(bodies, d));
        return balls.near & first_bits(block_length(source.mesh, at.index));
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t item, std::uint32_t mask, std::uint32_t place,
                         CullItem* patches) const {
        write_parts(blocks[Share::group_of(item)], constants::block_size, mask, place, patches);
    }
};

/// Per patch: lists the vertices that may be nearer to the target than the margin.
template <class Share = AllOfSixteen>
struct CullMarginVertices {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;

    /// A bit for each.
    PIERCE_HD std::uint32_t find(std::uint32_t item) const {
        const CullItem patch = patches[Share::group_of(item)];
        const DirectedPair& d = directed[patch.directed];
        const BodyView& source = bodies[d.source];
        const PatchBlock& block = source.blocks[patch.index / constants::block_size];
        const BallsNearby<Share> balls(
            bodies[d.target], d.to_fit, patch_center(source.blocks, patch.index),
            source.patches[patch.index], nullptr,
            static_cast<double>(block.radius[patch.index % constants::block_size]),
            margin_of(bodies, d));
        return balls.near & first_bits(patch_length(source.mesh, patch.index));
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t item, std::uint32_t mask, std::uint32_t place,
                         RaySource* sources) const {
        const CullItem patch = patches[Share::group_of(item)];
        const View<const std::uint32_t> vertices = bodies[directed[patch.directed].source]
                                                       .mesh.patch_vertices;
        for (; mask != 0; mask &= mask - 1)
            sources[place++] = {.pair = patch.directed / 2,
                                .item = vertices[patch_begin(patch.index) + lowest_bit(mask)],
                                .side = static_cast<std::uint8_t>(patch.directed % 2),
                                .is_near = true};
    }
};

/// Per vertex: where to look for the closest triangle, and how far. A vertex without triangles is
/// no part of the surface.
struct GenerateNearQueries {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const RaySource> sources;
    View<Ray> queries;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const RaySource& from = sources[i];
        const DirectedPair& d = directed[2 * from.pair + from.side];
        const BodyView& source = bodies[d.source];
        Ray query;
        query.origin = d.to_space.to_parent(to_double(source.positions[from.item]));
        query.t_max = has_triangles(source.mesh, from.item) ? margin_of(bodies, d) : -1.0;
        query.target = d.target;
        query.touch = d.touch;
        queries[i] = query;
    }
};

/// Per query: if its vertex is outside and near, the way from the closest point to the vertex, as a
/// ray that leaves the target after a negative way.
struct MeasureNear {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const RaySource> sources;
    View<const Ray> queries;
    View<const std::uint32_t> closest;
    View<Ray> rays;  ///< per query, like the others
    View<Hit> hits;
    View<Meeting> meetings;
    View<std::uint32_t> keep;

    PIERCE_HD void operator()(std::uint32_t i) const {
        keep[i] = 0;
        if (!(queries[i].t_max >= 0) || closest[i] == no_triangle) return;
        Ray ray = queries[i];
        const BodyView& target = bodies[ray.target];
        const TriangleCorners at = target.surface().corners(closest[i]);
        const TrianglePlace place = closest_place_on_triangle(ray.origin, at.a, at.b, at.c);
        const Vec3d point = at.a + place.second * (at.b - at.a) + place.third * (at.c - at.a),
                    way = ray.origin - point;
        const double distance = length(way);
        const bool touches = !(distance > ray.touch);
        if (!(distance < ray.t_max)) return;
        if (!touches && !(dot(way, normal_at(target, closest[i], place, way)) > 0)) return;
        // Rounding decides where so short a way leads. A vertex that is inside by less has a
        // contact by its ray, or none.
        ray.direction = normalized(
            touches ? normal_touched(target, closest[i], place, inward_of(sources[i]), ray.touch)
                    : way);
        rays[i] = ray;
        hits[i] = {closest[i]};
        meetings[i] = {
            -distance, {1 - place.second - place.third, place.second, place.third}, true};
        keep[i] = 1;
    }

private:
    /// The inward direction of a vertex, in the space of the other body.
    PIERCE_HD Vec3d inward_of(const RaySource& from) const {
        const DirectedPair& d = directed[2 * from.pair + from.side];
        return d.to_space.rotation * inward_direction(bodies[d.source], from.item);
    }
};

/// Per place of a list of rays: the ray joins a batch as a contact.
struct JoinAsContact {
    View<const std::uint32_t> kept;
    JoinBatch batch;

    PIERCE_HD void operator()(std::uint32_t i) const { batch.join(i, kept[i], true); }
};

}  // namespace pierce::stages
