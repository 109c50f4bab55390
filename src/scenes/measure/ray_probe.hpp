#pragma once

#include <memory>
#include <vector>

#include "pierce/backend.hpp"
#include "pierce/body.hpp"
#include "scenes/named/hard_cases.hpp"

namespace pierce::scenes {

/// The first meeting of a ray with a mesh.
struct Met {
    Meets how = Meets::nothing;
    double t = 0;  ///< [length]
    std::uint32_t triangle = no_triangle;
};

/// Aims single rays at a mesh, by a backend's own tracer and without a world.
class RayProbe {
public:
    explicit RayProbe(std::unique_ptr<Backend> backend) : backend_(std::move(backend)) {}

    /// [length] The touch tolerance of a ray into the mesh, as if its source were a point.
    static double touch(const MeshData& mesh, Vec3d origin);
    /// What each ray meets first in a body of the mesh. The rays' targets are set to that body.
    std::vector<Met> meet(const MeshData& mesh, std::vector<Ray> rays,
                          Motion motion = Motion::fixed);
    /// What a ray without an end meets first.
    Met meet(const MeshData& mesh, Vec3d origin, Vec3d direction, Motion motion = Motion::fixed);

private:
    std::unique_ptr<Backend> backend_;
    std::uint64_t next_key_ = 1;
};

}  // namespace pierce::scenes
