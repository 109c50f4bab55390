// The triangle closest to a point: every tracer's is brute force's, to the last bit and the
// smallest id.
#include <gtest/gtest.h>

#include <cmath>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/execute/serial_executor.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/brute_force_tracer.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "cpu_embree/embree_tracer.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

BodyView body_of(const Mesh& mesh, Motion motion, std::uint64_t key) {
    BodyView body;
    body.mesh = mesh.view();
    body.positions = body.mesh.positions;
    body.fit_box = body.world_box = body.mesh.box;
    body.touch = constants::touch_tolerance * body.mesh.box.extent();
    body.motion = motion;
    body.mesh_key = key;
    return body;
}

/// Points to ask from, all near a mesh's box: anywhere, on its vertices, edges and triangles, and
/// at their mirror images.
std::vector<Vec3d> points_around(const Mesh& mesh, test::Random& random) {
    const Box box = mesh.view().box;
    std::vector<Vec3d> points{box.center()};
    for (int i = 0; i < 40; ++i) {
        Vec3d weight = random.in_box(0.6);
        points.push_back(box.center());
        for (int k = 0; k < 3; ++k) points.back()[k] += weight[k] * (box.upper[k] - box.lower[k]);
        const Triangle t = mesh.view().triangles[static_cast<std::size_t>(
            random.integer(0, static_cast<int>(mesh.view().triangles.size) - 1))];
        const auto corner = [&](int k) { return to_double(mesh.view().positions[t.vertex[k]]); };
        points.push_back(corner(0));
        points.push_back(0.5 * (corner(0) + corner(1)));
        points.push_back((1.0 / 3) * (corner(0) + corner(1) + corner(2)));
    }
    return points;
}

template <class T, class E>
std::vector<std::uint32_t> closest(T& tracer, E& executor, const BodyView& body,
                                   const std::vector<Ray>& rays) {
    const std::vector<std::uint32_t> wanted{1};
    std::vector<std::uint32_t> triangles(rays.size(), 12345);
    const View<const BodyView> bodies{&body, 1};
    tracer.update(executor, bodies, view_of(wanted));
    tracer.closest_triangles(executor, bodies, static_cast<std::uint32_t>(rays.size()),
                             view_of(rays), view_of(triangles));
    return triangles;
}

/// Of how many points the closest triangle is not the only one as close.
int expect_all_tracers_agree(const BodyView& body, const std::vector<Ray>& rays) {
    SerialExecutor serial;
    BruteForceTracer brute_force;
    BvhTracer<SerialExecutor> bvh;
    TbbExecutor parallel(2);
    EmbreeTracer embree;
    const std::vector<std::uint32_t> expected = closest(brute_force, serial, body, rays);
    EXPECT_EQ(closest(bvh, serial, body, rays), expected);
    EXPECT_EQ(closest(embree, parallel, body, rays), expected);
    int ties = 0;
    const Surface surface = body.surface();
    for (std::size_t i = 0; i < rays.size(); ++i) {
        double nearest = INFINITY;
        std::uint32_t first = no_triangle, as_close = 0;
        for (std::uint32_t t = 0; t < surface.triangles.size; ++t) {
            const double distance = distance_to(rays[i].origin, surface, t);
            as_close = distance < nearest ? 1 : as_close + (distance == nearest);
            if (distance < nearest) first = t;
            nearest = std::min(nearest, distance);
        }
        EXPECT_EQ(expected[i], nearest <= rays[i].t_max ? first : no_triangle) << "ray " << i;
        ties += as_close > 1;
    }
    return ties;
}

