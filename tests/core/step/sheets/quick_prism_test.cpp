// What float32 says about the features of sheets, against double: it may only say less.
#include "core/step/sheets/quick_prism.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/geometry/closest_points_of_segments.hpp"
#include "core/step/sheets/four_drifting_pairs.hpp"
#include "core/step/sheets/four_heights.hpp"
#include "core/step/sheets/sheet_features.hpp"
#include "support/random.hpp"

namespace pierce::stages {
namespace {

using test::Random;

/// Points of a scale of their own, at times nearly in a line or a plane.
class Points {
public:
    explicit Points(Random& random)
        : random_(random),
          scale_(std::exp2(random.integer(-20, 20))),
          flat_(random.integer(0, 2) == 0 ? std::exp2(-random.integer(1, 24)) : 1),
          thin_(random.integer(0, 3) == 0 ? std::exp2(-random.integer(1, 24)) : 1) {}

    Vec3f next() {
        const Vec3d p = random_.in_box(1);
        return to_float(scale_ * Vec3d{p.x, thin_ * p.y, flat_ * p.z});
    }
    float scale() const { return static_cast<float>(scale_); }

private:
    Random& random_;
    double scale_, flat_, thin_;
};

/// From 0 to 1, and half of the time hardly within that.
double place(Random& random) {
    if (random.integer(0, 1) == 0) return random.uniform(0, 1);
    const double little = std::exp2(-random.uniform(10, 29));
    return random.integer(0, 1) == 0 ? little : 1 - little;
}

/// A length, or hardly less.
double hardly_below(Random& random, double length) {
    return random.integer(0, 1) == 0 ? random.uniform(0, length)
                                     : length * (1 - std::exp2(-random.uniform(10, 29)));
}

float largest(std::initializer_list<Vec3f> points) {
    float size = 0;
    for (Vec3f p : points)
        for (int axis = 0; axis < 3; ++axis) size = std::max(size, std::fabs(p[axis]));
    return size;
}

TEST(SheetFeaturesTest, EdgesThatCrossOverEachOtherAreNeverLeftOut) {
    Random random(1);
    int crossing = 0, left_out = 0;
    for (int i = 0; i < 200000; ++i) {
        Points points(random);
        const Vec3f p = points.next(), q = points.next();
        Vec3f r = points.next(), s = points.next();
        const float margin = points.scale() * static_cast<float>(random.uniform(0, 1));
        if (random.integer(0, 1) == 0) {
            const Vec3d along = to_double(q) - to_double(p), other = to_double(s) - to_double(r);
            const Vec3d at = to_double(p) + place(random) * along +
                             hardly_below(random, static_cast<double>(margin)) *
                                 normalized(cross(along, other));
            const double share = place(random);
            r = to_float(at - share * other);
            s = to_float(at + (1 - share) * other);
        }
        // Parallel but for rounding, which decides where their common normal leads.
        if (random.integer(0, 3) == 0) s = r + static_cast<float>(random.uniform(-2, 2)) * (q - p);
        const bool may = may_cross_over(p, q, r, s, margin, largest({p, q, r, s}));
        const Vec3d a = to_double(p), b = to_double(q), c = to_double(r), d = to_double(s);
        const SegmentPlaces at = closest_points_of_segments(a, b, c, d);
        constexpr double inside = 1e-9;
        const bool within = at.first > inside && at.first < 1 - inside && at.second > inside &&
                            at.second < 1 - inside;
        const bool near = within && length(a + at.first * (b - a) - c - at.second * (d - c)) <
                                        static_cast<double>(margin);
        ASSERT_TRUE(may || !near) << "seed " << random.seed() << ", case " << i;
        crossing += near;
        left_out += !may;
    }
    EXPECT_GT(crossing, 10000);
    EXPECT_GT(left_out, 60000);
}

TEST(SheetFeaturesTest, WhatIsPastIsFurtherAway) {
    Random random(5);
    int past = 0, far = 0;
    for (int i = 0; i < 200000; ++i) {
        Points points(random);
        const Vec3f origin = static_cast<float>(std::exp2(random.integer(0, 10))) * points.next();
        const Vec3f n = points.next() * static_cast<float>(std::exp2(-random.integer(0, 20)));
        const double length_of_n = length(to_double(n));
        const float margin = points.scale() * static_cast<float>(random.uniform(0, 1));
        // Half of the time ahead by hardly more or less than the margin.
        const Vec3d away = random.integer(0, 1) == 0
                               ? random.uniform(0, 2) * points.scale() * normalized(to_double(n))
                               : (1 + random.uniform(-1, 1) * std::exp2(-random.uniform(10, 29))) *
                                     static_cast<double>(margin) * normalized(to_double(n));
        const Vec3f at = to_float(to_double(origin) + away);
        const bool alone = random.integer(0, 1) == 0;
        const Vec3f a[2] = {at, alone ? at : at + points.next()};
        const Vec3f b[3] = {origin, alone ? origin : origin + points.next(), origin};
        const bool is = is_past(n, a, b, margin, largest({a[0], a[1], b[0], b[1]}));
        bool ahead = true;
        for (Vec3f x : a)
            for (Vec3f y : b)
                ahead &= dot(to_double(n), to_double(x) - to_double(y)) >
                         static_cast<double>(margin) * length_of_n;
        ASSERT_TRUE(!is || ahead) << "seed " << random.seed() << ", case " << i;
        past += is;
        far += ahead;
    }
    EXPECT_GT(past, 20000);
    EXPECT_GT(far, past);
}

TEST(SheetFeaturesTest, ShortEdgesBesideALongOneAreLeftOut) {
    Random random(6);
    int crossing = 0, left_out = 0, apart = 0;
    for (int i = 0; i < 100000; ++i) {
        // A long edge in a plane, and a short one in it or hardly above it, at times parallel.
        const Vec3d x = normalized(random.unit_vector()),
                    y = normalized(cross(x, random.unit_vector())), z = cross(x, y);
        const double size = std::exp2(random.uniform(0, 8)), margin = random.uniform(0.01, 0.5);
        const double turn = random.integer(0, 1) == 0 ? random.uniform(-1e-6, 1e-6)
                                                      : random.uniform(-3.2, 3.2);
        const Vec3d middle = random.uniform(-size, size) * x + random.uniform(-2, 2) * y +
                             random.uniform(0, 1) * margin * z;
        const Vec3d half = 0.5 * std::cos(turn) * x + 0.5 * std::sin(turn) * y;
        Vec3f p = to_float(-size * x), q = to_float(size * x), r = to_float(middle - half),
              s = to_float(middle + half);
        if (random.integer(0, 1) == 0) std::swap(p, r), std::swap(q, s);
        const bool may = may_cross_over(p, q, r, s, static_cast<float>(margin),
                                        largest({p, q, r, s}));
        const Vec3d a = to_double(p), b = to_double(q), c = to_double(r), d = to_double(s);
        const SegmentPlaces at = closest_points_of_segments(a, b, c, d);
        const double gap = length(a + at.first * (b - a) - c - at.second * (d - c));
        constexpr double inside = 1e-9;
        const bool near = at.first > inside && at.first < 1 - inside && at.second > inside &&
                          at.second < 1 - inside &&
                          gap < static_cast<double>(static_cast<float>(margin));
        ASSERT_TRUE(may || !near) << "seed " << random.seed() << ", case " << i;
        crossing += near;
        left_out += !may;
        apart += gap > 1.5 * margin;
    }
    EXPECT_GT(crossing, 5000);
    EXPECT_GT(left_out, apart * 9 / 10) << "of " << apart;
}

TEST(SheetFeaturesTest, VerticesFarBesideASmallTriangleAreLeftOut) {
    Random random(7);
    for (int i = 0; i < 10000; ++i) {
        const Vec3d x = random.unit_vector(), y = normalized(cross(x, random.unit_vector()));
        const double around = random.uniform(0, 6.3), far = std::exp2(random.uniform(3, 8));
        const Vec3f a = to_float(0.0 * x), b = to_float(x), c = to_float(y),
                    p = to_float(far * (std::cos(around) * x + std::sin(around) * y));
        ASSERT_FALSE(QuickPrism(a, b, c, 0.1f, largest({a, b, c, p})).may_hold(p))
            << "seed " << random.seed() << ", case " << i;
    }
}

TEST(SheetFeaturesTest, VerticesOverATriangleAreNeverLeftOut) {
    Random random(2);
    int over = 0, left_out = 0;
    for (int i = 0; i < 200000; ++i) {
        Points points(random);
        const Vec3f a = points.next(), b = points.next();
        // In a line but for rounding, which decides where the normal leads.
        const Vec3f c = random.integer(0, 3) == 0
                            ? a + static_cast<float>(random.uniform(-2, 2)) * (b - a)
                            : points.next();
        Vec3f p = points.next();
        const float margin = points.scale() * static_cast<float>(random.uniform(0, 1));
        const Vec3d at[3] = {to_double(a), to_double(b), to_double(c)};
        const Vec3d n = cross(at[1] - at[0], at[2] - at[0]);
        if (random.integer(0, 1) == 0) {
            const double v = place(random), w = place(random) * (1 - v);
            p = to_float(at[0] + v * (at[1] - at[0]) + w * (at[2] - at[0]) +
                         hardly_below(random, static_cast<double>(margin)) * normalized(n));
        }
        const bool may = QuickPrism(a, b, c, margin, largest({a, b, c, p})).may_hold(p);
        const Vec3d x = to_double(p);
        bool within = length_squared(n) > 0 &&
                      std::fabs(dot(normalized(n), x - at[0])) < static_cast<double>(margin);
        for (int k = 0; k < 3; ++k)
            within &= dot(n, cross(at[(k + 1) % 3] - at[k], x - at[k])) >= 0;
        ASSERT_TRUE(may || !within) << "seed " << random.seed() << ", case " << i;
        over += within;
        left_out += !may;
    }
    EXPECT_GT(over, 10000);
    EXPECT_GT(left_out, 60000);
}

/// Whether triangles are apart along a direction during the step, and further apart than a margin
/// at its end.
struct Apart {
    bool ahead = true, behind = true, far_ahead = true, far_behind = true;

