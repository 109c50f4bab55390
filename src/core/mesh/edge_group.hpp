#pragma once

#include <algorithm>
#include <cstdint>

#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

/// Edges of a mesh by sixteens, and groups of edges by sixteens, as vertices are by patches and
/// blocks (patch.hpp). An edge lies in a sphere around its middle.
namespace pierce {

/// The middle of an edge.
PIERCE_HD inline Vec3d middle_of(const Edge& edge, View<const Vec3f> positions) {
    return 0.5 * (to_double(positions[edge.vertex[0]]) + to_double(positions[edge.vertex[1]]));
}

/// Number of groups of a mesh's edges; a group holds constants::group_size edges that are
/// neighbours in space.
PIERCE_HD inline std::uint32_t edge_group_count(const MeshView& mesh) {
    return (mesh.edges.size + constants::group_size - 1) / constants::group_size;
}

/// Edge count of group `g`; only the last one may hold less than constants::group_size.
PIERCE_HD inline std::uint32_t edge_group_length(const MeshView& mesh, std::uint32_t g) {
    return min_of(constants::group_size, mesh.edges.size - g * constants::group_size);
}

/// Number of blocks of a mesh's groups of edges; a block holds constants::block_size groups.
PIERCE_HD inline std::uint32_t edge_block_count(const MeshView& mesh) {
    return (edge_group_count(mesh) + constants::block_size - 1) / constants::block_size;
}

/// Group count of block `b`; only the last one may hold less than constants::block_size.
PIERCE_HD inline std::uint32_t edge_block_length(const MeshView& mesh, std::uint32_t b) {
    return min_of(constants::block_size, edge_group_count(mesh) - b * constants::block_size);
}

static_assert(constants::group_size == Offsets::count);

/// Measures block `b` of the rest shape's edges and its groups, which are the block's share of
/// `groups`.
inline void measure_edge_block(const MeshView& mesh, std::uint32_t b, PatchBlock& block,
                               View<EdgeGroup> groups) {
    const Vec3d base = middle_of(mesh.edges[b * constants::block_size * constants::group_size],
                                 mesh.positions);
    const auto rounded_up = [](double length) {
        return static_cast<float>(length * (1 + constants::touch_tolerance));
    };
    for (std::uint32_t k = 0; k < edge_block_length(mesh, b); ++k) {
        const std::uint32_t g = b * constants::block_size + k, first = g * constants::group_size,
                            count = edge_group_length(mesh, g);
        Vec3d sum;
        for (std::uint32_t i = 0; i < count; ++i)
            sum += middle_of(mesh.edges[first + i], mesh.positions);
        block.offsets.set(k, to_float(sum * (1.0 / count) - base));
        const Vec3d center = base +
                             Vec3d{block.offsets.x[k], block.offsets.y[k], block.offsets.z[k]};
        EdgeGroup& group = groups[g];
        group = {};
        double reach = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            const Edge& edge = mesh.edges[first + i];
            const Vec3d offset = middle_of(edge, mesh.positions) - center;
            const double half = 0.5 * length(to_double(mesh.positions[edge.vertex[1]]) -
                                             to_double(mesh.positions[edge.vertex[0]]));
            group.middles.set(i, to_float(offset));
            group.half[i] = rounded_up(half);
            reach = std::max(length(offset) + half, reach);
        }
        block.radius[k] = rounded_up(reach);
    }
    finish_block(base, edge_block_length(mesh, b), block);
}

}  // namespace pierce
