#pragma once

#include <cstdint>

#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/records.hpp"
#include "core/trace/ray.hpp"
#include "pierce/host_device.hpp"

namespace pierce::stages {

/// The rays of each pair as a chain, so that one is looked for among those of its pair only. Their
/// order depends on the run, so a search must have no more than one answer.
struct RayChains {
    View<std::uint32_t> first;  ///< per pair, or no_record
    View<std::uint32_t> next;   ///< per ray, or no_record

    PIERCE_HD void add(std::uint32_t pair, std::uint32_t ray) const {
        next[ray] = atomic_exchange(first[pair], ray);
    }
    /// The ray of a pair for which is_it(ray) holds, or no_record.
    template <class IsIt>
    PIERCE_HD std::uint32_t find(std::uint32_t pair, const IsIt& is_it) const {
        std::uint32_t ray = first[pair];
        while (ray != no_record && !is_it(ray)) ray = next[ray];
        return ray;
    }
};

/// Per candidate: a vertex of a pair in which one only touches joins the chain of its pair.
struct ChainTouchingVertices {
    View<const RaySource> sources;
    View<const std::uint32_t> candidates;
    PairMarks marks;
    RayChains chains;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t k) const {
        const RaySource& from = sources[candidates[k]];
        if (from.start == RayStart::vertex && marks.any(from.pair, PairMarks::vertex_touches))
            chains.add(from.pair, k);
    }
};

/// Per stranded vertex: it joins the chain of its pair.
struct ChainStrandedVertices {
    View<const RaySource> vertices;
    RayChains chains;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t k) const { chains.add(vertices[k].pair, k); }
};

}  // namespace pierce::stages