std::vector<Ray> rays_from(const std::vector<Vec3d>& points, double limit) {
    std::vector<Ray> rays(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        rays[i] = {.origin = points[i], .direction = {0, 0, 1}, .t_max = limit};
    return rays;
}

TEST(ClosestTrianglesTest, OfRandomMeshesAreBruteForces) {
    test::Random random(61);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int m = 0; m < 40 && !HasFailure(); ++m) {
        SCOPED_TRACE("mesh " + std::to_string(m));
        MeshData data = test::random_closed_mesh(random);
        const auto far = static_cast<float>(m % 4 == 3 ? std::exp2(random.integer(4, 16)) : 0);
        for (Vec3f& p : data.positions) p += Vec3f{far, -far, far};
        const Mesh mesh("any", data);
        const double limit = m % 3 == 0 ? mesh.view().box.extent() : random.uniform(0, 0.3);
        for (Motion motion : {Motion::rigid, Motion::deforming})
            expect_all_tracers_agree(body_of(mesh, motion, 1),
                                     rays_from(points_around(mesh, random), limit));
    }
}

TEST(ClosestTrianglesTest, OfPointsFarAwayAreBruteForces) {
    test::Random random(63);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int m = 0; m < 40 && !HasFailure(); ++m) {
        SCOPED_TRACE("mesh " + std::to_string(m));
        const Mesh mesh("any", test::random_closed_mesh(random));
        std::vector<Vec3d> points;
        for (int i = 0; i < 60; ++i)
            points.push_back(std::exp2(random.uniform(2, 24)) * mesh.view().box.extent() *
                             random.in_box(1));
        for (Motion motion : {Motion::rigid, Motion::deforming})
            expect_all_tracers_agree(body_of(mesh, motion, 1), rays_from(points, 0x1p30));
    }
}

TEST(ClosestTrianglesTest, OfEquallyCloseOnesTheFirstIsTaken) {
    // From the diagonal planes of a box, near its middle, two faces or more are equally close.
    test::Random random(62);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const Mesh box("box", scenes::box({-1, -1, -1}, {1, 1, 1}));
    std::vector<Vec3d> points{{}};
    for (int i = 0; i < 50; ++i) {
        const int far = random.integer(0, 4);
        const double x = far / 8.0, y = random.integer(-far, far) / 8.0;
        for (Vec3d p : {Vec3d{x, x, y}, Vec3d{-x, y, x}, Vec3d{y, x, -x}, Vec3d{-x, -x, -x}})
            points.push_back(p);
    }
    EXPECT_EQ(expect_all_tracers_agree(body_of(box, Motion::rigid, 1), rays_from(points, 1)),
              static_cast<int>(points.size()));

    // Every triangle has a twin.
    MeshData twice = scenes::sphere(1, 2);
    const std::size_t count = twice.triangles.size();
    for (std::size_t t = 0; t < count; ++t)
        twice.triangles.push_back(twice.triangles[count - 1 - t]);
    const Mesh twins("twins", twice);
    const std::vector<Vec3d> around = points_around(twins, random);
    EXPECT_EQ(expect_all_tracers_agree(body_of(twins, Motion::rigid, 2), rays_from(around, 2)),
              static_cast<int>(around.size()));
}

TEST(ClosestTrianglesTest, LimitsAreInclusiveAndEndTheSearch) {
    const Mesh box("box", scenes::box({-1, -1, -1}, {1, 1, 1}));
    std::vector<Ray> rays = rays_from({{}, {}, {}, {}, {}}, 1);
    rays[1].t_max = std::nextafter(1.0, 0.0);
    rays[2].t_max = 0;
    rays[3].t_max = -1;
    rays[4].origin = {1, 0.5, 0.25};
    rays[4].t_max = 0;
    expect_all_tracers_agree(body_of(box, Motion::rigid, 1), rays);
    SerialExecutor serial;
    BruteForceTracer brute_force;
    const std::vector<std::uint32_t> found = closest(brute_force, serial,
                                                     body_of(box, Motion::rigid, 1), rays);
    EXPECT_EQ(found[0], 0u);
    for (int i : {1, 2, 3}) EXPECT_EQ(found[static_cast<std::size_t>(i)], no_triangle) << i;
    EXPECT_NE(found[4], no_triangle);
}

}  // namespace
}  // namespace pierce
