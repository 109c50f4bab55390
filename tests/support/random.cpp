#include "support/random.hpp"

#include <cstdlib>

#include "scenes/named/shapes.hpp"

namespace pierce::test {

Random::Random(std::uint32_t seed) : seed_(seed) {
    if (const char* given = std::getenv("PIERCE_TEST_SEED"))
        seed_ = static_cast<std::uint32_t>(std::atoll(given));
    engine_.seed(seed_);
}

Vec3d Random::unit_vector() {
    for (;;) {
        const Vec3d v = in_box(1);
        if (length_squared(v) > 0.01 && length_squared(v) < 1) return normalized(v);
    }
}

Quaternion Random::rotation() {
    const Vec3d v = unit_vector();
    return {v.x, v.y, v.z, uniform(-2, 2)};
}

MeshData random_closed_mesh(Random& random) {
    switch (random.integer(0, 3)) {
        case 0: {
            MeshData mesh = scenes::sphere(1, random.integer(1, 3));
            const Vec3d wave = 6.0 * random.unit_vector();
            const double height = random.uniform(0, 0.3);
            for (Vec3f& p : mesh.positions) {
                const Vec3d d = to_double(p);
                p = to_float((1 + height * std::sin(dot(wave, d))) * d);
            }
            return mesh;
        }
        case 1: {
            // Compilers evaluate arguments in different orders.
            const int across = random.integer(4, 12), around = random.integer(5, 30);
            const double tube = random.uniform(0.1, 0.4);
            return scenes::torus(0.8, tube, static_cast<std::uint32_t>(around),
                                 static_cast<std::uint32_t>(across));
        }
        case 2: {
            const Vec3d half{random.uniform(0.05, 1), random.uniform(0.3, 1),
                             random.uniform(0.5, 1)};
            return scenes::box(-half, half);
        }
        default: {
            MeshData mesh = scenes::sphere(1, 2);
            for (Vec3f& p : mesh.positions) p = static_cast<float>(random.uniform(0.5, 1)) * p;
            return mesh;
        }
    }
}

MeshData random_overlapping_parts(Random& random) {
    MeshData all;
    for (int parts = random.integer(2, 4); parts > 0; --parts) {
        const MeshData part = random_closed_mesh(random);
        const auto first = static_cast<std::uint32_t>(all.positions.size());
        for (Vec3f p : placed(part, {random.in_box(0.7), random.rotation()}))
            all.positions.push_back(p);
        for (const Triangle& t : part.triangles)
            all.triangles.push_back(
                {{first + t.vertex[0], first + t.vertex[1], first + t.vertex[2]}});
    }
    return all;
}

std::vector<Vec3f> placed(const MeshData& mesh, const Pose& pose) {
    const Frame frame = frame_of(pose);
    std::vector<Vec3f> positions;
    for (Vec3f p : mesh.positions) positions.push_back(to_float(frame.to_parent(to_double(p))));
    return positions;
}

}  // namespace pierce::test
