// The tree of boxes against all triangles' boxes: none that overlaps may be left out.
#include "core/mesh/box_nodes.hpp"

#include <gtest/gtest.h>

#include <set>

#include "pierce/mesh.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

TEST(BoxNodesTest, EveryTriangleWhoseBoxOverlapsIsFound) {
    test::Random random(31);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t near = 0, shown = 0, all = 0;
    for (const std::uint32_t count : {1u, 15u, 16u, 17u, 300u, 5000u}) {
        MeshData data;
        for (std::uint32_t t = 0; t < count; ++t) {
            const Vec3d middle = random.in_box(1);
            for (int k = 0; k < 3; ++k)
                data.positions.push_back(to_float(middle + random.in_box(0.1)));
            data.triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}});
        }
        const Mesh mesh("soup", data);
        const MeshView& view = mesh.view();
        const BoxLevels levels(count);
        ASSERT_EQ(view.box_nodes.size, levels.nodes());
        for (int i = 0; i < 200; ++i) {
            QuickBox box;
            const Vec3d middle = random.in_box(1.2);
            for (int k = 0; k < 2; ++k) box.extend(to_float(middle + random.in_box(0.2)));
            std::set<std::uint32_t> found;
            for_each_group(
                view.box_nodes, levels, box, [&](std::uint32_t group, std::uint32_t mask) {
                    for (; mask != 0; mask &= mask - 1)
                        found.insert(view.group_triangles[16 * group + lowest_bit(mask)]);
                    return false;
                });
            shown += found.size();
            all += count;
            for (std::uint32_t t = 0; t < count; ++t) {
                const QuickBox of_triangle = box_of(view, view.positions, t);
                bool overlap = true;
                for (int r = 0; r < 3; ++r)
                    overlap = overlap && of_triangle.lower[r] <= box.upper[r] &&
                              box.lower[r] <= of_triangle.upper[r];
                near += overlap;
                EXPECT_TRUE(!overlap || found.contains(t));
            }
        }
    }
    EXPECT_GT(near, 1000u);
    EXPECT_LT(shown, 2 * near) << "boxes in steps are little larger than boxes";
    EXPECT_LT(near, all / 20);
}

TEST(BoxNodesTest, TheSearchEndsWhenItIsTold) {
    const Mesh mesh("tetrahedron", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                    {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}});
    int calls = 0;
    QuickBox everything;
    everything.extend(Vec3f{-9, -9, -9});
    everything.extend(Vec3f{9, 9, 9});
    EXPECT_TRUE(for_each_group(mesh.view().box_nodes, BoxLevels(4), everything,
                               [&](std::uint32_t, std::uint32_t) { return ++calls > 0; }));
    EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace pierce
