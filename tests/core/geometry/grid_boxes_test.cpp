// Sixteen boxes in steps of a grid, against boxes in float32: none that overlaps may be left out.
#include "core/geometry/grid_boxes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.hpp"

namespace pierce {
namespace {

using test::Random;

bool overlap(const QuickBox& a, const QuickBox& b) {
    bool all = true;
    for (int axis = 0; axis < 3; ++axis)
        all = all && a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis];
    return all;
}

/// Boxes anywhere, of a scale of their own, at times flat or a point; and places that touch them.
class Boxes {
public:
    explicit Boxes(Random& random)
        : random_(random),
          scale_(std::exp2(random.integer(-30, 30))),
          far_(std::exp2(random.integer(0, 12)) * random.in_box(1)),
          flat_(random.integer(0, 5)) {}

    QuickBox next(double size) {
        QuickBox box;
        for (int corner = 0; corner < 2; ++corner) {
            Vec3d p = middle_ + size * random_.in_box(1);
            if (flat_ < 3) p[flat_] = 0;
            box.extend(to_float(scale_ * (p + far_)));
        }
        return box;
    }
    void move() { middle_ = random_.in_box(1); }

private:
    Random& random_;
    double scale_;
    Vec3d far_, middle_;
    int flat_;
};

TEST(GridBoxesTest, BoxesThatOverlapAreNeverLeftOut) {
    Random random(1);
    int overlapping = 0, apart = 0, left_out = 0;
    for (int i = 0; i < 20000; ++i) {
        Boxes boxes(random);
        QuickBox held[constants::group_size], whole;
        const int count = random.integer(0, static_cast<int>(constants::group_size));
        for (int k = 0; k < count; ++k) {
            boxes.move();
            held[k] = boxes.next(std::exp2(-random.uniform(0, 10)));
            whole.extend(held[k]);
        }
        GridBoxes grid;
        grid.steps = BoxSteps(whole);
        for (std::uint32_t k = 0; k < constants::group_size; ++k) grid.set(k, grid.steps, held[k]);
        for (int query = 0; query < 4; ++query) {
            boxes.move();
            QuickBox box = boxes.next(std::exp2(-random.uniform(0, 10)));
            // One that hardly touches, or all of space.
            const int kind = random.integer(0, 5);
            if (kind == 0 && count > 0)
                box.lower.x = box.upper.x = held[random.integer(0, count - 1)].upper.x;
            if (kind == 1)
                for (int axis = 0; axis < 3; ++axis) {
                    box.lower[axis] = -0x1p60f;
                    box.upper[axis] = 0x1p60f;
                }
            const std::uint32_t near = grid.near(box);
            for (std::uint32_t k = 0; k < constants::group_size; ++k) {
                const bool is_near = (near >> k & 1) != 0;
                if (held[k].empty()) {
                    ASSERT_FALSE(is_near)
                        << "seed " << random.seed() << ", case " << i << ": an empty one";
                    continue;
                }
                if (overlap(held[k], box)) {
                    ++overlapping;
                    ASSERT_TRUE(is_near)
                        << "seed " << random.seed() << ", case " << i << ", box " << k;
                } else {
                    ++apart;
                    left_out += !is_near;
                }
            }
        }
    }
    EXPECT_GT(overlapping, 10000);
    EXPECT_GT(left_out, apart * 9 / 10);
}

TEST(GridBoxesTest, AnEmptyBoxIsNearNothing) {
    GridBoxes grid;
    QuickBox box;
    box.extend(Vec3f{1, 2, 3});
    box.extend(Vec3f{2, 4, 5});
    grid.steps = BoxSteps(box);
    for (std::uint32_t k = 0; k < constants::group_size; ++k) grid.set(k, grid.steps, box);
    EXPECT_EQ(grid.near(box), 0xffffu);
    EXPECT_EQ(grid.near(QuickBox{}), 0u);
    EXPECT_EQ(grid.near(QuickBox{}.inflated(1.0f)), 0u);
}

}  // namespace
}  // namespace pierce
