#pragma once

#include <cstdint>

#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/step/edges/chord_stages.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/trace/ray.hpp"

/// The lists of edges in a step, grouped by the part that writes them. They grow and are kept.
namespace pierce {

/// Which edges are near the other body of their pair, and for how long that holds.
template <Executor E>
struct NearEdgeMemory {
    typename E::template Buffer<NearEdge> edges;
    typename E::template Buffer<NearEdgesOfPair> of_pairs;  ///< two per pair, or none

    void clear() {
        edges.clear();
        of_pairs.clear();
    }
};

/// How near edges are found.
template <Executor E>
struct NearEdgeLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::CullItem> blocks, groups;
    Buffer<NearEdge> in_spheres;  ///< near by their spheres, before boxes are asked
    Buffer<NearEdge> found;
    Buffer<std::uint32_t> gaps;  ///< per directed pair (note_gap); empty if steps do not remember
};

/// The parts of edges inside the other body.
template <Executor E>
struct ChordLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::FoundChord> found;
    Buffer<Chord> all;
    Buffer<RaySource> sources;   ///< of the rays of all of them
    Buffer<std::uint32_t> flat;  ///< per chord: its candidate that has no depth, or no_record

    template <class Count>
    void resize(const Count& count) {
        all.resize(count);
        sources.resize(count);
        flat.resize(count);
    }
    stages::ChordsOfStep views(stages::PairMarks marks) {
        return {view_of(all), view_of(sources), view_of(flat), marks};
    }
};

/// Free again after every use.
template <Executor E>
struct EdgeScratch {
    typename E::template Buffer<std::uint32_t> places, deep, wanted;
    typename E::template Buffer<Ray> rays;
    typename E::template Buffer<Hit> hits;
};

}  // namespace pierce
