// What doubles decide about moving features, against rational numbers.
#include "truth/meeting.hpp"

#include <gtest/gtest.h>

#include "support/random.hpp"
#include "truth/bounded_polynomial.hpp"
#include "truth/exact_continuous.hpp"

namespace pierce::truth {
namespace {

using Corners = std::array<MovingPoint, 4>;

constexpr std::array both_kinds = {Features::vertex_and_face, Features::edges};

bool by_rational_numbers(Features features, const Corners& corners) {
    const ExactCorners c = exact(corners);
    return (features == Features::edges ? first_meeting_of_edges(c)
                                        : first_meeting_of_vertex_and_face(c))
        .has_value();
}

struct Tally {
    int meetings = 0, wrong = 0;
    MeetingCounts decided;
};

template <class MakePoint>
Tally compare(int queries, const MakePoint& point) {
    Tally tally;
    for (int i = 0; i < queries; ++i) {
        Corners corners;
        for (MovingPoint& p : corners) p = {point(), point()};
        for (const Features features : both_kinds) {
            const bool truth = by_rational_numbers(features, corners);
            tally.meetings += truth;
            tally.wrong += features_meet(features, corners, &tally.decided) != truth;
        }
    }
    return tally;
}

TEST(MeetingTest, WildMotions) {
    test::Random random(1);
    const Tally tally = compare(300, [&] { return to_double(to_float(random.in_box(1))); });
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_GT(tally.meetings, 20);
    EXPECT_EQ(tally.decided.exact, 0u) << "nothing here is degenerate";
}

TEST(MeetingTest, FewPlaces) {
    // Small whole coordinates: most of these touch, lie in one plane, stand still or have lost an
    // extent.
    test::Random random(2);
    const auto whole = [&] { return static_cast<double>(random.integer(-1, 1)); };
    const Tally tally = compare(600, [&] { return Vec3d{whole(), whole(), whole()}; });
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_GT(tally.meetings, 100);
    EXPECT_GT(tally.decided.ends, 100u);
    EXPECT_GT(tally.decided.exact, 100u);
}

TEST(MeetingTest, AllInOnePlane) {
    test::Random random(3);
    const Tally tally = compare(60, [&] {
        return Vec3d{random.uniform(-1, 1), random.uniform(-1, 1), 0.25};
    });
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_GT(tally.meetings, 10);
}

TEST(MeetingTest, AHairDecides) {
    const MovingPoint a{{0, 0, 0}, {0, 0, 0}}, b{{1, 0, 0}, {1, 0, 0}}, c{{0, 1, 0}, {0, 1, 0}};
    for (const double height : {0.0, 0x1p-1070, 0x1p-60}) {
        EXPECT_EQ(features_meet(Features::vertex_and_face,
                                {MovingPoint{{0.25, 0.25, 1}, {0.25, 0.25, height}}, a, b, c}),
                  height == 0);
        EXPECT_EQ(
            features_meet(Features::edges, {MovingPoint{{0.25, -1, 1}, {0.25, -1, height}},
                                            MovingPoint{{0.25, 1, 1}, {0.25, 1, height}}, a, b}),
            height == 0);
    }
    const double beside = std::nextafter(0.5, 1);
    EXPECT_TRUE(features_meet(Features::vertex_and_face,
                              {MovingPoint{{0.5, 0.5, 1}, {0.5, 0.5, -1}}, a, b, c}));
    EXPECT_FALSE(features_meet(Features::vertex_and_face,
                               {MovingPoint{{0.5, beside, 1}, {0.5, beside, -1}}, a, b, c}));
}

TEST(MeetingTest, BoundsHoldTheTruth) {
    test::Random random(4);
    for (int i = 0; i < 2000; ++i) {
        const double x = random.uniform(-1, 1), y = random.uniform(-1, 1) * 0x1p-30;
        const auto holds = [](Interval bounds, const mpq_class& value) {
            return mpq_class(bounds.low()) <= value && value <= mpq_class(bounds.high());
        };
        EXPECT_TRUE(holds(Interval(x) + y, mpq_class(x) + mpq_class(y)));
        EXPECT_TRUE(holds(Interval(x) - y, mpq_class(x) - mpq_class(y)));
        EXPECT_TRUE(holds(Interval(x) * y, mpq_class(x) * mpq_class(y)));
        // Whatever both may be, of any signs.
        const Interval wide_x(std::min(x, 0.5), std::max(x, 0.5)),
            wide_y(std::min(y, -0.25), std::max(y, -0.25));
        for (const double p : {wide_x.low(), wide_x.high()})
            for (const double q : {wide_y.low(), wide_y.high()})
                EXPECT_TRUE(holds(wide_x * wide_y, mpq_class(p) * mpq_class(q)));
    }
}

TEST(MeetingTest, BoundedPolynomialsAreProductsAndHalves) {
    test::Random random(5);
    const auto line = [&] {
        return BoundedPolynomial<1>{{random.uniform(-1, 1), random.uniform(-1, 1)}};
    };
    for (int i = 0; i < 200; ++i) {
        const BoundedPolynomial<1> a = line(), b = line(), c = line(), d = line();
        const BoundedPolynomial<4> product = (a * b) * (c * d);
        const auto [low, high] = product.halves();
        const auto at = [](const BoundedPolynomial<1>& p, const mpq_class& t) -> mpq_class {
            return (1 - t) * mpq_class(p.at[0].low()) + t * mpq_class(p.at[1].low());
        };
        const auto value = [&](const mpq_class& t) -> mpq_class {
            return at(a, t) * at(b, t) * at(c, t) * at(d, t);
        };
        const mpq_class half(1, 2);
        for (const auto& [bounds, time] : {std::pair{product.first(), mpq_class(0)},
                                           {product.last(), mpq_class(1)},
                                           {low.last(), half},
                                           {high.first(), half},
                                           {high.last(), mpq_class(1)}}) {
            EXPECT_LE(mpq_class(bounds.low()), value(time));
            EXPECT_GE(mpq_class(bounds.high()), value(time));
            EXPECT_LT(bounds.high() - bounds.low(), 1e-13);
        }
    }
}

}  // namespace
}  // namespace pierce::truth
