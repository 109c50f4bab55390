#pragma once

#include "pierce/core/constants.hpp"
#include "pierce/core/mesh.hpp"
#include "pierce/core/pose.hpp"

namespace pierce {

/// Patches of a mesh: its vertices along a space-filling curve, constants::patch_size at a time.
PIERCE_HD inline std::uint32_t patch_count(const MeshView& mesh) {
    return (mesh.positions.size + constants::patch_size - 1) / constants::patch_size;
}

/// Vertex count of patch `p`; only the last one may hold less than constants::patch_size.
PIERCE_HD inline std::uint32_t patch_length(const MeshView& mesh, std::uint32_t p) {
    return min_of(constants::patch_size, mesh.positions.size - p * constants::patch_size);
}

/// Measures patch `p` at `positions`: its mean, the vertices relative to that, and how far they reach. Places past the last
/// vertex repeat the mean. The mean, unlike the middle of a box, turns with the patch.
PIERCE_HD inline void measure_patch(const MeshView& mesh, View<const Vec3f> positions, std::uint32_t p, PatchSphere& sphere,
                                    PatchOffsets& offsets) {
    const std::uint32_t* vertex = mesh.patch_vertices.data + p * constants::patch_size;
    const std::uint32_t count = patch_length(mesh, p);
    Vec3d sum;
    for (std::uint32_t i = 0; i < count; ++i) sum += to_double(positions[vertex[i]]);
    sphere = {sum * (1.0 / count), 0};
    for (std::uint32_t i = 0; i < constants::patch_size; ++i) {
        const Vec3f offset = i < count ? to_float(to_double(positions[vertex[i]]) - sphere.center) : Vec3f{};
        offsets.x[i] = offset.x;
        offsets.y[i] = offset.y;
        offsets.z[i] = offset.z;
    }
    float reach[constants::patch_size];
    PIERCE_VECTOR_LOOP
    for (std::uint32_t i = 0; i < constants::patch_size; ++i)
        reach[i] = offsets.x[i] * offsets.x[i] + offsets.y[i] * offsets.y[i] + offsets.z[i] * offsets.z[i];
    float furthest = 0;
    for (std::uint32_t i = 0; i < constants::patch_size; ++i) furthest = max_of(reach[i], furthest);
    sphere.radius = std::sqrt(static_cast<double>(furthest)) * (1 + constants::touch_tolerance);
}

/// The offsets of a patch turned by `rotation`, in float32.
struct TurnedOffsets {
    float at[3][constants::patch_size];

    PIERCE_HD TurnedOffsets(const PatchOffsets& offsets, const Matrix3& rotation) {
        for (int r = 0; r < 3; ++r) {
            const Vec3f row = to_float(rotation.row[r]);
            PIERCE_VECTOR_LOOP
            for (std::uint32_t k = 0; k < constants::patch_size; ++k)
                at[r][k] = row.x * offsets.x[k] + row.y * offsets.y[k] + row.z * offsets.z[k];
        }
    }
};

}  // namespace pierce