    Apart(Random& random, Vec3d direction, const QuickPoint (&a)[3], const QuickPoint (&b)[3],
          double margin) {
        const double far = margin * length(direction);
        for (double time : {0.0, random.uniform(0, 1), 1.0})
            for (const QuickPoint& x : a)
                for (const QuickPoint& y : b) {
                    const auto when = [&](const QuickPoint& z) {
                        return (1 - time) * to_double(z.start) + time * to_double(z.end);
                    };
                    const double d = dot(direction, when(x) - when(y));
                    ahead &= d > 0;
                    behind &= d < 0;
                    far_ahead &= time < 1 || d > far;
                    far_behind &= time < 1 || d < -far;
                }
    }
    bool agrees(const Company& company) const {
        return (!company.separate || ahead || behind) &&
               (!company.distant || far_ahead || far_behind);
    }
};

TEST(SheetFeaturesTest, ADirectionThatSeparatesDoesSoAllTheTime) {
    Random random(3);
    int separate = 0, distant = 0;
    for (int i = 0; i < 100000; ++i) {
        Points points(random);
        QuickPoint a[3], b[3];
        float size = 0;
        const Vec3f n = to_float(random.unit_vector()),
                    away = static_cast<float>(random.uniform(0, 2)) * points.scale() * n;
        for (int k = 0; k < 3; ++k) {
            a[k] = {points.next(), points.next()};
            b[k] = {points.next() + away, points.next() + away};
            size = std::max(size, largest({a[k].start, a[k].end, b[k].start, b[k].end}));
        }
        const float margin = points.scale() * 0.1f;
        const Company company = company_along(n, a, b, margin, size);
        separate += company.separate;
        distant += company.distant;
        const Apart apart(random, to_double(n), a, b, static_cast<double>(margin));
        ASSERT_TRUE(apart.agrees(company)) << "seed " << random.seed() << ", case " << i;
    }
    EXPECT_GT(separate, 1000);
    EXPECT_GT(distant, 1000);
}

/// Two triangles that move, as culling sees them and as they are.
struct MovingPair {
    DriftingTriangle first, second;
    QuickPoint a[3], b[3];
    float margin = 0;

