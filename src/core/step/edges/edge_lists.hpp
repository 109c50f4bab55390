#pragma once

#include <cstdint>

#include "core/execute/executor.hpp"
#include "core/step/edges/chord_stages.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/trace/ray.hpp"

/// The lists of edges in a step, grouped by the part that writes them. They grow and are kept.
namespace pierce {

/// Which edges may reach the other body of their pair.
template <Executor E>
struct EdgeCullLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<std::uint32_t> masks, slots;
    Buffer<stages::CullItem> patches;
    Buffer<stages::EdgeGroup> groups;
    Buffer<stages::EdgeItem> items;
    Buffer<stages::Span> spans;
};

/// The rays along edges, and how far they have come.
template <Executor E>
struct EdgeSegmentLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::Segment> all;
    Buffer<Ray> rays;
    Buffer<std::uint32_t> active, next_active, finished;
    Buffer<std::uint32_t> touching;  ///< per pair
};

/// The parts of edges inside the other body.
template <Executor E>
struct ChordLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::FoundChord> found, now_found;
    Buffer<std::uint64_t> keys, sorted_keys;
    Buffer<std::uint32_t> unsorted, order;
    Buffer<Chord> all;
};

/// Free again after every use.
template <Executor E>
struct EdgeScratch {
    typename E::template Buffer<std::uint32_t> counts, offsets, places;
    typename E::template Buffer<Ray> now_rays;
    typename E::template Buffer<Hit> now_hits;
};

}  // namespace pierce
