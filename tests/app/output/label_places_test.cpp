// Names beside points: none on another one, whatever the points are.
#include "app/output/label_places.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "support/random.hpp"

namespace pierce::app {
namespace {

constexpr double line_height = 16;

/// How much of two areas is the same.
double shared(const Area& a, const Area& b) {
    const double x = std::min(a.high.x, b.high.x) - std::max(a.low.x, b.low.x),
                 y = std::min(a.high.y, b.high.y) - std::max(a.low.y, b.low.y);
    return x > 0 && y > 0 ? x * y : 0;
}

double distance(const Area& area, Spot p) {
    return std::hypot(p.x - std::clamp(p.x, area.low.x, area.high.x),
                      p.y - std::clamp(p.y, area.low.y, area.high.y));
}

bool within(const Area& area, const Area& frame) {
    return std::abs(shared(area, frame) - shared(area, area)) < 1e-6;
}

/// What holds for any markers.
void expect_legible(std::span<const Marker> markers, std::span<const LabelPlace> places,
                    std::span<const Area> taken) {
    ASSERT_EQ(places.size(), markers.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto& [box, led, from, to] = places[i];
        const Marker& own = markers[i];
        EXPECT_NEAR(box.high.x - box.low.x, own.width, 1e-9);
        EXPECT_NEAR(box.high.y - box.low.y, own.height, 1e-9);
        for (std::size_t k = 0; k < places.size(); ++k) {
            EXPECT_EQ(shared(box, markers[k].area()), 0) << "label " << i << ", marker " << k;
            if (k != i) {
                EXPECT_EQ(shared(box, places[k].box), 0) << "labels " << i << ", " << k;
            }
        }
        for (const Area& area : taken) EXPECT_FALSE(overlap(box, area)) << "label " << i;
        if (led) {
            EXPECT_NEAR(std::hypot(from.x - own.at.x, from.y - own.at.y), own.radius, 1e-9);
            EXPECT_NEAR(distance(box, to), 0, 1e-9);
        } else {
            EXPECT_LT(distance(box, own.at), 2 * own.radius + line_height);
        }
    }
}

/// Lines that run over a label or another line.
int crossings(std::span<const LabelPlace> places) {
    int count = 0;
    for (const LabelPlace& a : places)
        for (const LabelPlace& b : places)
            if (a.led && &a != &b) count += crosses(a.from, a.to, b.box);
    return count;
}

TEST(LabelPlacesTest, NoLabelCoversAnything) {
    test::Random random(1931);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int round = 0; round < 30; ++round) {
        SCOPED_TRACE("round " + std::to_string(round));
        const Area frame{{50, 20}, {random.uniform(400, 900), random.uniform(150, 400)}};
        const double bottom = frame.high.y - random.uniform(0, 40);
        std::vector<Marker> markers(static_cast<std::size_t>(random.integer(1, 14)));
        for (Marker& marker : markers) {
            marker = {.at = {random.uniform(frame.low.x, frame.high.x),
                             random.uniform(frame.low.y, bottom)},
                      .radius = random.uniform(2, 9),
                      .width = random.uniform(15, 140),
                      .height = line_height};
            // Many have the same error, which is none; some have the same time, too.
            if (random.integer(0, 1)) marker.at.y = bottom;
            if (random.integer(0, 4) == 0) marker.at = markers.front().at;
        }
        std::vector<Area> taken;
        if (round % 2) taken.push_back({{frame.low.x, bottom}, {frame.high.x, bottom}});
        const std::vector<LabelPlace> places = label_places(markers, frame, taken);
        ASSERT_NO_FATAL_FAILURE(expect_legible(markers, places, taken));
        const std::vector<LabelPlace> again = label_places(markers, frame, taken);
        for (std::size_t i = 0; i < places.size(); ++i) {
            EXPECT_EQ(places[i].box.low.x, again[i].box.low.x);
            EXPECT_EQ(places[i].box.low.y, again[i].box.low.y);
        }
    }
}

// Six methods miss nothing, the times of two are hardly different, and the line that they stand on
// is near the end of the picture.
TEST(LabelPlacesTest, ManyPointsOnOneLine) {
    test::Random random(7);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const Area frame{{66, 72}, {780, 342}};
    const double line = 310;
    const std::vector<Area> taken{{{frame.low.x, line}, {frame.high.x, line}}};
    for (int round = 0; round < 40; ++round) {
        SCOPED_TRACE("round " + std::to_string(round));
        std::vector<Marker> markers;
        for (double x : {220., 260., 310., 395., 404., 680.})
            markers.push_back({.at = {x + random.uniform(-8, 8), line},
                               .radius = 6,
                               .width = random.uniform(30, 120),
                               .height = line_height});
        const std::vector<LabelPlace> places = label_places(markers, frame, taken);
        ASSERT_NO_FATAL_FAILURE(expect_legible(markers, places, taken));
        for (const LabelPlace& place : places) EXPECT_TRUE(within(place.box, frame));
        EXPECT_EQ(crossings(places), 0);
    }
}

TEST(LabelPlacesTest, AloneALabelIsToTheRight) {
    const Marker marker{.at = {100, 100}, .radius = 5, .width = 40, .height = line_height};
    const Area frame{{0, 0}, {200, 200}};
    const std::vector<LabelPlace> places = label_places({{marker}}, frame);
    ASSERT_EQ(places.size(), 1u);
    EXPECT_FALSE(places[0].led);
    EXPECT_GT(places[0].box.low.x, 105);
    EXPECT_NEAR(places[0].box.low.y + line_height / 2, 100, 1e-9);
    EXPECT_TRUE(label_places({}, frame).empty());
}

TEST(LabelPlacesTest, WithoutRoomLabelsLeaveTheFrame) {
    std::vector<Marker> markers(12, {.at = {10, 10}, .radius = 4, .width = 60, .height = 16});
    const Area frame{{0, 0}, {20, 20}};
    expect_legible(markers, label_places(markers, frame), {});
}

TEST(LabelPlacesTest, LinesCrossAreas) {
    const Area area{{10, 10}, {20, 20}};
    EXPECT_TRUE(crosses({0, 15}, {30, 15}, area));
    EXPECT_TRUE(crosses({15, 12}, {16, 13}, area)) << "inside";
    EXPECT_TRUE(crosses({5, 12}, {12, 5}, {{0, 0}, {9, 9}}));
    EXPECT_FALSE(crosses({0, 15}, {9, 15}, area)) << "too short";
    EXPECT_FALSE(crosses({0, 10}, {30, 10}, area)) << "along the border";
    EXPECT_FALSE(crosses({5, 12}, {12, 5}, area));
}

}  // namespace
}  // namespace pierce::app
