#include "physical/measures.hpp"

#include <algorithm>

#include "core/geometry/closest_point.hpp"
#include "pierce/embree_backend.hpp"
#include "scenes/named/mass_properties.hpp"

namespace pierce::physical {
namespace {

Vec3d vertex_place(const Pose& pose, Vec3f p) { return frame_of(pose).to_parent(to_double(p)); }

}  // namespace

Mechanics::Mechanics(const Scene& scene)
    : scene_(scene), mass_(scene.bodies.size()), inertia_(scene.bodies.size()) {
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        if (scene.bodies[b].fixed) continue;
        const auto properties = scenes::mass_properties(scene.meshes[scene.bodies[b].mesh].data);
        mass_[b] = properties.mass;
        inertia_[b] = properties.inertia;
    }
}

/// The angular momentum about the centre of mass.
Vec3d Mechanics::spin(std::size_t body, const BodyState& state) const {
    const Frame frame{frame_of(state.pose).rotation, {}};
    const Vec3d w = frame.to_local(state.angular_velocity), i = inertia_[body];
    return frame.to_parent({i.x * w.x, i.y * w.y, i.z * w.z});
}

double Mechanics::energy_per_mass(std::span<const BodyState> states) const {
    double energy = 0, all = 0;
    for (std::size_t b = 0; b < states.size(); ++b) {
        const BodyState& s = states[b];
        energy += mass_[b] *
                      (0.5 * length_squared(s.velocity) + scene_.gravity * s.pose.position.z) +
                  0.5 * dot(s.angular_velocity, spin(b, s));
        all += mass_[b];
    }
    return energy / all;
}

Vec3d Mechanics::momentum(std::span<const BodyState> states) const {
    Vec3d sum;
    for (std::size_t b = 0; b < states.size(); ++b) sum += mass_[b] * states[b].velocity;
    return sum;
}

Vec3d Mechanics::angular_momentum(std::span<const BodyState> states) const {
    Vec3d sum;
    for (std::size_t b = 0; b < states.size(); ++b)
        sum += cross(states[b].pose.position, mass_[b] * states[b].velocity) + spin(b, states[b]);
    return sum;
}

double Mechanics::momentum_size(std::span<const BodyState> states) const {
    double sum = 0;
    for (std::size_t b = 0; b < states.size(); ++b) sum += mass_[b] * length(states[b].velocity);
    return sum;
}

double Mechanics::angular_momentum_size(std::span<const BodyState> states) const {
    double sum = 0;
    for (std::size_t b = 0; b < states.size(); ++b)
        sum += length(cross(states[b].pose.position, mass_[b] * states[b].velocity) +
                      spin(b, states[b]));
    return sum;
}

std::vector<double> Mechanics::speeds(std::span<const BodyState> states) const {
    std::vector<double> result;
    for (std::size_t b = 0; b < states.size(); ++b) {
        if (scene_.bodies[b].fixed) continue;
        const BodyState& s = states[b];
        double fastest = 0;
        for (Vec3f p : scene_.meshes[scene_.bodies[b].mesh].data.positions) {
            const Vec3d arm = vertex_place(s.pose, p) - s.pose.position;
            fastest = std::max(fastest, length(s.velocity + cross(s.angular_velocity, arm)));
        }
        result.push_back(fastest);
    }
    return result;
}

double Mechanics::moved(std::span<const BodyState> states,
                        std::span<const BodyState> earlier) const {
    double farthest = 0;
    for (std::size_t b = 0; b < states.size(); ++b)
        for (Vec3f p : scene_.meshes[scene_.bodies[b].mesh].data.positions)
            farthest = std::max(farthest, length(vertex_place(states[b].pose, p) -
                                                 vertex_place(earlier[b].pose, p)));
    return farthest;
}

DepthGauge::DepthGauge(const Scene& scene)
    : scene_(scene), world_(embree_backend(1), {.coverage = Coverage::complete}) {
    std::vector<MeshId> meshes;
    for (const scenes::SceneMesh& mesh : scene.meshes)
        meshes.push_back(world_.add_mesh(mesh.name, mesh.data));
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        const Body& body = scene.bodies[b];
        place_[body.fixed ? world_.add_fixed_body(meshes[body.mesh], body.pose)
                          : world_.add_rigid_body(meshes[body.mesh], body.pose)] = b;
    }
}

/// A contact by separation says how far the whole body has to go; here, as with all others, its
/// point is as deep as it is away from the surface.
double DepthGauge::depth_of(const Contact& contact, std::span<const BodyState> states) const {
    if (contact.found != Found::separation) return contact.penetration_depth();
    const bool from_a = contact.source == Side::a;
    const std::size_t target = place_.at(from_a ? contact.b : contact.a);
    const Vec3d point = frame_of(states[target].pose)
                            .to_local(from_a ? contact.point_a : contact.point_b);
    const MeshData& mesh = scene_.meshes[scene_.bodies[target].mesh].data;
    double depth = contact.penetration_depth();
    for (const Triangle& t : mesh.triangles)
        depth = std::min(
            depth, length(point - closest_on_triangle(point, to_double(mesh.positions[t.vertex[0]]),
                                                      to_double(mesh.positions[t.vertex[1]]),
                                                      to_double(mesh.positions[t.vertex[2]]))));
    return depth;
}

double DepthGauge::deepest(std::span<const BodyState> states) {
    for (const auto& [body, place] : place_) world_.set_pose(body, states[place].pose);
    world_.detect();
    double depth = 0;
    for (const Contact& c : world_.contacts()) depth = std::max(depth, depth_of(c, states));
    return depth;
}

}  // namespace pierce::physical
