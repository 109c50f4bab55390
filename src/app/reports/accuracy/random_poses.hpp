#pragma once

#include <cstdint>
#include <random>

#include "pierce/mesh.hpp"
#include "pierce/pose.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::app {

/// Random numbers that are the same on every machine: the engine's are, the standard's
/// distributions are not.
class RandomPoses {
public:
    explicit RandomPoses(std::uint32_t seed) : engine_(seed) {}

    double uniform(double low, double high) {
        return low + (high - low) * static_cast<double>(engine_()) / 0x1p32;
    }
    Quaternion rotation() {
        for (;;) {
            const Quaternion q{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
            const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
            if (norm < 1 && norm > 0.01) return q;
        }
    }
    Vec3d direction() {
        for (;;) {
            const Vec3d d{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
            if (length(d) < 1 && length(d) > 0.1) return normalized(d);
        }
    }

private:
    std::mt19937 engine_;
};

/// Two bodies that turn up in `poses` random rotations, at a distance between two bounds.
inline scenes::Recording random_pairs(const MeshData& a, const MeshData& b, double nearest,
                                      double farthest, std::uint32_t poses, std::uint32_t seed) {
    scenes::Recording recording{.dt = 1,
                                .frame_count = poses,
                                .meshes = {{"first", a, {}}, {"second", b, {}}},
                                .bodies = {}};
    for (std::uint32_t k : {0u, 1u})
        recording.bodies.push_back({.name = k == 0 ? "first" : "second",
                                    .mesh = k,
                                    .motion = Motion::rigid,
                                    .ground = false,
                                    .values = {}});
    RandomPoses random(seed);
    for (std::uint32_t i = 0; i < poses; ++i) {
        const double distance = random.uniform(nearest, farthest);
        const Vec3d apart = distance * random.direction();
        for (scenes::RecordedBody& body : recording.bodies) {
            const Vec3d p = body.mesh == 0 ? Vec3d{} : apart;
            const Quaternion q = random.rotation();
            for (double value : {p.x, p.y, p.z, q.x, q.y, q.z, q.w})
                body.values.push_back(static_cast<float>(value));
        }
    }
    return recording;
}

}  // namespace pierce::app
