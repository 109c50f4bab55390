// What is known of the triangles around a triangle, against brute force.
#include "core/mesh_build/triangle_rings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/geometry/closest_point.hpp"
#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/four_distances.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

/// The distance of two triangles in double: of all their corners and sides; 0 if one passes through
/// the other.
double exact_distance(const Corners& a, const Corners& b) {
    if (edge_pierces(a, b, 0, 0) || edge_pierces(b, a, 0, 0)) return 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        least = std::min(length(a[i] - closest_on_triangle(a[i], b[0], b[1], b[2])), least);
        least = std::min(length(b[i] - closest_on_triangle(b[i], a[0], a[1], a[2])), least);
        for (std::size_t j = 0; j < 3; ++j)
            least = std::min(segment_distance(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]), least);
    }
    return least;
}

double extent_of(const Corners& a, const Corners& b) {
    double extent = 0;
    for (const Vec3d p : a)
        for (const Vec3d q : b) extent = std::max(length(p - q), extent);
    return extent;
}

/// A mesh in which triangles of two solids cross, too.
MeshData random_mesh(test::Random& random, bool crossed) {
    MeshData mesh = test::random_closed_mesh(random);
    if (!crossed) return mesh;
    const MeshData other = test::random_closed_mesh(random);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3f p : other.positions) mesh.positions.push_back({p.x + 0.5f, p.y, p.z});
    for (const Triangle& t : other.triangles)
        mesh.triangles.push_back({{first + t.vertex[0], first + t.vertex[1], first + t.vertex[2]}});
    return mesh;
}

TEST(TriangleRingsTest, NoTriangleOutsideTheRingIsCloserThanTheGap) {
    test::Random random(41);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t zero = 0, limited = 0;
    for (int i = 0; i < 12; ++i) {
        // All triangles of a tetrahedron share vertices.
        const Mesh made("any",
                        i == 0 ? MeshData{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                          {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}}
                               : random_mesh(random, i % 3 == 2),
                        {.inside = Inside::closed});
        const MeshView mesh = made.view();
        const double rounding = constants::touch_tolerance * mesh.box.extent();
        for (std::uint32_t t = 0; t < mesh.triangles.size; t += 11) {
            const Corners own = corners_of(mesh.positions, mesh.triangles[t]);
            double exact = std::numeric_limits<double>::infinity(), extent = 0;
            for (std::uint32_t other = 0; other < mesh.triangles.size; ++other) {
                if (share_vertex(mesh.triangles[t], mesh.triangles[other])) continue;
                const Corners its = corners_of(mesh.positions, mesh.triangles[other]);
                const double distance = exact_distance(own, its);
                if (distance < exact) extent = extent_of(own, its);
                exact = std::min(distance, exact);
            }
            const double gap = static_cast<double>(mesh.rings[t].gap);
            ASSERT_LE(gap, exact) << "mesh " << i << " triangle " << t;
            // It does not reach beyond the ring.
            double reach = 0;
            const Vec3d center = (1.0 / 3) * (own[0] + own[1] + own[2]);
            for (const std::uint32_t v : mesh.triangles[t].vertex)
                for (std::uint32_t c = mesh.corner_offsets[v]; c < mesh.corner_offsets[v + 1]; ++c)
                    reach = std::max(
                        length(to_double(mesh.positions[mesh.corners[c].next]) - center), reach);
            const double lost = std::min(2.0 * FourDistances::error * extent, 0.25 * exact);
            ASSERT_GE(gap, std::min(exact - lost, reach) - 2 * rounding)
                << "mesh " << i << " triangle " << t << ": " << exact << ", " << reach;
            zero += gap == 0;
            limited += exact > reach;
        }
    }
    EXPECT_GT(zero, 10u);
    EXPECT_GT(limited, 0u);
}

