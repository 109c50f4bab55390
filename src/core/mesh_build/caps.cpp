#include "core/mesh_build/caps.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "core/mesh_build/gap_seams.hpp"
#include "core/mesh_build/missing_edges.hpp"
#include "core/mesh_build/spatial_order.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// Vertices in the order in which a cap runs through them.
using Loop = std::vector<std::uint32_t>;

struct Links {
    std::vector<std::uint32_t> begin;  ///< per vertex, and one more
    std::vector<std::uint32_t> to;
};

/// The missing edges of some triangles, by the vertex they start from.
Links links_of(std::span<const Triangle> triangles, std::size_t vertex_count) {
    Links links{std::vector<std::uint32_t>(vertex_count + 1, 0), {}};
    for (const auto& [from, to] : missing_edges(triangles, vertex_count)) {
        ++links.begin[from + 1];
        links.to.push_back(to);
    }
    for (std::size_t v = 0; v < vertex_count; ++v) links.begin[v + 1] += links.begin[v];
    return links;
}

/// Walks along the missing edges. At every vertex as many of them start as end, so a walk ends only
/// where it began. The part between two visits of a vertex is a loop of its own.
std::vector<Loop> loops_along(const Links& links) {
    constexpr std::uint32_t nowhere = 0xffffffffu;
    std::vector<std::uint32_t> next(links.begin.begin(), links.begin.end() - 1);
    std::vector<std::uint32_t> place(next.size(), nowhere);  // in the walk
    std::vector<Loop> loops;
    Loop walk;
    for (std::uint32_t first = 0; first < next.size(); ++first) {
        walk.assign(1, first);
        place[first] = 0;
        while (next[walk.back()] < links.begin[walk.back() + 1]) {
            const std::uint32_t to = links.to[next[walk.back()]++];
            if (place[to] == nowhere) {
                place[to] = static_cast<std::uint32_t>(walk.size());
                walk.push_back(to);
                continue;
            }
            loops.emplace_back(walk.begin() + place[to], walk.end());
            walk.resize(place[to] + 1);
            for (std::uint32_t v : loops.back())
                if (v != to) place[v] = nowhere;
        }
        place[first] = nowhere;
    }
    return loops;
}

/// Triangulates one loop.
class LoopFill {
public:
    explicit LoopFill(std::span<const Vec3f> positions) : positions_(positions) {}

    Cap fill(Loop loop) {
        Cap cap{.triangles = {}, .border_edges = static_cast<std::uint32_t>(loop.size())};
        cut_ears(loop, cap);
        if (loop.size() >= 3) fill_exactly(loop, cap);
        return cap;
    }

private:
    Vec3d place(std::uint32_t v) const { return to_double(positions_[v]); }
    double area_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        return a == b || b == c || c == a
                   ? 0
                   : 0.5 * length(cross(place(b) - place(a), place(c) - place(a)));
    }
    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, Cap& cap) const {
        if (a == b || b == c || c == a) return;  // its sides cancel
        cap.triangles.push_back({{a, b, c}});
        cap.area += area_of(a, b, c);
    }

    /// Cuts off the corner with the shortest new edge, until the loop is small enough.
    void cut_ears(Loop& loop, Cap& cap) const {
        const std::size_t count = loop.size();
        if (count <= constants::exact_cap_edges) return;
        std::vector<std::size_t> next(count), previous(count);
        std::vector<std::uint32_t> version(count, 0);
        std::vector<bool> cut(count, false);
        struct Ear {
            double new_edge;
            std::size_t at;
            std::uint32_t version;
            bool operator>(const Ear& other) const {
                return std::pair(new_edge, at) > std::pair(other.new_edge, other.at);
            }
        };
        std::priority_queue<Ear, std::vector<Ear>, std::greater<>> ears;
        const auto offer = [&](std::size_t i) {
            const Vec3d edge = place(loop[next[i]]) - place(loop[previous[i]]);
            ears.push({length_squared(edge), i, ++version[i]});
        };
        for (std::size_t i = 0; i < count; ++i) {
            next[i] = (i + 1) % count;
            previous[i] = (i + count - 1) % count;
        }
        for (std::size_t i = 0; i < count; ++i) offer(i);
        for (std::size_t left = count; left > constants::exact_cap_edges;) {
            const Ear ear = ears.top();
            ears.pop();
            if (cut[ear.at] || ear.version != version[ear.at]) continue;
            const std::size_t before = previous[ear.at], after = next[ear.at];
            add(loop[before], loop[ear.at], loop[after], cap);
            cut[ear.at] = true;
            next[before] = after;
            previous[after] = before;
            offer(before);
            offer(after);
            --left;
        }
        Loop rest;
        for (std::size_t i = 0; i < count; ++i)
            if (!cut[i]) rest.push_back(loop[i]);
        loop = std::move(rest);
    }

    /// least_[i][j]: the least area between the loop from i to j and the edge from j to i.
    void fill_exactly(const Loop& loop, Cap& cap) {
        const std::size_t count = loop.size();
        least_.assign(count * count, 0);
        split_.assign(count * count, 0);
        for (std::size_t gap = 2; gap < count; ++gap)
            for (std::size_t i = 0; i + gap < count; ++i) {
                const std::size_t j = i + gap;
                double least = std::numeric_limits<double>::infinity();
                for (std::size_t k = i + 1; k < j; ++k) {
                    const double area = least_[i * count + k] + least_[k * count + j] +
                                        area_of(loop[i], loop[k], loop[j]);
                    if (area < least) {
                        least = area;
                        split_[i * count + j] = static_cast<std::uint32_t>(k);
                    }
                }
                least_[i * count + j] = least;
            }
        std::vector<std::pair<std::size_t, std::size_t>> open(1, {0, count - 1});
        while (!open.empty()) {
            const auto [i, j] = open.back();
            open.pop_back();
            if (j < i + 2) continue;
            const std::size_t k = split_[i * count + j];
            add(loop[i], loop[k], loop[j], cap);
            open.emplace_back(i, k);
            open.emplace_back(k, j);
        }
    }

    std::span<const Vec3f> positions_;
    std::vector<double> least_;
    std::vector<std::uint32_t> split_;
};

