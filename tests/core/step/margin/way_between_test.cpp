// What is told of the way between two edges before it is known, against the way itself.
#include "core/step/margin/way_between.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/geometry/closest_points_of_segments.hpp"
#include "support/random.hpp"

namespace pierce::stages {
namespace {

/// Two edges that are closest to each other somewhere between their ends, often nearly parallel,
/// short, close to each other or far from the origin.
struct Edges {
    Vec3d a0, a1, b0, b1;
    double largest = 0;  ///< coordinate

    explicit Edges(test::Random& random) {
        const auto small = [&](double least) { return std::exp2(random.uniform(least, 0)); };
        const double scale = std::exp2(random.integer(-20, 20));
        const Vec3d middle = random.in_box(random.integer(0, 1) == 0 ? 1 : 1000);
        const Vec3d own = small(-10) * random.unit_vector(),
                    others = small(-10) * normalized(own + small(-40) * random.in_box(1)),
                    way = (random.integer(0, 1) == 0 ? 1 : -1) * small(-30) *
                          normalized(cross(own, others));
        const double at = random.uniform(0, 1), other_at = random.uniform(0, 1);
        const auto rounded = [&](Vec3d p) { return to_double(to_float(scale * p)); };
        a0 = rounded(middle - at * own);
        a1 = rounded(middle + (1 - at) * own);
        b0 = rounded(middle + way - other_at * others);
        b1 = rounded(middle + way + (1 - other_at) * others);
        for (const Vec3d p : {a0, a1, b0, b1})
            for (int k = 0; k < 3; ++k) largest = std::max(std::fabs(p[k]), largest);
    }
};

TEST(WayBetweenTest, NothingIsSaidOfAWayThatIsNotTrueOfIt) {
    test::Random random(4711);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int known = 0, longer = 0, over = 0, not_told = 0;
    for (int i = 0; i < 200000; ++i) {
        const Edges edges(random);
        const auto& [a0, a1, b0, b1, largest] = edges;
        const SegmentPlaces at = closest_points_of_segments(a0, a1, b0, b1);
        const Vec3d way = b0 + at.second * (b1 - b0) - (a0 + at.first * (a1 - a0));
        const double distance = length(way), touch = std::exp2(random.uniform(-30, 0)) *
                                                     constants::touch_tolerance * largest;
        const WayBetween told(a0, a1, b0, b1, largest);
        if (!(at.first > 0 && at.first < 1 && at.second > 0 && at.second < 1) ||
            !(distance > touch) || !told.is_known())
            continue;
        ++known;
        const double little = std::exp2(random.uniform(-50, -1)), apart = 4 * little;
        if (told.is_longer_than((1 - little) * distance)) ++longer;
        EXPECT_FALSE(told.is_longer_than((1 + little) * distance));

        // A place beside the edge, at a height near that from which on it is in the way.
        const Vec3d direction = (1 / distance) * way,
                    beside = std::exp2(random.uniform(-12, 4)) * distance *
                             cross(direction, random.unit_vector()),
                    place = beside +
                            (1 + (random.integer(0, 1) == 0 ? apart : -apart)) * touch * direction;
        for (const double sign : {1.0, -1.0}) {
            const bool is_over = sign * dot(direction, sign * place) > touch;
            if (told.leads_over(sign * place, sign, touch)) {
                EXPECT_TRUE(is_over) << i;
                ++over;
            } else {
                not_told += is_over;
            }
            EXPECT_FALSE(told.leads_over(-sign * place, sign, touch));
        }
        EXPECT_TRUE(
            told.leads_over(beside + (10 * touch + 1e-5 * length(beside)) * direction, 1, touch));
    }
    EXPECT_GT(known, 20000);
    EXPECT_GT(longer, known / 4);
    EXPECT_GT(over, 200);
    EXPECT_GT(not_told, 1000);
}

}  // namespace
}  // namespace pierce::stages
