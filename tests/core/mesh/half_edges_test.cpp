// The sides of triangles, edge by edge, against sorting them all.
#include "core/mesh/half_edges.hpp"

#include <gtest/gtest.h>

#include <map>

#include "support/random.hpp"

namespace pierce {
namespace {

TEST(HalfEdgesTest, EachEdgeHasTheSidesOfAllItsTriangles) {
    test::Random random(44);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 50; ++i) {
        const int vertices = random.integer(1, 12);
        std::vector<Triangle> triangles(static_cast<std::size_t>(random.integer(0, 60)));
        for (Triangle& t : triangles)
            for (std::uint32_t& v : t.vertex)
                v = static_cast<std::uint32_t>(random.integer(0, vertices - 1));
        using Side = std::tuple<std::uint32_t, std::uint8_t, bool>;  // triangle, opposite, forward
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Side>> expected;
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            for (std::uint8_t k = 0; k < 3; ++k) {
                const std::uint32_t from = triangles[t].vertex[(k + 1) % 3],
                                    to = triangles[t].vertex[(k + 2) % 3];
                expected[std::minmax(from, to)].push_back({t, k, from < to});
            }
        auto next = expected.begin();
        const HalfEdges sides(triangles, static_cast<std::size_t>(vertices));
        sides.for_each_edge([&](std::span<const HalfEdge> found) {
            ASSERT_NE(next, expected.end());
            std::vector<Side> as_found;
            for (const HalfEdge& s : found) {
                EXPECT_EQ(std::pair(s.low, s.high), next->first);
                as_found.push_back({s.triangle, s.opposite, s.forward});
            }
            EXPECT_EQ(as_found, next->second);
            ++next;
        });
        EXPECT_EQ(next, expected.end());
    }
}

}  // namespace
}  // namespace pierce