/// Two loops and the vertices at which they are nearest to each other.
struct NearLoops {
    std::size_t first, second;
    std::size_t first_at, second_at;
    double distance;
};

/// Pairs of loops with vertices nearer than `width`, the nearest pairs first. A vertex is compared
/// with those that follow it in a spatial order, so that a few pairs of vertices may be missed, but
/// hardly all of two loops that run side by side.
std::vector<NearLoops> near_loops(std::span<const Vec3f> positions, const std::vector<Loop>& loops,
                                  double width) {
    struct Place {
        std::size_t loop, at;
    };
    std::vector<Place> places;
    std::vector<Vec3f> points;
    for (std::size_t l = 0; l < loops.size(); ++l)
        for (std::size_t i = 0; i < loops[l].size(); ++i) {
            places.push_back({l, i});
            points.push_back(positions[loops[l][i]]);
        }
    const std::vector<std::uint32_t> order = spatial_order(points);
    std::map<std::pair<std::size_t, std::size_t>, NearLoops> nearest;
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t j = i + 1; j < order.size() && j <= i + constants::gap_neighbors; ++j) {
            const Place *a = &places[order[i]], *b = &places[order[j]];
            const double distance = length(to_double(points[order[i]]) -
                                           to_double(points[order[j]]));
            if (a->loop == b->loop || !(distance < width)) continue;
            if (a->loop > b->loop) std::swap(a, b);
            const NearLoops near{.first = a->loop,
                                 .second = b->loop,
                                 .first_at = a->at,
                                 .second_at = b->at,
                                 .distance = distance};
            const auto [at, is_new] = nearest.try_emplace({a->loop, b->loop}, near);
            if (!is_new && distance < at->second.distance) at->second = near;
        }
    std::vector<NearLoops> result;
    result.reserve(nearest.size());
    for (const auto& [loops_of_pair, near] : nearest) result.push_back(near);
    std::ranges::stable_sort(result, {}, &NearLoops::distance);
    return result;
}

/// Once around both loops, over a bridge there and back.
Loop bridged(const Loop& first, std::size_t first_at, const Loop& second, std::size_t second_at) {
    Loop both;
    for (std::size_t i = 0; i <= first.size(); ++i)
        both.push_back(first[(first_at + i) % first.size()]);
    for (std::size_t i = 0; i <= second.size(); ++i)
        both.push_back(second[(second_at + i) % second.size()]);
    return both;
}

/// What the seams of gaps leave open between vertices of one cluster belongs to them. Takes those
/// caps out of a list.
Cap cap_of_gaps(const GapSeams& seams, const std::vector<Loop>& loops, std::vector<Cap>& caps) {
    Cap gaps{.triangles = seams.triangles, .area = seams.area, .is_gap = true};
    for (std::size_t i = 0; i < loops.size(); ++i) {
        const auto cluster = [&](std::uint32_t v) { return seams.cluster[v]; };
        if (!std::ranges::all_of(
                loops[i], [&](std::uint32_t v) { return cluster(v) == cluster(loops[i].front()); }))
            continue;
        gaps.triangles.insert(gaps.triangles.end(), caps[i].triangles.begin(),
                              caps[i].triangles.end());
        gaps.area += caps[i].area;
        caps[i] = {};
    }
    return gaps;
}

}  // namespace

std::vector<Cap> caps_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                         double mean_edge) {
    const GapSeams seams = gap_seams(positions, triangles);
    std::vector<Triangle> sewn(triangles.begin(), triangles.end());
    sewn.insert(sewn.end(), seams.triangles.begin(), seams.triangles.end());
    const std::vector<Loop> loops = loops_along(links_of(sewn, positions.size()));
    LoopFill filler(positions);
    std::vector<Cap> caps;
    caps.reserve(loops.size() + 1);
    for (const Loop& loop : loops) caps.push_back(filler.fill(loop));
    caps.push_back(cap_of_gaps(seams, loops, caps));
    std::vector<bool> joined(loops.size());
    for (std::size_t i = 0; i < loops.size(); ++i) joined[i] = caps[i].triangles.empty();
    for (const NearLoops& near : near_loops(positions, loops, constants::gap_width * mean_edge)) {
        if (joined[near.first] || joined[near.second]) continue;
        Cap across = filler.fill(
            bridged(loops[near.first], near.first_at, loops[near.second], near.second_at));
        if (!(across.area < constants::gap_area * (caps[near.first].area + caps[near.second].area)))
            continue;
        joined[near.first] = joined[near.second] = true;
        across.is_gap = true;
        caps[near.first] = std::move(across);
        caps[near.second] = {};
    }
    std::erase_if(caps, [](const Cap& cap) { return cap.triangles.empty(); });
    return caps;
}

}  // namespace pierce
