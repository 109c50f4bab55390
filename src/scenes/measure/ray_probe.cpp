#include "scenes/measure/ray_probe.hpp"

#include <utility>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh_build/leaves.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"

namespace pierce::scenes {
namespace {

constexpr double far = 0x1p14;  // as good as no end [extent of the mesh]

double extent_of(const MeshData& mesh) {
    Box box;
    for (Vec3f p : mesh.positions) box.extend(to_double(p));
    return box.extent();
}

}  // namespace

std::vector<Met> RayProbe::meet(const MeshData& mesh, std::vector<Ray> rays, Motion motion) {
    const std::vector<bvh::Leaf> leaves = bvh::leaves_of(mesh);
    BodyView body;
    body.mesh.positions = body.positions = view_of(mesh.positions);
    body.mesh.triangles = view_of(mesh.triangles);
    body.mesh.leaves = view_of(leaves);
    body.mesh_key = body.positions_version = next_key_++;
    body.motion = motion;
    for (Vec3f p : mesh.positions) body.fit_box.extend(to_double(p));
    body.world_box = body.mesh.box = body.fit_box;
    body.touch = constants::touch_tolerance * body.fit_box.extent();
    for (Ray& ray : rays) {
        ray.target = 0;
        ray.touch = touch(mesh, ray.origin);
    }

    std::vector<Hit> hits(rays.size());
    backend_->closest_hits({&body, 1}, view_of(std::as_const(rays)), view_of(hits));
    std::vector<Met> met(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (hits[i].triangle == no_triangle) continue;
        const Meeting m = pierce::meet(rays[i], body.surface(), hits[i].triangle);
        met[i] = {!m.exit   ? Meets::entry
                  : m.t > 0 ? Meets::exit
                            : Meets::touching,
                  m.t, hits[i].triangle};
    }
    return met;
}

double RayProbe::touch(const MeshData& mesh, Vec3d origin) {
    const double reach = std::min(extent_of(mesh), Box{origin, origin}.max_coordinate());
    return constants::touch_tolerance * reach;
}

Met RayProbe::meet(const MeshData& mesh, Vec3d origin, Vec3d direction, Motion motion) {
    Ray ray;
    ray.origin = origin;
    ray.direction = normalized(direction);
    ray.t_max = far * extent_of(mesh);
    return meet(mesh, std::vector{ray}, motion)[0];
}

}  // namespace pierce::scenes
