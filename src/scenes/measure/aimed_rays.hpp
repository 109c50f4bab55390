#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/trace/ray.hpp"
#include "pierce/mesh.hpp"

namespace pierce::scenes {

/// Where rays look for holes in a surface.
enum class Aim : std::uint8_t { vertices, edges };

/// Makes rays to vertices of a mesh or to points of its edges, as exact as double is. They start at
/// points that are no further than `spread` from `center` in each coordinate. Each ray ends at the
/// point it is aimed at.
class AimedRays {
public:
    AimedRays(const MeshData& mesh, Vec3d center, double spread, Aim aim, std::uint32_t seed);

    std::vector<Ray> next(std::size_t count);

private:
    const MeshData& mesh_;
    Vec3d center_;
    double spread_;
    Aim aim_;
    std::mt19937_64 engine_;
};

}  // namespace pierce::scenes
