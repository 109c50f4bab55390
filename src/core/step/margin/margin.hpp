#pragma once

#include <cstdint>
#include <utility>

#include "core/device/view.hpp"
#include "core/step/common/gather.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/edge_chords.hpp"
#include "core/step/margin/join_edge_pairs.hpp"
#include "core/step/margin/margin_stages.hpp"
#include "core/step/margin/near_edge_pairs.hpp"
#include "core/step/solids/join_batch.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/step/solids/step_of_pairs.hpp"

namespace pierce {

/// Finds what is nearer to another solid than the margin and does not overlap it: vertices and the
/// closest points of surfaces, and pairs of edges.
template <Executor E, Tracer<E> T>
class Margin {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    explicit Margin(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Adds contacts with a positive distance to the batch. `routes` of all rays of `batch`; empty
    /// if steps do not remember.
    void find(const StepOfPairs<E>& step, EdgeChords<E, T>& edges, RayBatch<E>& batch,
              Buffer<Route>& routes) {
        executor_.join();  // boxes around deforming bodies were measured beside the other stages
        executor_.beside([&] { find_vertices(step); });
        find_edge_pairs(step, edges);
        executor_.join();
        const bool remembers = step.scene.plan->remembers();
        const Count vertices = count_of(near_.candidates);
        executor_.for_each(
            vertices, stages::JoinAsContact{view_of(std::as_const(near_.candidates)),
                                            room_in(batch, routes, remembers, vertices, near_)});
        const Count found = count_of(pairs_), first = edges.chord_count();
        executor_.for_each(
            found, stages::JoinEdgePairs{.bodies = step.scene.bodies,
                                         .directed = step.directed,
                                         .pairs = view_of(pairs_),
                                         .first_chord = first,
                                         .chords = edges.add_room(found),
                                         .batch = room_in(batch, routes, remembers, found, near_)});
    }

    /// Clears what an earlier step has left.
    void forget() { pairs_.clear(); }

    /// How many pairs of edges were near in the last step.
    Count edge_pairs() const { return count_of(pairs_); }

private:
    /// Lists the near vertices as candidates of `near_`.
    void find_vertices(const StepOfPairs<E>& step) {
        const View<const BodyView> bodies = step.scene.bodies;
        executor_.emit(ListId::margin_blocks, 2 * step.count,
                       stages::ListMarginBlocks{bodies, step.directed}, blocks_);
        tools_.share_out(count_of(blocks_), [&](auto share, const Count& blocks) {
            executor_.emit(
                ListId::margin_patches, blocks,
                stages::CullMarginBlock<decltype(share)>{bodies, step.directed, view_of(blocks_)},
                patches_);
        });
        tools_.share_out(count_of(patches_), [&](auto share, const Count& patches) {
            executor_.emit(ListId::margin_vertices, patches,
                           stages::CullMarginVertices<decltype(share)>{bodies, step.directed,
                                                                       view_of(patches_)},
                           near_.sources);
        });
        const Count count = count_of(near_.sources);
        near_.resize(count);
        near_.keep.resize(count);
        queries_.resize(count);
        tools_.closest_between(bodies, queries_,
                               stages::GenerateNearQueries{.bodies = bodies,
                                                           .directed = step.directed,
                                                           .sources = view_of(near_.sources),
                                                           .queries = view_of(queries_)},
                               [&](View<const std::uint32_t> closest) {
                                   return stages::MeasureNear{
                                       .bodies = bodies,
                                       .directed = step.directed,
                                       .sources = view_of(std::as_const(near_.sources)),
                                       .queries = view_of(std::as_const(queries_)),
                                       .closest = closest,
                                       .rays = view_of(near_.rays),
                                       .hits = view_of(near_.hits),
                                       .meetings = view_of(near_.meetings),
                                       .keep = view_of(near_.keep)};
                               });
        tools_.list(ListId::near_contacts, count,
                    stages::IsMarked{view_of(std::as_const(near_.keep))}, near_.candidates);
    }

    /// Lists the pairs of edges.
    void find_edge_pairs(const StepOfPairs<E>& step, EdgeChords<E, T>& edges) {
        const View<const BodyView> bodies = step.scene.bodies;
        executor_.emit(ListId::margin_edge_blocks, 2 * step.count,
                       stages::ListMarginEdgeBlocks{bodies, step.directed}, edge_blocks_);
        executor_.emit(ListId::margin_edge_groups, count_of(edge_blocks_),
                       stages::CullMarginEdgeBlock{bodies, step.directed, view_of(edge_blocks_)},
                       edge_groups_);
        edges.measure_boxes_of(step, edge_groups_);
        executor_.emit(ListId::margin_edges, count_of(edge_groups_),
                       stages::CullMarginEdges{bodies, step.directed, view_of(edge_groups_)},
                       edges_);
        executor_.emit(ListId::margin_ridges, count_of(edges_),
                       stages::KeepNearRidges{bodies, step.directed, view_of(edges_)}, ridges_);
        executor_.emit(ListId::margin_ridge_groups, count_of(ridges_),
                       stages::FindGroupsNearRidge{.bodies = bodies,
                                                   .directed = step.directed,
                                                   .ridges = view_of(std::as_const(ridges_)),
                                                   .marks = step.marks},
                       ridge_groups_);
        executor_.emit(ListId::near_edge_pairs, count_of(ridge_groups_),
                       stages::FindEdgePairs{.bodies = bodies,
                                             .directed = step.directed,
                                             .ridges = view_of(std::as_const(ridges_)),
                                             .near = view_of(std::as_const(ridge_groups_)),
                                             .marks = step.marks},
                       pairs_);
    }

    StepTools<E, T>& tools_;
    E& executor_;
    Buffer<stages::CullItem> blocks_, patches_, edge_blocks_, edge_groups_, edges_;
    Buffer<stages::NearRidge> ridges_;
    Buffer<stages::RidgeNearGroup> ridge_groups_;
    Buffer<Ray> queries_;
    Buffer<stages::NearEdgePair> pairs_;
    RayBatch<E> near_;
};

}  // namespace pierce
