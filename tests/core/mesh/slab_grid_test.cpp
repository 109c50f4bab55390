// What slabs say of a segment against the same found from all triangles.
#include "core/mesh/slab_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/closest_point.hpp"
#include "core/geometry/closest_points_of_segments.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/mesh.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

struct Corners {
    Vec3d a, b, c;

    Corners(const MeshView& mesh, const Triangle& t)
        : a(to_double(mesh.positions[t.vertex[0]])),
          b(to_double(mesh.positions[t.vertex[1]])),
          c(to_double(mesh.positions[t.vertex[2]])) {}
};

/// The sign of the crossing of the line through a segment, where it lies within the segment; 0 if
/// they do not cross.
double crossing_sign(Vec3d from, Vec3d to, const Corners& t) {
    const Crossing crossing = cross_triangle(ShearedRay(from, normalized(to - from)), t.a, t.b,
                                             t.c);
    if (crossing.kind != Crossing::transversal) return 0;
    return crossing.t >= 0 && crossing.t <= length(to - from) ? crossing.sign : 0;
}

double distance_between(Vec3d from, Vec3d to, const Corners& t) {
    if (crossing_sign(from, to, t) != 0) return 0;
    double least = std::min(length(from - closest_on_triangle(from, t.a, t.b, t.c)),
                            length(to - closest_on_triangle(to, t.a, t.b, t.c)));
    const Vec3d corner[3] = {t.a, t.b, t.c};
    for (int k = 0; k < 3; ++k) {
        const SegmentPlaces places = closest_points_of_segments(from, to, corner[k],
                                                                corner[(k + 1) % 3]);
        least = std::min(least, length(from + places.first * (to - from) - corner[k] -
                                       places.second * (corner[(k + 1) % 3] - corner[k])));
    }
    return least;
}

/// Of the crossings with a surface: how many lead in, and how many out.
struct Crossings {
    int in = 0, out = 0;

    Crossings(const MeshView& mesh, Vec3d from, Vec3d to) {
        for (const Triangle& t : mesh.triangles) {
            const double sign = crossing_sign(from, to, Corners(mesh, t));
            in += sign < 0;
            out += sign > 0;
        }
    }
};

TEST(SlabGridTest, WhatSlabsSayIsTrueOfAllTriangles) {
    test::Random random(2025);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::vector<MeshData> shapes{scenes::box({-1, -1, -1}, {1, 1, 1}),
                                 scenes::box({-3, -1, -0.02}, {3, 1, 0.02}),
                                 scenes::torus(1, 0.3, 30, 10), scenes::sphere(1, 3)};
    for (int i = 0; i < 12; ++i) shapes.push_back(test::random_closed_mesh(random));
    std::size_t asked = 0, away = 0, once = 0, crossing_once = 0;
    for (const MeshData& data : shapes) {
        const Mesh mesh("mesh", data);
        const MeshView& view = mesh.view();
        ASSERT_GT(view.slab_cells.size, 0u);
        const double extent = view.box.extent();
        for (int i = 0; i < 250 && !HasFailure(); ++i) {
            const double size = extent * std::exp(random.uniform(-6, 1));
            // Near a corner of a triangle, as most are away from the surface otherwise.
            const Triangle&
                near = view.triangles[random.integer(0, static_cast<int>(view.triangles.size) - 1)];
            const Vec3d middle = to_double(view.positions[near.vertex[0]]) +
                                 random.in_box(0.5 * size + 0.03 * extent),
                        way = size * random.unit_vector(), a = middle - 0.5 * way,
                        b = middle + 0.5 * way;
            const SegmentProof proof = view.slabs_by_cell().along(a, b);
            ++asked;
            EXPECT_GE(proof.once, proof.gap);
            if (proof.gap > 0) {
                ++away;
                for (const Triangle& t : view.triangles)
                    EXPECT_GE(distance_between(a, b, Corners(view, t)), proof.gap);
            }
            if (!(proof.once > 0)) continue;
            ++once;
            for (int k = 0; k < 4; ++k) {
                const auto moved = [&](Vec3d p) {
                    return p + (k == 0 ? 0.0 : 0.999 * proof.once) * random.unit_vector();
                };
                const Crossings crossings(view, moved(a), moved(b));
                EXPECT_TRUE(crossings.in == 0 || crossings.out == 0)
                    << crossings.in << " in, " << crossings.out << " out";
                crossing_once += k == 0 && crossings.in + crossings.out == 1;
            }
        }
    }
    EXPECT_GT(away, asked / 5);
    EXPECT_GT(once - away, asked / 20);
    EXPECT_GT(crossing_once, asked / 50);
}

TEST(SlabGridTest, OfAFlatFaceSlabsKnowNearlyAll) {
    const Mesh mesh("box", scenes::box({-1, -1, -1}, {1, 1, 1}));
    const SlabGridView slabs = mesh.view().slabs_by_cell();
    const double cell = slabs.cell;
    for (const double height : {0.01, 0.1, 0.3}) {
        const Vec3d a{-0.3, 0.2, 1 + height * cell}, b{0.1, -0.1, 1 + height * cell};
        EXPECT_NEAR(slabs.along(a, b).gap, height * cell, 2e-3 * cell);
    }
    const SegmentProof through = slabs.along({0.2, 0.1, 0.9}, {0.21, 0.12, 1.1});
    EXPECT_LE(through.gap, 0);
    EXPECT_GT(through.once, 0.1 * cell);
}

}  // namespace
}  // namespace pierce
