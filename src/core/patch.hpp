#pragma once

#include "pierce/core/constants.hpp"
#include "pierce/core/mesh.hpp"

namespace pierce {

/// Patches of a mesh: its vertices along a space-filling curve, constants::patch_size at a time.
PIERCE_HD inline std::uint32_t patch_count(const MeshView& mesh) {
    return (mesh.positions.size + constants::patch_size - 1) / constants::patch_size;
}

/// Vertex count of patch `p`; only the last one may hold less than constants::patch_size.
PIERCE_HD inline std::uint32_t patch_length(const MeshView& mesh, std::uint32_t p) {
    return min_of(constants::patch_size, mesh.positions.size - p * constants::patch_size);
}

/// Measures patch `p` at `positions`; places past the last vertex repeat the centre.
PIERCE_HD inline void measure_patch(const MeshView& mesh, View<const Vec3f> positions, std::uint32_t p,
                                    PatchSphere& sphere, PatchOffsets& offsets) {
    const std::uint32_t* vertex = mesh.patch_vertices.data + p * constants::patch_size;
    const std::uint32_t count = patch_length(mesh, p);
    Box box;
    for (std::uint32_t i = 0; i < count; ++i) box.extend(to_double(positions[vertex[i]]));
    sphere = {box.center(), 0};
    for (std::uint32_t i = 0; i < constants::patch_size; ++i) {
        const Vec3d offset = i < count ? to_double(positions[vertex[i]]) - sphere.center : Vec3d{};
        sphere.radius = max_of(length_squared(offset), sphere.radius);
        offsets.x[i] = static_cast<float>(offset.x);
        offsets.y[i] = static_cast<float>(offset.y);
        offsets.z[i] = static_cast<float>(offset.z);
    }
    sphere.radius = std::sqrt(sphere.radius);
}

}  // namespace pierce
