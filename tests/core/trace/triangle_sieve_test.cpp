// What float32 leaves out before the exact triangle test: nothing that it meets.
#include "core/trace/triangle_sieve.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.hpp"

namespace pierce {
namespace {

/// Rays at points in, near and on the edges of leaves' triangles, small and far from the origin
/// among them.
TEST(TriangleSieveTest, LeavesOutNothingThatIsMet) {
    test::Random random(5);
    int met = 0, left_out = 0, left_out_alone = 0;
    for (int i = 0; i < 200000; ++i) {
        const double scale = std::exp2(random.integer(-12, 12));
        const Vec3d place = random.in_box(scale * std::exp2(random.integer(-4, 10)));
        Vec3f corner[4];
        for (Vec3f& p : corner) p = to_float(place + random.in_box(scale));
        const Vec3f v[2][3] = {{corner[0], corner[1], corner[2]},
                               {corner[3], corner[2], corner[1]}};
        const std::size_t aim = random.integer(0, 1) == 0 ? 0 : 1;
        double weight[3] = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        if (i % 2 == 0)
            weight[random.integer(0, 2)] = (i % 4 == 0 ? 1e-9 : 0) * random.uniform(-1, 1);
        const double sum = weight[0] + weight[1] + weight[2];
        Vec3d at;
        for (int k = 0; k < 3; ++k) at += (weight[k] / sum) * to_double(v[aim][k]);
        Ray ray;
        ray.direction = random.unit_vector();
        ray.origin = at - random.uniform(-3, 3) * scale * ray.direction;
        if (i % 5 == 0) ray.origin = ray.origin + random.in_box(2 * scale);
        const TriangleSieve sieve(ray);
        const std::uint32_t may = sieve.may_cross(corner[0], corner[1], corner[2], corner[3]);
        for (std::size_t t = 0; t < 2; ++t) {
            const Crossing crossing = cross_triangle({ray.origin, ray.direction},
                                                     to_double(v[t][0]), to_double(v[t][1]),
                                                     to_double(v[t][2]));
            const bool may_alone = sieve.may_cross(v[t][0], v[t][1], v[t][2]);
            ASSERT_TRUE(((may >> t & 1) != 0 && may_alone) || crossing.kind == Crossing::none)
                << "seed " << random.seed() << ", case " << i << ", triangle " << t;
            left_out_alone += !may_alone;
            met += crossing.kind != Crossing::none;
            left_out += (may >> t & 1) == 0;
        }
    }
    EXPECT_GT(met, 80000);
    EXPECT_GT(left_out, 100000);
    EXPECT_GT(left_out_alone, 100000);
}

}  // namespace
}  // namespace pierce
