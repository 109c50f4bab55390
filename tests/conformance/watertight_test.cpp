// No ray aimed at a vertex or an edge slips out of a closed mesh. PIERCE_LEAK_RAYS sets how many
// are tried in all; the bench program pierce_leaks compares other triangle tests.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "scenes/measure/aimed_rays.hpp"
#include "scenes/measure/ray_probe.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"

namespace pierce {
namespace {

using scenes::Aim;

std::size_t rays_in_all() {
    const char* given = std::getenv("PIERCE_LEAK_RAYS");
    return given != nullptr ? static_cast<std::size_t>(std::atoll(given)) : 1'000'000;
}

MeshData bumpy_ball() {
    MeshData mesh = scenes::sphere(1, 3);
    for (Vec3f& p : mesh.positions) {
        const Vec3d d = to_double(p);
        p = to_float((1 + 0.2 * std::sin(7 * d.x) * std::cos(5 * d.y + 3 * d.z)) * d);
    }
    return mesh;
}

MeshData at(MeshData mesh, Vec3d center) {
    for (Vec3f& p : mesh.positions) p = to_float(to_double(p) + center);
    return mesh;
}

class WatertightTest : public testing::TestWithParam<test::NamedBackend> {};

TEST_P(WatertightTest, NoRayAtAVertexOrAnEdgeIsLost) {
    scenes::RayProbe probe(GetParam().make());
    const bool looks_at_all = GetParam().name == "reference";  // 1280 triangles for each ray
    const std::size_t share = rays_in_all() /
                              (looks_at_all ? 400 : 8 * (test::backends().size() - 1));
    std::uint32_t seed = 1;
    for (const MeshData& mesh : {scenes::sphere(1, 3), bumpy_ball()})
        for (double offset : {0.0, 1e5})
            for (Aim aim : {Aim::vertices, Aim::edges}) {
                const Vec3d center{offset, offset, offset};
                const MeshData moved = at(mesh, center);
                scenes::AimedRays rays(moved, center, 0.3, aim, seed++);
                for (std::size_t left = share; left > 0;) {
                    const std::size_t count = std::min<std::size_t>(left, 1 << 18);
                    const auto met = probe.meet(moved, rays.next(count));
                    ASSERT_EQ(std::ranges::count(met, scenes::Meets::exit, &scenes::Met::how),
                              std::ssize(met))
                        << "offset " << offset << (aim == Aim::vertices ? ", vertices" : ", edges");
                    left -= count;
                }
            }
}

INSTANTIATE_TEST_SUITE_P(Backends, WatertightTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