TEST(TriangleRingsTest, NoTriangleOfTheRingIsCloserThanTheOpennessSays) {
    test::Random random(42);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t sharp = 0;
    for (int i = 0; i < 12; ++i) {
        const Mesh made("any", test::random_closed_mesh(random));
        const MeshView mesh = made.view();
        for (std::uint32_t t = 0; t < mesh.triangles.size; t += 17) {
            const Triangle& own = mesh.triangles[t];
            const Corners c = corners_of(mesh.positions, own);
            const double openness = static_cast<double>(mesh.rings[t].openness);
            sharp += openness < 0.5;
            for (std::uint32_t other = 0; other < mesh.triangles.size; ++other) {
                if (other == t || !share_vertex(own, mesh.triangles[other])) continue;
                const Corners its = corners_of(mesh.positions, mesh.triangles[other]);
                for (int k = 0; k < 20; ++k) {
                    double u = random.uniform(0, 1), v = random.uniform(0, 1);
                    if (u + v > 1) u = 1 - u, v = 1 - v;
                    const Vec3d q = c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]);
                    double border = std::numeric_limits<double>::infinity();
                    for (std::size_t e = 0; e < 3; ++e)
                        border = std::min(length(q - closest_on_segment(q, c[e], c[(e + 1) % 3])),
                                          border);
                    const double distance = length(q -
                                                   closest_on_triangle(q, its[0], its[1], its[2]));
                    ASSERT_GE(distance, openness * border) << "mesh " << i << " triangle " << t;
                }
            }
        }
    }
    EXPECT_GT(sharp, 20u);
}

TEST(FourDistancesTest, AreNotMoreThanTheyAreAndNotMuchLess) {
    test::Random random(43);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    constexpr double error = FourDistances::error;
    const auto random_triangle = [&](double size, Vec3d at, int kind) {
        Corners c{at + random.in_box(size), at + random.in_box(size), at + random.in_box(size)};
        if (kind == 1) c[2] = c[0] + 0.5 * (c[1] - c[0]) + random.in_box(0.01 * size);  // a sliver
        if (kind == 2)
            for (Vec3d& p : c) p.z = at.z;                                      // all in one plane
        if (kind == 3) c[1] = c[0] + Vec3d{1, random.uniform(-1e-3, 1e-3), 0};  // nearly parallel
        return c;
    };
    std::size_t known = 0, crossing = 0;
    for (int i = 0; i < 20'000; ++i) {
        const int kind = i % 5;
        const Corners own = random_triangle(1, {}, kind);
        Corners others[4];
        Vec3f corner[3];
        FourVec3 lanes[3];
        const auto relative = [&](Vec3d p) { return to_float(p - own[0]); };
        for (std::size_t k = 0; k < 3; ++k) corner[k] = relative(own[k]);
        for (std::uint32_t lane = 0; lane < 4; ++lane) {
            others[lane] = random_triangle(1, random.in_box(i % 7 == 0 ? 0.3 : 3),
                                           (kind + static_cast<int>(lane)) % 5);
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3f p = relative(others[lane][k]);
                lanes[k].x.set(lane, p.x);
                lanes[k].y.set(lane, p.y);
                lanes[k].z.set(lane, p.z);
            }
        }
        const FourDistances found = DistancesOfTriangle(corner).from(lanes);
        for (std::uint32_t lane = 0; lane < 4; ++lane) {
            const double exact = exact_distance(own, others[lane]),
                         extent = extent_of(own, others[lane]);
            crossing += exact == 0;
            if ((found.unknown >> lane & 1) != 0) continue;
            ++known;
            const auto distance = static_cast<double>(found.distance[lane]);
            ASSERT_LE(distance, exact) << "case " << i << " lane " << lane;
            ASSERT_GE(distance, exact - 2 * error * extent) << "case " << i << " lane " << lane;
        }
    }
    EXPECT_GT(known, 40'000u);
    EXPECT_GT(crossing, 1000u);
}

TEST(TriangleRingsTest, TrianglesWithoutAreaHaveNoHeight) {
    MeshData mesh = scenes::torus(1, 0.4, 12, 8);
    mesh.positions[5] = mesh.positions[6];                        // edges without length
    mesh.triangles[40].vertex[1] = mesh.triangles[40].vertex[0];  // a vertex twice
    const Mesh made("mesh", mesh, {.inside = Inside::closed}), moved("moved", mesh, made);
    for (const Mesh* m : {&made, &moved})
        for (const TriangleRing& ring : m->view().rings) EXPECT_FALSE(ring.gap < 0);
    const std::vector<TriangleRing> rings = [&] {
        Workers alone(1, {});
        return rings_of(made.view(), alone);
    }();
    EXPECT_EQ(rings.size(), mesh.triangles.size());
}

}  // namespace
}  // namespace pierce
