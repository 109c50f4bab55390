#pragma once

#include "core/device/view.hpp"
#include "core/step/common/records.hpp"
#include "core/trace/ray.hpp"
#include "pierce/contact.hpp"
#include "pierce/min_max.hpp"

/// statistics: what the step did, added up. One term per item of a reduction.
namespace pierce::stages {

/// What a walk did.
struct WalkCount {
    std::uint32_t steps = 0;
    bool lost = false;
    std::uint8_t padding[3] = {};
};

/// 1 for a ray that is traced.
struct CountTraced {
    View<const Ray> rays;

    static constexpr bool is_cheap = true;

    PIERCE_HD std::uint32_t operator()(std::uint32_t i) const { return rays[i].t_max >= 0; }
};

/// 1 for a ray that meets the other body.
struct CountHit {
    View<const Hit> hits;

    static constexpr bool is_cheap = true;

    PIERCE_HD std::uint32_t operator()(std::uint32_t i) const {
        return hits[i].triangle != no_triangle && !hits[i].predicted;
    }
};

/// The sums over contacts.
struct ContactSums {
    std::uint32_t touching_pairs = 0, edges = 0, reprojected = 0, predictions_true = 0;
    std::uint32_t self = 0, crossings = 0, remembered = 0, tangled = 0;
    double depth = 0, depth_max = 0;  ///< [length]

    PIERCE_HD friend ContactSums operator+(const ContactSums& a, const ContactSums& b) {
        return {.touching_pairs = a.touching_pairs + b.touching_pairs,
                .edges = a.edges + b.edges,
                .reprojected = a.reprojected + b.reprojected,
                .predictions_true = a.predictions_true + b.predictions_true,
                .self = a.self + b.self,
                .crossings = a.crossings + b.crossings,
                .remembered = a.remembered + b.remembered,
                .tangled = a.tangled + b.tangled,
                .depth = a.depth + b.depth,
                .depth_max = max_of(a.depth_max, b.depth_max)};
    }
};

/// What a contact adds to the sums; `first`: it is the first one of its pair.
PIERCE_HD inline ContactSums sums_of(const Contact& c, bool first) {
    return {.touching_pairs = first,
            .edges = c.is_edge(),
            .reprojected = c.reprojected,
            .predictions_true = c.found == Found::prediction,
            .self = c.a == c.b,
            .crossings = c.found == Found::crossing,
            .remembered = c.found == Found::remembered,
            .tangled = c.found == Found::tangled,
            .depth = c.penetration_depth(),
            .depth_max = c.penetration_depth()};
}

/// The sums over walks.
struct WalkSums {
    std::uint32_t steps = 0, lost = 0;

    PIERCE_HD friend WalkSums operator+(const WalkSums& a, const WalkSums& b) {
        return {a.steps + b.steps, a.lost + b.lost};
    }
};

struct CountWalk {
    View<const WalkCount> walks;

    static constexpr bool is_cheap = true;

    PIERCE_HD WalkSums operator()(std::uint32_t i) const { return {walks[i].steps, walks[i].lost}; }
};

/// 1 for a vertex that needed no ray.
struct CountSkipped {
    View<const Route> routes;

    static constexpr bool is_cheap = true;

    PIERCE_HD std::uint32_t operator()(std::uint32_t i) const {
        return routes[i] == Route::skip || routes[i] == Route::kept;
    }
};

/// 1 for a vertex that a look has found inside.
struct CountLooked {
    View<const Route> routes;

    static constexpr bool is_cheap = true;

    PIERCE_HD std::uint32_t operator()(std::uint32_t i) const { return routes[i] == Route::looked; }
};

/// 1 for a vertex that is expected to enter the other body.
struct CountPredicted {
    View<const VertexRecord> records;

    static constexpr bool is_cheap = true;

    PIERCE_HD std::uint32_t operator()(std::uint32_t i) const { return records[i].predicted; }
};

/// 1 for a pair in which all vertices of one body, or of both, were looked at.
struct CountFullPass {
    View<const PairMemory> memory;

    static constexpr bool is_cheap = true;

    PIERCE_HD std::uint32_t operator()(std::uint32_t i) const {
        return memory[2 * i].pass == Pass::full || memory[2 * i + 1].pass == Pass::full;
    }
};

}  // namespace pierce::stages
