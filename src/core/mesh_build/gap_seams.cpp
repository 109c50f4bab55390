#include "core/mesh_build/gap_seams.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "core/mesh_build/missing_edges.hpp"
#include "core/mesh_build/triangle_groups.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// Finds which vertices of borders belong together, and sews the edges between them.
class Seamstress {
public:
    Seamstress(std::span<const Vec3f> positions, std::vector<MissingEdge> edges)
        : positions_(positions), edges_(std::move(edges)), clusters_(positions.size()) {
        join_near_vertices();
    }

    GapSeams sew() {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::size_t>> unsewn;
        for (std::size_t e = 0; e < edges_.size(); ++e) {
            const std::uint32_t from = clusters_.root(edges_[e].from),
                                to = clusters_.root(edges_[e].to);
            if (from == to) continue;
            const auto across = unsewn.find({to, from});
            if (across == unsewn.end() || across->second.empty()) {
                unsewn[{from, to}].push_back(e);
                continue;
            }
            const auto nearest = std::ranges::min_element(
                across->second, {}, [&](std::size_t other) { return distance(e, other); });
            close_between(edges_[e], edges_[*nearest]);
            across->second.erase(nearest);
        }
        for (std::uint32_t v = 0; v < positions_.size(); ++v)
            seams_.cluster.push_back(clusters_.root(v));
        return std::move(seams_);
    }

private:
    Vec3d place(std::uint32_t v) const { return to_double(positions_[v]); }

    void join_near_vertices() {
        std::map<std::uint32_t, double> shortest;  // edge at each vertex of a border
        for (const auto& [from, to] : edges_)
            for (const std::uint32_t v : {from, to}) {
                const auto [at, is_new] = shortest.try_emplace(
                    v, std::numeric_limits<double>::infinity());
                at->second = std::min(at->second, length(place(to) - place(from)));
            }
        std::vector<std::uint32_t> vertices;
        std::vector<double> reach;
        std::vector<Box> boxes;
        for (const auto& [v, edge] : shortest) {
            vertices.push_back(v);
            reach.push_back(constants::seam_width * edge);
            boxes.push_back({place(v), place(v)});
        }
        const BoxTree tree(boxes);
        for (std::uint32_t i = 0; i < vertices.size(); ++i)
            tree.for_each_in(boxes[i].inflated(reach[i]), [&](std::uint32_t k) {
                if (k != i &&
                    length(place(vertices[k]) - place(vertices[i])) < std::min(reach[i], reach[k]))
                    clusters_.join(vertices[i], vertices[k]);
            });
    }

    /// Between edges that run against each other.
    double distance(std::size_t edge, std::size_t other) const {
        return length_squared(place(edges_[edge].from) - place(edges_[other].to)) +
               length_squared(place(edges_[edge].to) - place(edges_[other].from));
    }

    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (a == b || b == c || c == a) return;
        seams_.triangles.push_back({{a, b, c}});
        seams_.area += area_of(positions_, seams_.triangles.back());
    }
    void close_between(MissingEdge one, MissingEdge other) {
        add(one.from, one.to, other.from);
        add(one.from, other.from, other.to);
    }

    std::span<const Vec3f> positions_;
    std::vector<MissingEdge> edges_;
    DisjointSets clusters_;
    GapSeams seams_;
};

}  // namespace

GapSeams gap_seams(std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
    std::vector<MissingEdge> edges = missing_edges(triangles, positions.size());
    if (edges.empty()) {
        GapSeams none;
        none.cluster.resize(positions.size());
        std::iota(none.cluster.begin(), none.cluster.end(), 0u);
        return none;
    }
    return Seamstress(positions, std::move(edges)).sew();
}

}  // namespace pierce
