#include "scenes/simulate/sheet_crossings.hpp"

#include <algorithm>
#include <cmath>

#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "core/step/sheets/open_features.hpp"

namespace pierce::scenes {
namespace {

struct Segment {
    std::uint32_t from, to;
};

/// The edges of a surface, each once.
std::vector<Segment> edges_of(std::span<const Triangle> triangles) {
    std::vector<Segment> edges;
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const auto [from, to] = std::minmax(t.vertex[k], t.vertex[(k + 1) % 3]);
            edges.push_back({from, to});
        }
    const auto key = [](Segment s) { return std::pair(s.from, s.to); };
    std::ranges::sort(edges, {}, key);
    const auto rest = std::ranges::unique(edges, {}, key);
    edges.erase(rest.begin(), rest.end());
    return edges;
}

BoxTree tree_of(std::span<const Triangle> triangles, std::span<const Vec3f> positions) {
    std::vector<Box> boxes(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (std::uint32_t v : triangles[i].vertex) boxes[i].extend(to_double(positions[v]));
    return BoxTree(std::move(boxes));
}

/// Adds the edges of one surface that run through triangles of another, or of the same one.
void add_crossings(std::span<const Triangle> of_edges, std::span<const Vec3f> edge_positions,
                   std::span<const Triangle> triangles, std::span<const Vec3f> positions,
                   const BoxTree& tree, SurfaceCrossings& found) {
    // Two surfaces may have the same triangles.
    const bool self = edge_positions.data() == positions.data();
    for (const Segment& s : edges_of(of_edges)) {
        const Vec3d p = to_double(edge_positions[s.from]), q = to_double(edge_positions[s.to]);
        Box box;
        box.extend(p);
        box.extend(q);
        tree.for_each_in(box, [&](std::uint32_t i) {
            const Triangle& t = triangles[i];
            if (self && (has_vertex(t, s.from) || has_vertex(t, s.to))) return;
            const Vec3d a = to_double(positions[t.vertex[0]]),
                        b = to_double(positions[t.vertex[1]]),
                        c = to_double(positions[t.vertex[2]]);
            if (!stages::pierces(p, q, a, b, c)) return;
            const Vec3d n = normalized(cross(b - a, c - a));
            ++found.count;
            found.depth = std::max(found.depth,
                                   std::min(std::fabs(dot(n, p - a)), std::fabs(dot(n, q - a))));
        });
    }
}

}  // namespace

SurfaceCrossings self_crossings(std::span<const Triangle> triangles,
                                std::span<const Vec3f> positions) {
    SurfaceCrossings found;
    add_crossings(triangles, positions, triangles, positions, tree_of(triangles, positions), found);
    return found;
}

SurfaceCrossings crossings(std::span<const Triangle> triangles, std::span<const Vec3f> positions,
                           std::span<const Triangle> other_triangles,
                           std::span<const Vec3f> other_positions) {
    SurfaceCrossings found;
    add_crossings(triangles, positions, other_triangles, other_positions,
                  tree_of(other_triangles, other_positions), found);
    add_crossings(other_triangles, other_positions, triangles, positions,
                  tree_of(triangles, positions), found);
    return found;
}

}  // namespace pierce::scenes
