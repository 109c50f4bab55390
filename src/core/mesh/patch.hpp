#pragma once

#include "core/device/loops.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/mesh.hpp"
#include "pierce/min_max.hpp"
#include "pierce/pose.hpp"

namespace pierce {

/// Number of patches of a mesh; a patch holds constants::patch_size vertices that are neighbours in
/// space.
PIERCE_HD inline std::uint32_t patch_count(const MeshView& mesh) {
    return (mesh.patch_vertices.size + constants::patch_size - 1) / constants::patch_size;
}

/// Where the vertices of patch `p` begin in MeshView::patch_vertices.
PIERCE_HD inline std::size_t patch_begin(std::uint32_t p) {
    return std::size_t{p} * constants::patch_size;
}

/// Vertex count of patch `p`; only the last one may hold less than constants::patch_size.
PIERCE_HD inline std::uint32_t patch_length(const MeshView& mesh, std::uint32_t p) {
    return min_of(constants::patch_size, mesh.patch_vertices.size - p * constants::patch_size);
}

/// Number of blocks of a mesh; a block holds constants::block_size patches.
PIERCE_HD inline std::uint32_t block_count(const MeshView& mesh) {
    return (patch_count(mesh) + constants::block_size - 1) / constants::block_size;
}

/// Patch count of block `b`; only the last one may hold less than constants::block_size.
PIERCE_HD inline std::uint32_t block_length(const MeshView& mesh, std::uint32_t b) {
    return min_of(constants::block_size, patch_count(mesh) - b * constants::block_size);
}

/// The mean of the vertices of patch `p`.
PIERCE_HD inline Vec3d patch_center(View<const PatchBlock> blocks, std::uint32_t p) {
    const PatchBlock& block = blocks[p / constants::block_size];
    const std::uint32_t k = p % constants::block_size;
    return block.center + Vec3d{block.offsets.x[k], block.offsets.y[k], block.offsets.z[k]};
}

/// The longest of the offsets.
PIERCE_HD inline float longest(const Offsets& offsets) {
    float squared[Offsets::count];
    PIERCE_VECTOR_LOOP
    for (std::uint32_t i = 0; i < Offsets::count; ++i)
        squared[i] = offsets.x[i] * offsets.x[i] + offsets.y[i] * offsets.y[i] +
                     offsets.z[i] * offsets.z[i];
    float furthest = 0;
    for (std::uint32_t i = 0; i < Offsets::count; ++i) furthest = max_of(squared[i], furthest);
    return std::sqrt(furthest) * static_cast<float>(1 + constants::touch_tolerance);
}

/// Measures patch `p` at `positions`: its mean and how far its vertices reach, which go into its
/// block, and its vertices relative to the mean. Places past the last vertex repeat the mean. A
/// mean, unlike the middle of a box, turns with the patch.
PIERCE_HD inline void measure_patch(const MeshView& mesh, View<const Vec3f> positions,
                                    std::uint32_t p, PatchBlock& block, Offsets& patch) {
    const std::uint32_t first = p / constants::block_size * constants::block_size, k = p - first;
    const std::uint32_t* vertex = mesh.patch_vertices.data + patch_begin(p);
    const std::uint32_t count = patch_length(mesh, p);
    const Vec3d base = to_double(positions[mesh.patch_vertices[patch_begin(first)]]);
    Vec3d sum;
    for (std::uint32_t i = 0; i < count; ++i) sum += to_double(positions[vertex[i]]);
    block.offsets.set(k, to_float(sum * (1.0 / count) - base));
    const Vec3d center = base + Vec3d{block.offsets.x[k], block.offsets.y[k], block.offsets.z[k]};
    Offsets measured;
    for (std::uint32_t i = 0; i < constants::patch_size; ++i)
        measured.set(i, i < count ? to_float(to_double(positions[vertex[i]]) - center) : Vec3f{});
    patch = measured;
    block.radius[k] = longest(measured);
}

/// The mean of the k-th patch of a block that begins with patch `first`, once the patch is
/// measured.
PIERCE_HD inline Vec3d measured_center(const MeshView& mesh, View<const Vec3f> positions,
                                       const PatchBlock& block, std::uint32_t first,
                                       std::uint32_t k) {
    return to_double(positions[mesh.patch_vertices[patch_begin(first)]]) +
           Vec3d{block.offsets.x[k], block.offsets.y[k], block.offsets.z[k]};
}

/// Completes a block with the given centre, of which the first `count` spheres are measured. Places
/// past the last one repeat the centre.
PIERCE_HD inline void finish_block(Vec3d center, std::uint32_t count, PatchBlock& block) {
    block.center = center;
    for (std::uint32_t k = count; k < constants::block_size; ++k) {
        block.offsets.set(k, {});
        block.radius[k] = 0;
    }
    float reach = 0;
    for (std::uint32_t k = 0; k < constants::block_size; ++k)
        reach = max_of(block.radius[k], reach);
    block.reach = longest(block.offsets) + reach;
}

/// Completes block `b` of a mesh, whose patches are measured.
PIERCE_HD inline void finish_block(const MeshView& mesh, View<const Vec3f> positions,
                                   std::uint32_t b, PatchBlock& block) {
    const std::uint32_t first = mesh.patch_vertices[patch_begin(b * constants::block_size)];
    finish_block(to_double(positions[first]), block_length(mesh, b), block);
}

/// Offsets turned by `rotation`, in float32: all sixteen, or a share of them.
template <class Share = AllOfSixteen>
struct TurnedOffsets {
    float at[3][Share::count];

    PIERCE_HD TurnedOffsets(const Offsets& offsets, const Matrix3& rotation) {
        static_assert(Offsets::count == AllOfSixteen::count);
        const std::uint32_t first = Share::first();
        for (int r = 0; r < 3; ++r) {
            const Vec3f row = to_float(rotation.row[r]);
            PIERCE_VECTOR_LOOP
            for (std::uint32_t k = 0; k < Share::count; ++k)
                at[r][k] = row.x * offsets.x[first + k] + row.y * offsets.y[first + k] +
                           row.z * offsets.z[first + k];
        }
    }
};

}  // namespace pierce
