#include "scenes/recording/lattice.hpp"

#include <cmath>

#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

Pose pose_in_lattice(std::uint32_t i, std::uint32_t side, double time) {
    const double t = time + 0.7 * i;
    const std::uint32_t x = i % side, y = i / side % side, z = i / side / side;
    return {{4.2 * x, 4.2 * y, 1.7 * z},
            {0.2 * std::sin(t), 0.2 * std::cos(1.3 * t), 0.1 * std::sin(0.7 * i), 0.9}};
}

void add_pose(RecordedBody& body, const Pose& p) {
    for (double value : {p.position.x, p.position.y, p.position.z, p.rotation.x, p.rotation.y,
                         p.rotation.z, p.rotation.w})
        body.values.push_back(static_cast<float>(value));
}

void add_bent(RecordedBody& body, const MeshData& mesh, const Pose& pose, double phase) {
    const Frame at = frame_of(pose);
    for (const Vec3f& v : mesh.positions) {
        const Vec3d p = to_double(v);
        const double squeeze = 1 + 0.03 * std::sin(2 * phase + p.x);
        const Vec3f q = to_float(at.to_parent({p.x * squeeze, p.y / squeeze, p.z * squeeze}));
        body.values.insert(body.values.end(), {q.x, q.y, q.z});
    }
}

}  // namespace

Recording lattice(std::uint32_t count, std::uint32_t frames, LatticeMotion motion,
                  std::uint32_t side) {
    if (side == 0)
        side = static_cast<std::uint32_t>(std::ceil(std::cbrt(static_cast<double>(count))));
    Recording recording;
    recording.dt = SceneSetup{}.dt;
    recording.frame_count = frames;
    recording.meshes.push_back({"torus", torus(2, 0.5, 30, 10), {}});
    recording.bodies.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        RecordedBody& body = recording.bodies[i];
        body.name = "torus " + std::to_string(i);
        body.motion = motion == LatticeMotion::soft ? Motion::deforming : Motion::rigid;
        for (std::uint32_t f = 0; f < frames; ++f) {
            const double time = motion == LatticeMotion::rest ? 0 : 0.05 * f;
            const Pose pose = pose_in_lattice(i, side, time);
            if (motion == LatticeMotion::soft)
                add_bent(body, recording.meshes[0].data, pose, time + 0.7 * i);
            else
                add_pose(body, pose);
        }
    }
    return recording;
}

}  // namespace pierce::scenes