    explicit MovingPair(Random& random) {
        Points points(random);
        PlacedTriangle at_a, at_b;
        const Vec3f far = static_cast<float>(std::exp2(random.integer(0, 10))) * points.next();
        for (int k = 0; k < 3; ++k) {
            at_a.end[k] = far + points.next();
            at_b.end[k] = far + points.next();
        }
        Vec3d way = at_a.end_normal();
        if (random.integer(0, 1) == 0) {
            way = {};
            for (int k = 0; k < 3; ++k) way += to_double(at_b.end[k]) - to_double(at_a.end[k]);
        }
        const Vec3f away = static_cast<float>(random.uniform(0, 2)) * points.scale() *
                           to_float(normalized(way));
        for (int k = 0; k < 3; ++k) {
            at_a.start[k] = at_a.end[k] + 0.1f * points.next();
            at_b.start[k] = at_b.end[k] = at_b.end[k] + away;
            a[k] = {at_a.start[k], at_a.end[k]};
            b[k] = {at_b.start[k], at_b.end[k]};
        }
        first = DriftingTriangle(at_a);
        second = DriftingTriangle(at_b);
        margin = points.scale() * 0.1f;
    }
};

TEST(SheetFeaturesTest, ANormalThatSeparatesDoesSoAllTheTime) {
    Random random(4);
    int separate = 0, distant = 0;
    for (int i = 0; i < 100000; ++i) {
        const MovingPair pair(random);
        const Company company = DriftingPair(pair.first, pair.second)
                                    .along_normal_of_a(pair.margin);
        separate += company.separate;
        distant += company.distant;
        const Apart apart(random, to_double(pair.first.end_normal()), pair.a, pair.b,
                          static_cast<double>(pair.margin));
        ASSERT_TRUE(apart.agrees(company)) << "seed " << random.seed() << ", case " << i;
    }
    EXPECT_GT(separate, 1000);
    EXPECT_GT(distant, 1000);
}

TEST(SheetFeaturesTest, MiddlesThatSeparateDoSoAllTheTime) {
    Random random(8);
    int separate = 0, distant = 0;
    for (int i = 0; i < 100000; ++i) {
        const MovingPair pair(random);
        const DriftingPair both(pair.first, pair.second);
        const Company company = both.along_middles(pair.margin);
        separate += company.separate;
        distant += company.distant;
        const Apart apart(random, to_double(both.between_middles()), pair.a, pair.b,
                          static_cast<double>(pair.margin));
        ASSERT_TRUE(apart.agrees(company)) << "seed " << random.seed() << ", case " << i;
    }
    EXPECT_GT(separate, 1000);
    EXPECT_GT(distant, 1000);
}

#if defined(PIERCE_FOUR_LANES)
TEST(SheetFeaturesTest, FourPairsAtOnceAreToldWhatEachIsTold) {
    Random random(10);
    std::uint32_t separate = 0, distant = 0;
    for (int i = 0; i < 100000; ++i) {
        const MovingPair pairs[4] = {MovingPair(random), MovingPair(random), MovingPair(random),
                                     MovingPair(random)};
        FourTriangles firsts, others;
        for (int k = 0; k < 4; ++k) {
            firsts.triangle[k] = random.integer(0, 3) == 0 ? &pairs[k].first : &pairs[0].first;
            others.triangle[k] = random.integer(0, 3) == 0 ? &pairs[k].second : &pairs[0].second;
        }
        const float margin = pairs[0].margin;
        const FourDriftingPairs four(firsts, others);
        const FourCompanies companies[3] = {four.along_normal_of_a(margin),
                                            four.along_normal_of_b(margin),
                                            four.along_middles(margin)};
        for (int k = 0; k < 4; ++k) {
            const DriftingPair both(*firsts.triangle[k], *others.triangle[k]);
            const Company expected[3] = {both.along_normal_of_a(margin),
                                         both.along_normal_of_b(margin),
                                         both.along_middles(margin)};
            for (int way = 0; way < 3; ++way) {
                ASSERT_EQ(companies[way].separate >> k & 1, expected[way].separate)
                    << "seed " << random.seed() << ", case " << i << ", direction " << way;
                ASSERT_EQ(companies[way].distant >> k & 1, expected[way].distant)
                    << "seed " << random.seed() << ", case " << i << ", direction " << way;
                separate += expected[way].separate;
                distant += expected[way].distant;
            }
        }
    }
    EXPECT_GT(separate, 10000u);
    EXPECT_GT(distant, 10000u);
}

TEST(SheetFeaturesTest, FourFeaturesAtOnceAreToldWhatEachIsTold) {
    Random random(11);
    std::uint32_t nothing = 0, something = 0;
    for (int i = 0; i < 3000; ++i) {
        // More than FourFeatures takes at once, of a few pairs of bodies.
        std::vector<DriftingTriangle> triangles;
        std::vector<SheetPair> pairs(3);
        std::vector<TrianglePair> close;
        for (std::uint32_t k = 0; k < 41; ++k) {
            const MovingPair pair(random);
            const bool flat = random.integer(0, 3) == 0;
            triangles.push_back(pair.first);
            triangles.push_back(flat ? pair.first : pair.second);
            for (DriftingTriangle* t : {&triangles[2 * k], &triangles[2 * k + 1]})
                t->own = static_cast<std::uint32_t>(random.integer(0, 63));
            if (flat)
                for (auto& corner : triangles.back().corner)
                    corner.end = corner.end + 0.5f * pair.margin * Vec3f{0, 0, 1};
            pairs[k % 3].quick_margin = pairs[k % 3].quick_thickness = pair.margin;
            close.push_back({k % 3, 2 * k, 2 * k + 1, random.integer(0, 9) > 0});
        }
        triangles.resize(96);  // whole groups
        const FindFeatures find{view_of(std::as_const(pairs)),
                                interleaved(view_of(std::as_const(triangles))),
                                view_of(std::as_const(close))};
        std::vector<std::uint32_t> found(close.size());
        find.find_all(0, static_cast<std::uint32_t>(close.size()), found.data());
        for (std::uint32_t k = 0; k < close.size(); ++k) {
            ASSERT_EQ(found[k], find.find(k)) << "seed " << random.seed() << ", case " << i;
            ++(found[k] == 0 ? nothing : something);
        }
    }
    EXPECT_GT(nothing, 10000u);
    EXPECT_GT(something, 30000u);
}

TEST(SheetFeaturesTest, TrianglesApartAlongTheNormalOfAGroupAreApartAllTheTime) {
    Random random(12);
    int left_out = 0;
    for (int i = 0; i < 5000; ++i) {
        Points points(random);
        const Vec3f far = static_cast<float>(std::exp2(random.integer(0, 10))) * points.next(),
                    motion = static_cast<float>(random.uniform(0, 1)) * points.next();
        const auto place = [&](const Vec3f& away) {
            PlacedTriangle t;
            t.triangle = 0;
            for (int k = 0; k < 3; ++k) {
                t.end[k] = far + away + points.next();
                t.start[k] = t.end[k] + motion + 0.1f * points.next();
            }
            return t;
        };
        const float margin = points.scale() * static_cast<float>(random.uniform(0, 0.5));
        const SlabFrame frame(to_double(to_float(random.unit_vector())));
        PlacedTriangle others[constants::group_size], mine[Four::count];
        QuickBox of_others, of_mine;
        for (PlacedTriangle& t : others) of_others.extend((t = place({})).box());
        const Vec3f away = static_cast<float>(random.uniform(0, 3)) * points.scale() *
                           to_float(frame.axis[0]);
        for (PlacedTriangle& t : mine) of_mine.extend((t = place(away)).box());
        Box reach[constants::group_size], all;
        for (std::uint32_t k = 0; k < constants::group_size; ++k) {
            for (int c = 0; c < 3; ++c)
                for (const Vec3f& at : {others[k].start[c], others[k].end[c]})
                    reach[k].extend(frame.along(to_double(at) - to_double(of_others.lower)));
            all.extend(reach[k]);
        }
        GroupHeights heights;
        heights.set(reach);
        const Slab slab = frame.slab(all, to_double(of_others.lower));
        DriftingTriangle drifting[Four::count];
        FourTriangles four;
        for (std::uint32_t k = 0; k < Four::count; ++k) {
            drifting[k] = DriftingTriangle(mine[k]);
            four.triangle[k] = &drifting[k];
        }
        std::uint32_t near[Four::count];
        FourHeights(of_mine, of_others, slab, margin).near(four, heights, near);
        for (std::uint32_t k = 0; k < Four::count; ++k)
            for (std::uint32_t j = 0; j < constants::group_size; ++j) {
                if (near[k] >> j & 1) continue;
                ++left_out;
                const Vec3d n = to_double(slab.axis[0]);
                double ahead = 1e300, behind = 1e300;
                for (int c = 0; c < 3; ++c)
                    for (int d = 0; d < 3; ++d)
                        for (const auto& when : {&PlacedTriangle::start, &PlacedTriangle::end}) {
                            const double gap = dot(
                                n, to_double((mine[k].*when)[c]) - to_double((others[j].*when)[d]));
                            ahead = std::min(ahead, gap);
                            behind = std::min(behind, -gap);
                        }
                ASSERT_GT(std::max(ahead, behind), static_cast<double>(margin) * length(n))
                    << "seed " << random.seed() << ", case " << i;
            }
    }
    EXPECT_GT(left_out, 50000);
}
#endif

TEST(SheetFeaturesTest, TrianglesBesideEachOtherInAPlaneAreApart) {
    Random random(9);
    for (int i = 0; i < 10000; ++i) {
        const Vec3d x = random.unit_vector(), y = normalized(cross(x, random.unit_vector()));
        PlacedTriangle a, b;
        const double corner[3][2] = {{0, 0}, {1, 0}, {0, 1}}, around = random.uniform(0, 6.3);
        for (int k = 0; k < 3; ++k) {
            const Vec3d at = corner[k][0] * x + corner[k][1] * y;
            a.start[k] = a.end[k] = to_float(at);
            b.start[k] = b.end[k] = to_float(at +
                                             2 * (std::cos(around) * x + std::sin(around) * y));
        }
        ASSERT_TRUE(
            DriftingPair(DriftingTriangle(a), DriftingTriangle(b)).along_middles(0.1f).is_settled())
            << "seed " << random.seed() << ", case " << i;
    }
}

}  // namespace
}  // namespace pierce::stages
