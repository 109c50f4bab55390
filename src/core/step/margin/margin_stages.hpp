#pragma once

#include <cmath>

#include "core/body/body_view.hpp"
#include "core/device/bits.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/geometry/closest_place_on_triangle.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/edge_normal.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/mesh/surface.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/join_batch.hpp"
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
        for (std::uint32_t b = 0; b < found; ++b) blocks[place + b] = {i, b};
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

/// Of the triangles at a vertex, or at the edge between two, the normal of the one whose plane is
/// furthest from the end of `way`. It stands for all of them where they are not one fan, or not
/// two.
PIERCE_HD inline Vec3d most_facing_normal(const BodyView& body, Vec3d way, std::uint32_t v,
                                          std::uint32_t other = no_vertex) {
    const Vec3d apex = to_double(body.positions[v]);
    Vec3d best;
    double most = -1;
    for (std::uint32_t i = body.mesh.corner_offsets[v]; i < body.mesh.corner_offsets[v + 1]; ++i) {
        const Corner& corner = body.mesh.corners[i];
        if (other != no_vertex && corner.next != other && corner.previous != other) continue;
        const Vec3d next = to_double(body.positions[corner.next]),
                    previous = to_double(body.positions[corner.previous]);
        if (is_degenerate(apex, next, previous)) continue;
        const Vec3d normal = normalized(cross(next - apex, previous - apex));
        const double height = std::fabs(dot(normal, way));
        if (!(height > most)) continue;
        most = height;
        best = normal;
    }
    return best;
}

/// The triangle beside a triangle's side, or beyond those without area that lie there; no_triangle
/// if there is none.
PIERCE_HD inline std::uint32_t neighbor_with_area(const BodyView& body, std::uint32_t triangle,
                                                  std::uint32_t side) {
    const MeshView& mesh = body.mesh;
    std::uint32_t last = triangle, next = mesh.neighbors[triangle].across[side];
    for (std::uint32_t k = 0; k < constants::degenerate_in_a_row && next != no_triangle; ++k) {
        const Triangle& t = mesh.triangles[next];
        Vec3d corner[3];
        for (int c = 0; c < 3; ++c) corner[c] = to_double(body.positions[t.vertex[c]]);
        if (!is_degenerate(corner[0], corner[1], corner[2])) return next;
        // Its longest side is as long as the two others together.
        const auto squared = [&](std::uint32_t s) {
            return length_squared(corner[(s + 1) % 3] - corner[(s + 2) % 3]);
        };
        std::uint32_t longest = squared(1) > squared(0) ? 1 : 0;
        if (squared(2) > squared(longest)) longest = 2;
        const std::uint32_t* across = mesh.neighbors[next].across;
        const std::uint32_t out = across[longest] == last ? (longest + 1) % 3 : longest;
        last = next;
        next = across[out];
    }
    return no_triangle;
}

/// The outward normal of a surface where it is closest to the end of `way`, a point outside or
/// inside of it: of the triangle, of its edge or of its corner. Its sign tells on which side the
/// point is (Baerentzen and Aanaes 2005). Not of length 1.
PIERCE_HD inline Vec3d normal_at(const BodyView& body, std::uint32_t triangle,
                                 const TrianglePlace& place, Vec3d way) {
    const double weight[3] = {1 - place.second - place.third, place.second, place.third};
    const MeshView& mesh = body.mesh;
    const Triangle& t = mesh.triangles[triangle];
    std::uint32_t zero = 3, zeros = 0, corner = 0;
    // A weight is a difference of numbers up to one.
    for (std::uint32_t k = 0; k < 3; ++k)
        if (weight[k] > constants::double_rounding) {
            corner = k;
        } else {
            zero = k;
            ++zeros;
        }
    const std::uint32_t v = t.vertex[corner];
    if (zeros > 0 && mesh.has_degenerate) {
        // The triangles around may have no area, but those beyond have: as most_facing_normal().
        Vec3d best = zeros == 2 ? most_facing_normal(body, way, v)
                                : triangle_normal(mesh, body.positions, triangle);
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (weight[k] > constants::double_rounding) continue;
            const std::uint32_t beside = neighbor_with_area(body, triangle, k);
            if (beside == no_triangle) continue;
            const Vec3d normal = triangle_normal(mesh, body.positions, beside);
            if (std::fabs(dot(normal, way)) > std::fabs(dot(best, way))) best = normal;
        }
        return best;
    }
    if (zeros == 2) {
        const bool is_one_fan = mesh.fans[mesh.corner_offsets[v]] != no_vertex;
        const Vec3d normal = is_one_fan ? vertex_normal(mesh, body.positions, v) : Vec3d{};
        return length_squared(normal) > 0 ? normal : most_facing_normal(body, way, v);
    }
    const Vec3d normal = triangle_normal(mesh, body.positions, triangle);
    if (zeros == 0) return normal;
    const std::uint32_t across = mesh.neighbors[triangle].across[zero];
    const Vec3d both = across == no_triangle
                           ? Vec3d{}
                           : normal + triangle_normal(mesh, body.positions, across);
    return length_squared(both) > 0 ? both
                                    : most_facing_normal(body, way, v, t.vertex[3 - zero - corner]);
}

/// Per query: if its vertex is outside and near, the way from the closest point to the vertex, as a
/// ray that leaves the target after a negative way.
struct MeasureNear {
    View<const BodyView> bodies;
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
        const Triangle& t = target.mesh.triangles[closest[i]];
        const Vec3d a = to_double(target.positions[t.vertex[0]]),
                    b = to_double(target.positions[t.vertex[1]]),
                    c = to_double(target.positions[t.vertex[2]]);
        const TrianglePlace place = closest_place_on_triangle(ray.origin, a, b, c);
        const Vec3d point = a + place.second * (b - a) + place.third * (c - a),
                    way = ray.origin - point, normal = normal_at(target, closest[i], place, way);
        const double distance = length(way);
        const bool touches = !(distance > ray.touch);
        if (!(touches || dot(way, normal) > 0) || !(distance < ray.t_max)) return;
        // Rounding decides where so short a way leads. A vertex that is inside by less has a
        // contact by its ray, or none.
        ray.direction = normalized(touches ? normal : way);
        rays[i] = ray;
        hits[i] = {closest[i]};
        meetings[i] = {
            -distance, {1 - place.second - place.third, place.second, place.third}, true};
        keep[i] = 1;
    }
};

/// Per place of a list of rays: the ray joins a batch as a contact.
struct JoinAsContact {
    View<const std::uint32_t> kept;
    JoinBatch batch;

    PIERCE_HD void operator()(std::uint32_t i) const { batch.join(i, kept[i], true); }
};

}  // namespace pierce::stages
