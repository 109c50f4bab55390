#pragma once

#include "pierce/core/stages/vertex_cull.hpp"
#include "pierce/core/vertex_normal.hpp"

/// Stage 5, ray_gen: one ray per vertex left, along its inward normal.
namespace pierce::stages {

/// The unit inward direction at a vertex, in the body's space; zero where there is none.
PIERCE_HD inline Vec3d inward_direction(const BodyView& body, std::uint32_t vertex) {
    const Vec3d n = body.motion == Motion::deforming ? vertex_normal(body.mesh, body.positions, vertex)
                                                     : normalized(to_double(body.mesh.normals[vertex]));
    return -n;
}

/// How far a ray that starts at a vertex of a deforming body can get inside that body's box.
PIERCE_HD inline double box_range(const BodyView& body, Vec3d origin, Vec3d direction) {
    const Matrix3 to_fit = body.fit.rotation.transposed();
    const Vec3d o = to_fit * (origin - body.fit.origin), d = to_fit * direction;
    double range = body.fit_box.extent();
    for (int i = 0; i < 3; ++i)
        if (d[i] != 0) range = min_of(((d[i] > 0 ? body.fit_box.upper[i] : body.fit_box.lower[i]) - o[i]) / d[i], range);
    return max_of(range, 0.0) + body.touch;
}

/// How far an inward ray from `vertex` may go before it leaves its own body for certain.
PIERCE_HD inline double inward_range(const BodyView& source, const BodyView& target, std::uint32_t vertex, Vec3d direction) {
    if (!source.mesh.closed) return source.range;
    if (source.motion != Motion::deforming) return source.own_exit[vertex];
    // Its own exit is looked for later; until then both boxes limit the ray.
    return min_of(target.fit_box.extent(), box_range(source, to_double(source.positions[vertex]), direction));
}

/// Per kept patch: writes its rays. Reads masks and offsets; writes rays and their sources.
struct GenerateRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;
    View<const std::uint32_t> masks, offsets;
    View<Ray> rays;
    View<RaySource> sources;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const CullItem item = patches[i];
        const DirectedPair& d = directed[item.directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        std::uint32_t slot = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1) {
            const auto k = static_cast<std::uint32_t>(std::countr_zero(mask));
            const std::uint32_t v = source.mesh.patch_vertices[patch_begin(item.index) + k];
            const Vec3d direction = inward_direction(source, v);
            Ray ray;
            ray.origin = d.to_space.to_parent(to_double(source.positions[v]));
            ray.direction = normalized(d.to_space.rotation * direction);
            ray.t_max = length_squared(direction) > 0 ? inward_range(source, target, v, direction) : -1.0;
            ray.target = d.target;
            rays[slot] = ray;
            sources[slot] = {item.directed / 2, item.directed % 2, v};
            ++slot;
        }
    }
};

}  // namespace pierce::stages
