#include "scenes/recording/recording.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/usable.hpp"
#include "pierce/error.hpp"
#include "scenes/recording/frame_layout.hpp"

namespace pierce::scenes {

std::uint32_t mesh_of(const RecordedBody& body, std::uint32_t frame) {
    std::uint32_t mesh = body.mesh;
    for (const RecordedMeshChange& change : body.mesh_changes)
        if (change.frame <= frame) mesh = change.mesh;
    return mesh;
}

std::size_t frame_size(const Recording& recording, const RecordedBody& body, std::uint32_t frame) {
    if (body.motion != Motion::deforming) return pose_size;
    return 3 * recording.meshes[mesh_of(body, frame)].data.positions.size();
}

std::size_t frame_begin(const Recording& recording, const RecordedBody& body, std::uint32_t frame) {
    std::size_t begin = 0;
    std::uint32_t first = 0;
    for (const RecordedMeshChange& change : body.mesh_changes) {
        if (change.frame >= frame) break;
        begin += (change.frame - first) * frame_size(recording, body, first);
        first = change.frame;
    }
    return begin + (frame - first) * frame_size(recording, body, first);
}

Pose Recording::pose(std::uint32_t body, std::uint32_t frame) const {
    const std::vector<float>& v = bodies[body].values;
    const float* p = v.data() + (v.size() == pose_size ? 0 : pose_size * frame);
    return {{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
}

std::span<const float> Recording::numbers(std::uint32_t body, std::uint32_t frame) const {
    const RecordedBody& b = bodies[body];
    return {b.values.data() + frame_begin(*this, b, frame), frame_size(*this, b, frame)};
}

std::span<const Vec3f> Recording::positions(std::uint32_t body, std::uint32_t frame) const {
    static_assert(sizeof(Vec3f) == 3 * sizeof(float));
    const std::span<const float> all = numbers(body, frame);
    return {reinterpret_cast<const Vec3f*>(all.data()), all.size() / 3};
}

std::span<const Vec3f> Recording::start_positions(std::uint32_t body, std::uint32_t from,
                                                  std::uint32_t frame) const {
    return positions(body, mesh_of(body, from) == mesh_of(body, frame) ? from : frame);
}

std::uint32_t Recording::mesh_of(std::uint32_t body, std::uint32_t frame) const {
    return scenes::mesh_of(bodies[body], frame);
}

Inside inside_of(const Recording& recording, std::uint32_t mesh) {
    if (recording.meshes[mesh].inside != Inside::automatic) return recording.meshes[mesh].inside;
    for (const RecordedBody& body : recording.bodies)
        if (body.collision.sheet &&
            (body.mesh == mesh || std::ranges::any_of(body.mesh_changes, [&](const auto& change) {
                 return change.mesh == mesh;
             })))
            return Inside::none;
    return Inside::automatic;
}

void require_lasting_meshes(const Recording& recording, const std::string& what) {
    for (const RecordedBody& body : recording.bodies)
        if (!body.mesh_changes.empty())
            throw InputError(what + " needs meshes that stay, and that of body '" + body.name +
                             "' changes");
}

namespace {

/// A pose that a new body may have: that of the first frame that has one. A body whose pose is not
/// usable is left out of a frame.
Pose first_pose(const Recording& recording, std::uint32_t body) {
    for (std::uint32_t f = 0; f < recording.frame_count; ++f)
        if (const Pose pose = recording.pose(body, f); is_usable(pose)) return pose;
    return {};
}

}  // namespace

SceneSetup scene_of(const Recording& recording) {
    SceneSetup scene{.name = "recording",
                     .meshes = recording.meshes,
                     .bodies = {},
                     .excluded = recording.excluded};
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        const RecordedBody& body = recording.bodies[b];
        const Pose pose = body.motion == Motion::deforming ? Pose{} : first_pose(recording, b);
        scene.bodies.push_back(
            {body.name, body.mesh, body.motion, pose, body.ground, body.collision});
        scene.bodies.back().filter = body.filter;
    }
    return scene;
}

void check_time_step(double dt, const std::string& what) {
    if (!(dt > 0) || std::isinf(dt)) throw InputError(what + " must be positive");
}

Recording start_recording(const SceneSetup& scene, double dt) {
    Recording recording{.dt = dt,
                        .frame_count = 0,
                        .meshes = scene.meshes,
                        .bodies = {},
                        .excluded = scene.excluded};
    for (const SceneBody& b : scene.bodies)
        recording.bodies.push_back({.name = b.name,
                                    .mesh = b.mesh,
                                    .motion = b.motion,
                                    .ground = b.ground,
                                    .values = {},
                                    .collision = b.collision,
                                    .mesh_changes = {},
                                    .filter = b.filter});
    return recording;
}

}  // namespace pierce::scenes
