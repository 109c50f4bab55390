#include "scenes/measure/aimed_rays.hpp"

namespace pierce::scenes {

AimedRays::AimedRays(const MeshData& mesh, Vec3d center, double spread, Aim aim, std::uint32_t seed)
    : mesh_(mesh), center_(center), spread_(spread), aim_(aim), engine_(seed) {}

std::vector<Ray> AimedRays::next(std::size_t count) {
    std::uniform_real_distribution<double> within(-spread_, spread_), part(0, 1);
    std::uniform_int_distribution<std::size_t> any(0, mesh_.triangles.size() - 1);
    std::vector<Ray> rays(count);
    for (Ray& ray : rays) {
        const Triangle& t = mesh_.triangles[any(engine_)];
        const Vec3d a = to_double(mesh_.positions[t.vertex[0]]),
                    b = to_double(mesh_.positions[t.vertex[1]]);
        const double along = aim_ == Aim::edges ? part(engine_) : 0;
        ray.origin = center_ + Vec3d{within(engine_), within(engine_), within(engine_)};
        const Vec3d way = (1 - along) * a + along * b - ray.origin;
        ray.direction = normalized(way);
        ray.t_max = length(way);
    }
    return rays;
}

}  // namespace pierce::scenes
