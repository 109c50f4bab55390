// Bounds of float32 sums: not on the wrong side of what double says, and next to it.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/geometry/float_rules.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

TEST(FloatRulesTest, SumsAreBoundedCloselyAtAnyScale) {
    test::Random random(1);
    int rounded = 0;
    for (int i = 0; i < 100000; ++i) {
        const double scale = std::exp2(random.integer(-140, 100));
        const auto a = static_cast<float>(scale * random.uniform(-1, 1));
        const auto b = static_cast<float>(scale * std::exp2(random.integer(-30, 0)) *
                                          random.uniform(-1, 1));
        const double exact = static_cast<double>(a) + static_cast<double>(b);
        const double below = static_cast<double>(not_above(a + b)),
                     above = static_cast<double>(not_below(a + b));
        ASSERT_TRUE(below <= exact && exact <= above) << "seed " << random.seed() << ", case " << i;
        ASSERT_LE(above - below, 0x1p-21 * std::fabs(exact))
            << "seed " << random.seed() << ", case " << i;
        rounded += static_cast<double>(a + b) != exact;
    }
    EXPECT_GT(rounded, 10000);
    EXPECT_EQ(not_above(0.0f), 0.0f);
    constexpr float infinite = std::numeric_limits<float>::infinity();
    EXPECT_FALSE(not_above(infinite) <= infinite) << "nothing is said of boxes that are not there";
    EXPECT_FALSE(-infinite <= not_below(-infinite));
}

}  // namespace
}  // namespace pierce
