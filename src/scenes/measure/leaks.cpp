#include "scenes/measure/leaks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "pierce/embree_backend.hpp"
#include "scenes/measure/leak_kernels.hpp"
#include "scenes/measure/ray_probe.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

using leaks::RayF;

using Kernel = bool (*)(const RayF&, Vec3f, Vec3f, Vec3f);

struct NamedKernel {
    const char* name;
    bool fma;
    Kernel kernel;
};

constexpr NamedKernel kernels[] = {
    {"moeller_trumbore", false, leaks::moeller_trumbore<false>},
    {"moeller_trumbore", true, leaks::moeller_trumbore<true>},
    {"pluecker", false, leaks::pluecker<false>},
    {"pluecker", true, leaks::pluecker<true>},
    {"watertight", false, leaks::watertight<false, false>},
    {"watertight", true, leaks::watertight<true, false>},
    {"watertight_double", false, leaks::watertight<false, true>},
    {"watertight_double", true, leaks::watertight<true, true>},
    {"pierce", false, leaks::pierce_test},
};

MeshData ball_at(double radius, Vec3d center) {
    MeshData mesh = sphere(radius, 3);
    for (Vec3f& p : mesh.positions) p = to_float(to_double(p) + center);
    return mesh;
}

/// True if the closed surface goes around the point once (Van Oosterom and Strackee 1983): rounding
/// may have crushed the surface.
bool is_inside(Vec3d p, const MeshData& mesh) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles) {
        Vec3d v[3];
        for (int k = 0; k < 3; ++k) v[k] = to_double(mesh.positions[t.vertex[k]]) - p;
        const double a = length(v[0]), b = length(v[1]), c = length(v[2]);
        sum += 2 * std::atan2(
                       dot(v[0], cross(v[1], v[2])),
                       a * b * c + dot(v[0], v[1]) * c + dot(v[1], v[2]) * a + dot(v[2], v[0]) * b);
    }
    return std::abs(sum / (4 * std::numbers::pi) - 1) < 0.25;  // a whole number, except 1/2 on the
                                                               // surface
}

}  // namespace

LeakCount count_tracer_leaks(double offset, Aim aim, std::size_t rays) {
    const Vec3d center{offset, offset, offset};
    const MeshData ball = ball_at(1, center);
    RayProbe probe(embree_backend());
    AimedRays aimed(ball, center, 0.3, aim, 1);
    std::size_t leaks = 0;
    for (std::size_t left = rays; left > 0;) {
        const std::size_t batch = std::min<std::size_t>(left, 1 << 18);
        for (const Met& met : probe.meet(ball, aimed.next(batch))) leaks += met.how != Meets::exit;
        left -= batch;
    }
    return {.offset = offset,
            .kernel = "pierce_embree",
            .fma = false,
            .aim = aim,
            .rays = rays,
            .leaks = leaks};
}

std::vector<LeakCount> count_kernel_leaks(double offset, Aim aim, std::size_t rays) {
    const Vec3d center{offset, offset, offset};
    const double radius = 16;
    const MeshData ball = ball_at(radius, center);
    std::vector<std::vector<std::uint32_t>> around(ball.positions.size());
    for (std::uint32_t t = 0; t < ball.triangles.size(); ++t)
        for (std::uint32_t v : ball.triangles[t].vertex) around[v].push_back(t);

    std::mt19937_64 engine(2);
    std::uniform_real_distribution<double> within(-0.3 * radius, 0.3 * radius), part(0, 1);
    std::uniform_int_distribution<std::size_t> any(0, ball.triangles.size() - 1);
    std::vector<Vec3f> origins;
    for (int i = 0; i < 200; ++i) {
        const Vec3f origin = to_float(center +
                                      Vec3d{within(engine), within(engine), within(engine)});
        if (is_inside(to_double(origin), ball)) origins.push_back(origin);
    }
    std::vector<LeakCount> counts;
    for (const NamedKernel& k : kernels)
        counts.push_back({.offset = offset,
                          .kernel = k.name,
                          .fma = k.fma,
                          .aim = aim,
                          .rays = origins.empty() ? 0 : rays,
                          .leaks = 0});
    for (std::size_t i = 0; i < counts[0].rays; ++i) {
        const Triangle& aimed = ball.triangles[any(engine)];
        const Vec3d a = to_double(ball.positions[aimed.vertex[0]]),
                    b = to_double(ball.positions[aimed.vertex[1]]);
        const double along = aim == Aim::edges ? part(engine) : 0;
        const Vec3f origin = origins[i % origins.size()];
        const RayF ray{origin,
                       to_float(normalized((1 - along) * a + along * b - to_double(origin)))};
        for (std::size_t k = 0; k < std::size(kernels); ++k) {
            const auto meets = [&](std::uint32_t t) {
                const std::uint32_t* v = ball.triangles[t].vertex;
                return kernels[k].kernel(ray, ball.positions[v[0]], ball.positions[v[1]],
                                         ball.positions[v[2]]);
            };
            // Nearly all rays meet the triangles that they are aimed at; only the others are tested
            // against all triangles.
            bool met = std::ranges::any_of(around[aimed.vertex[0]], meets);
            for (std::uint32_t t = 0; t < ball.triangles.size() && !met; ++t) met = meets(t);
            counts[k].leaks += !met;
        }
    }
    return counts;
}

std::vector<double> leak_offsets() {
    std::vector<double> offsets{0};
    for (int k = 0; k <= 24; ++k) offsets.push_back(std::ldexp(1.0, k));
    return offsets;
}

}  // namespace pierce::scenes
