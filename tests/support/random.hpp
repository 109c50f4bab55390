#pragma once

#include <gtest/gtest.h>

#include <random>

#include "pierce/mesh.hpp"
#include "pierce/pose.hpp"

namespace pierce::test {

/// A seeded generator. The seed is printed with every failure in its scope; PIERCE_TEST_SEED
/// replaces it.
class Random {
public:
    explicit Random(std::uint32_t seed);

    std::uint32_t seed() const { return seed_; }
    double uniform(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(engine_);
    }
    int integer(int low, int high) {
        return std::uniform_int_distribution<int>(low, high)(engine_);
    }
    Vec3d in_box(double half) {
        return {uniform(-half, half), uniform(-half, half), uniform(-half, half)};
    }
    Vec3d unit_vector();
    Quaternion rotation();

private:
    std::uint32_t seed_;
    std::mt19937 engine_;
};

/// A closed mesh of random shape: a bumpy sphere, a torus of random proportions, a box, or a
/// star-shaped thing with spikes. Diameter about 2.
MeshData random_closed_mesh(Random& random);

/// Two to four such meshes in one, each turned and near the others, so that most overlap.
MeshData random_overlapping_parts(Random& random);

/// `mesh` moved by a pose, as float32 positions.
std::vector<Vec3f> placed(const MeshData& mesh, const Pose& pose);

}  // namespace pierce::test
