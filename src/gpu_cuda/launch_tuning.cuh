#pragma once

#include "core/execute/stage_traits.hpp"
#include "core/step/common/bounds.hpp"
#include "core/step/common/frame_fit.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/edges/asked_edges.hpp"
#include "core/step/edges/chord_stages.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/margin/near_edge_pairs.hpp"
#include "core/step/sheets/sheet_bounds.hpp"
#include "core/step/sheets/sheet_contacts.hpp"
#include "core/step/sheets/sheet_features.hpp"
#include "core/step/sheets/sheet_meetings.hpp"
#include "core/step/sheets/sheet_search.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "core/trace/bvh/candidates.hpp"
#include "core/trace/bvh/closest_candidates.hpp"
#include "core/trace/bvh/refit.hpp"

/// How stages are launched that were measured to be slower with the usual launch.
namespace pierce::cuda {

/// How a stage is launched.
struct Launch {
    int threads_at_once = 0;  ///< how many threads must fit on a multiprocessor: more threads hide
                              ///< more waiting, but have fewer registers each; 0: as many as a
                              ///< block has
    bool is_uneven = false;  ///< the stage's threads take very different times: a small block makes
                             ///< room for the next one sooner
};

template <class Stage>
inline constexpr Launch launch_of{};

// The next eight were measured one by one, in a step of 10,000 soft tori on an H200, with the usual
// launch and with 512, 768 and 1024 threads. With the best number they take less time: edges 12 %,
// near edges 16 %, bounds 27 %, directed pairs 5 %, rays 33 %, inside tests 20 %, frames 25 %,
// boxes of pairs 19 %.
template <>
inline constexpr Launch launch_of<FindWanted<stages::MayCross, stages::FindChords>>{
    .threads_at_once = 512};
template <>
inline constexpr Launch launch_of<stages::FindNearEdges<AllOfSixteen>>{.threads_at_once = 512};
template <>
inline constexpr Launch launch_of<stages::MeasureBounds>{.threads_at_once = 512};
template <>
inline constexpr Launch launch_of<stages::DirectPair>{.threads_at_once = 512};
template <>
inline constexpr Launch launch_of<stages::GenerateRay>{.threads_at_once = 1024};
template <>
inline constexpr Launch launch_of<stages::TestInside>{.threads_at_once = 768};
template <>
inline constexpr Launch launch_of<stages::FitFrame>{.threads_at_once = 768};
template <>
inline constexpr Launch launch_of<stages::TestPair>{.threads_at_once = 1024};

// Measured: with 1280 threads a fifth slower.
template <>
inline constexpr Launch launch_of<bvh::FindCandidates>{.threads_at_once = 1024, .is_uneven = true};

// Measured: with 384 threads a tenth slower, with 768 a quarter.
template <>
inline constexpr Launch launch_of<bvh::Trace>{.threads_at_once = 512, .is_uneven = true};

// Measured in steps of 10,000 soft tori on an H100 and an H200: 16 to 18 % and 5 % less time than
// with the usual launch.
template <>
inline constexpr Launch launch_of<bvh::ClosestOfCandidates>{.threads_at_once = 768};
template <>
inline constexpr Launch launch_of<stages::MeasurePatches>{.threads_at_once = 768};

// Nearly all threads only check whether they have work.
template <>
inline constexpr Launch launch_of<bvh::TraceTree>{.threads_at_once = 1024};
template <>
inline constexpr Launch launch_of<bvh::ClosestInTree>{.threads_at_once = 1024};

template <>
inline constexpr Launch launch_of<bvh::FindClosestCandidates>{.threads_at_once = 1024,
                                                              .is_uneven = true};

template <>
inline constexpr Launch launch_of<bvh::Refit>{.is_uneven = true};

// Measured: with 134 registers and a fourth fewer threads, steps with many near contacts took 10 %
// longer.
template <>
inline constexpr Launch launch_of<stages::FindEdgePairs>{.threads_at_once = 512};

// Measured: with 512 threads a step of many sheets takes 0.5 % longer.
template <>
inline constexpr Launch launch_of<stages::PlaceGroups>{.threads_at_once = 1024};

// Measured: with 768 threads a step of many sheets takes 0.5 % longer.
template <>
inline constexpr Launch launch_of<stages::FindParts>{.threads_at_once = 1280};

// Measured: with 768 or 1024 threads a step of many sheets takes 0.5 % longer.
template <>
inline constexpr Launch launch_of<stages::FindTriangles>{.threads_at_once = 1280};

// Measured: with 768 threads a step of many sheets takes 0.8 % longer.
template <>
inline constexpr Launch launch_of<stages::CullTriangles>{.threads_at_once = 1280};

// Measured: with 1024 threads a step of many sheets takes 0.2 % longer.
template <>
inline constexpr Launch launch_of<stages::FindFeatures>{.threads_at_once = 1280};

// Measured: with 384 threads a quarter slower.
template <>
inline constexpr Launch launch_of<stages::MeetFeatures<false>>{.threads_at_once = 512};

template <>
inline constexpr Launch launch_of<stages::MeetFeatures<true>>{.threads_at_once = 256};

// This stage waits for memory.
template <>
inline constexpr Launch launch_of<stages::FindAge>{.threads_at_once = 1536};

template <>
inline constexpr Launch launch_of<stages::FillSheetContact>{.threads_at_once = 768};

/// How many blocks of a stage must fit on a multiprocessor.
template <class Stage>
constexpr int blocks_at_once(std::uint32_t threads_of_a_block) {
    const int threads = launch_of<Stage>.threads_at_once;
    return threads > 0 ? threads / static_cast<int>(threads_of_a_block) : 1;
}

}  // namespace pierce::cuda
