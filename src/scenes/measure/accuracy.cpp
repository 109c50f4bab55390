#include "scenes/measure/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce::scenes {
namespace {

constexpr double least_depth = 10;  // touch tolerances

double angle_between(Vec3d a, Vec3d b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

}  // namespace

AccuracyCount::AccuracyCount(const Recording& recording, bool names_vertices)
    : names_vertices_(names_vertices) {
    for (const RecordedBody& body : recording.bodies) {
        Box box;
        for (Vec3f p : recording.meshes[body.mesh].data.positions) box.extend(to_double(p));
        least_depth_.push_back(least_depth * constants::touch_tolerance * box.extent());
    }
}

void AccuracyCount::add(const TrueFrame& truth, std::span<const MethodContact> contacts) {
    Accuracy& sum = accuracy_;
    std::map<BodyPair, double> found, deepest;
    std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, const MethodContact*>
        by_vertex;
    for (const MethodContact& c : contacts) {
        // The truth knows nothing about bodies that meet themselves.
        if (c.a == c.b) continue;
        double& depth = found[{c.a, c.b}];
        depth = std::max(depth, c.depth);
        if (c.vertex != no_vertex)
            by_vertex[{c.source, c.source == c.a ? c.b : c.a, c.vertex}] = &c;
    }
    sum.pairs += truth.overlapping.size();
    for (const BodyPair& pair : truth.overlapping) sum.missed_pairs += !found.contains(pair);
    for (const auto& [pair, depth] : found)
        sum.false_pairs += depth > 0 && !std::ranges::binary_search(truth.overlapping, pair);

    std::size_t named = 0;
    for (const TrueVertex& v : truth.inside) {
        const BodyPair pair{std::min(v.source, v.target), std::max(v.source, v.target)};
        const Vec3d normal = v.source < v.target ? -v.way_out : v.way_out;
        const bool pair_found = found.contains(pair);
        const auto at = by_vertex.find({v.source, v.target, v.vertex});
        const bool vertex_found = names_vertices_ ? at != by_vertex.end() : pair_found;
        ++sum.vertices;
        sum.depth += v.depth;
        sum.missed_vertices += !vertex_found;
        if (!vertex_found) sum.missed_depth += v.depth;
        if (!pair_found) sum.missed_pair_depth += v.depth;
        double& depth = deepest[pair];
        depth = std::max(depth, v.depth);
        if (at == by_vertex.end()) continue;
        named += at->second->depth > 0;
        if (v.depth < least_depth_[v.target]) continue;
        sum.depth_ratios.push_back(at->second->depth / v.depth);
        sum.normal_errors.push_back(angle_between(at->second->normal, normal));
    }
    const auto claimed = std::ranges::count_if(
        by_vertex, [](const auto& entry) { return entry.second->depth > 0; });
    sum.false_vertices += static_cast<std::size_t>(claimed) - named;
    for (const auto& [pair, depth] : deepest) {
        const auto at = found.find(pair);
        if (at == found.end()) continue;
        sum.pair_depth += depth;
        sum.found_pair_depth += at->second;
    }
}

}  // namespace pierce::scenes
