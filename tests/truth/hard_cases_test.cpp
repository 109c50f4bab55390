// How far the bodies of the hard cases overlap, by exact predicates.
#include <gtest/gtest.h>

#include "scenes/named/hard_cases.hpp"
#include "truth/cubes.hpp"
#include "truth/exact_mesh.hpp"
#include "truth/minimum_translation.hpp"

namespace pierce::truth {
namespace {

TEST(HardCasesTruthTest, BodiesPartAsSoonAsTheySay) {
    int asked = 0;
    for (const scenes::HardCase& hard : scenes::hard_cases())
        for (const scenes::HardBodies& bodies : hard.bodies) {
            SCOPED_TRACE(hard.name + " " + bodies.situation);
            const std::vector<Vec3d> a = in_double(bodies.a.positions),
                                     b = in_double(bodies.b.positions);
            const ExactMesh first(a, bodies.a.triangles), second(b, bodies.b.triangles);
            const bool overlap = bodies.parting >= 0;
            if (first.closed() && second.closed()) {
                EXPECT_EQ(first.overlaps(second), overlap);
            }
            // None of the hulls is stuck where the bodies are not.
            const double parting = minimum_translation({a, bodies.a.triangles},
                                                       {b, bodies.b.triangles})
                                       .length;
            if (overlap) {
                EXPECT_NEAR(parting, bodies.parting, 1e-7);
            } else {
                EXPECT_LE(parting, 0);
            }
            ++asked;
        }
    EXPECT_EQ(asked, 19);
}

}  // namespace
}  // namespace pierce::truth
