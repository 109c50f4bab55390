#pragma once

#include <bit>
#include <utility>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/sheets/flat_stars.hpp"
#include "core/step/sheets/open_features.hpp"
#include "core/step/sheets/sheet_contacts.hpp"
#include "core/step/sheets/sheet_lists.hpp"

namespace pierce {

/// Finds the contacts of sheets with themselves and others over the motion of a step, and remembers
/// their sides.
template <Executor E, Tracer<E> T>
class Sheets {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    explicit Sheets(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Places all bodies over the step, while other work runs; find() then skips that.
    void bound_all(const Scene& scene) {
        // In the first step of a plan the host knows the counts, and they hold for the plan's other
        // steps. A captured step that outlasts its plan has to count itself.
        if (scene.meshes_change || planned_ != scene.plan->revision) {
            executor_.assign(places_.wanted, scene.bodies.size, 1u);
            place(scene);
            planned_ = scene.plan->revision;
        }
        executor_.beside([&] { bound(scene); });
        is_bound_ = true;
    }

    /// All contacts of sheets, sorted by pair, kind and feature. `links`: which of last step's
    /// pairs each pair was.
    void find(const Scene& scene, const Buffer<Pair>& pairs, View<const std::uint32_t> links) {
        now_.sheet_key.bits = scene.plan->feature_bits;
        search(scene, pairs, links);
        meet(scene, pairs);
    }

    /// What the last step has left for the next one.
    void save(StepMemory& m) const { now_.save(executor_, m); }
    void restore(const StepMemory& m) {
        features_.contacts.clear();
        now_.restore(executor_, m);
    }

    /// Clears what an earlier step has left, as this one may have no sheets, or none that are
    /// bound.
    void forget() {
        features_.contacts.clear();
        now_.forget();
        is_bound_ = false;
    }

    const Buffer<Contact>& contacts() const { return features_.contacts; }
    /// Adds up the step's contacts. `ray_keys`: of those that rays have found.
    void add_up(View<const std::uint64_t> ray_keys,
                typename E::template Sum<stages::ContactSums>& sums) {
        executor_.reduce(count_of(features_.contacts),
                         stages::CountSheetContact{.keys = view_of(now_.keys),
                                                   .records = view_of(now_.records),
                                                   .sheet_key = now_.sheet_key,
                                                   .ray_keys = ray_keys},
                         sums);
    }
    std::uint32_t triangle_pairs() const { return executor_.number(count_of(search_.triangles)); }
    std::uint32_t feature_pairs() const { return executor_.number(count_of(features_.features)); }

    /// Makes this step's records those of the last step.
    void recall() { std::swap(now_, last_); }

private:
    /// Finds triangles that may meet.
    void search(const Scene& scene, const Buffer<Pair>& pairs, View<const std::uint32_t> links) {
        const Count pair_count = count_of(pairs);
        const std::uint32_t bodies = scene.bodies.size;
        search_.pairs.resize(pair_count);
        search_.links.resize(pair_count);
        if (!is_bound_) executor_.assign(places_.wanted, bodies, 0u);
        executor_.for_each(pair_count, stages::PlanSheetPair{.bodies = scene.bodies,
                                                             .ids = scene.ids,
                                                             .pairs = view_of(pairs),
                                                             .links = links,
                                                             .forgets = scene.forgets_sides,
                                                             .last_deepest = view_of(last_.deepest),
                                                             .sheet_pairs = view_of(search_.pairs),
                                                             .sheet_links = view_of(search_.links),
                                                             .wanted = view_of(places_.wanted)});
        if (!is_bound_) {
            place(scene);
            bound(scene);
        }
        executor_.emit(ListId::section_rows, pair_count,
                       stages::FindRows{view_of(search_.pairs), view_of(places_.section_offsets),
                                        view_of(places_.section_counts)},
                       search_.section_rows);
        executor_.emit(ListId::section_pairs, count_of(search_.section_rows),
                       stages::FindSections{.pairs = view_of(search_.pairs),
                                            .rows = view_of(search_.section_rows),
                                            .section_offsets = view_of(places_.section_offsets),
                                            .sections = view_of(places_.section_counts)},
                       search_.sections);
        if (is_bound_) executor_.join();
        is_bound_ = false;
        executor_.beside([&] { find_flat_corners(scene); });

        executor_.emit(
            ListId::block_pairs, executor_.times(constants::group_size, count_of(search_.sections)),
            stages::FindParts{
                .pairs = view_of(search_.pairs),
                .close = view_of(search_.sections),
                .parts = {view_of(bounds_.section_begins), view_of(bounds_.section_ends)},
                .boxes = view_of(bounds_.block_boxes),
                .packed = view_of(bounds_.in_sections),
                .slabs = view_of(bounds_.block_slabs),
                .wholes = {}},
            search_.blocks);
        executor_.emit(ListId::group_pairs,
                       executor_.times(constants::group_size, count_of(search_.blocks)),
                       stages::FindParts{.pairs = view_of(search_.pairs),
                                         .close = view_of(search_.blocks),
                                         .parts = {},
                                         .boxes = view_of(bounds_.group_boxes),
                                         .packed = view_of(bounds_.in_blocks),
                                         .slabs = view_of(bounds_.group_slabs),
                                         .wholes = view_of(bounds_.block_boxes)},
                       search_.groups);
        executor_.emit(ListId::near_triangles,
                       executor_.times(stages::FindTriangles::per_group, count_of(search_.groups)),
                       stages::FindTriangles{
                           .pairs = view_of(search_.pairs),
                           .close = view_of(search_.groups),
                           .boxes = view_of(bounds_.triangle_boxes),
                           .packed = view_of(bounds_.in_groups),
                           .groups = {view_of(bounds_.group_boxes), view_of(bounds_.group_slabs),
                                      view_of(bounds_.group_heights)},
                           .drifting = interleaved(view_of(bounds_.triangles))},
                       search_.near);
        executor_.join();
        executor_.emit(ListId::triangle_pairs, count_of(search_.near),
                       stages::CullTriangles{.pairs = view_of(search_.pairs),
                                             .near = view_of(search_.near),
                                             .drifting = interleaved(view_of(bounds_.triangles)),
                                             .flat_corners = view_of(bounds_.flat_corners)},
                       search_.triangles);
    }

    /// Finds where the vertices, blocks and sections of wanted bodies are among those of all
    /// bodies.
    void place(const Scene& scene) {
        const std::uint32_t bodies = scene.bodies.size;
        places_.section_counts.resize(bodies);
        places_.block_counts.resize(bodies);
        places_.vertex_counts.resize(bodies);
        executor_.for_each(bodies,
                           stages::CountSheetItems{.bodies = scene.bodies,
                                                   .wanted = view_of(places_.wanted),
                                                   .sections = view_of(places_.section_counts),
                                                   .blocks = view_of(places_.block_counts),
                                                   .vertices = view_of(places_.vertex_counts)});
        bounds_.vertices.resize(
            tools_.place(ListId::sheet_vertices, places_.vertex_counts, places_.vertex_offsets));
        bounds_.section_begins.resize(
            tools_.place(ListId::sheet_sections, places_.section_counts, places_.section_offsets));
        bounds_.block_boxes.resize(
            tools_.place(ListId::sheet_blocks, places_.block_counts, places_.block_offsets));
    }

    /// Places vertices and triangles over the step, and bounds the triangles.
    void bound(const Scene& scene) {
        executor_.for_each(count_of(bounds_.vertices),
                           stages::MoveVertices{scene.bodies, view_of(places_.vertex_offsets),
                                                view_of(bounds_.vertices)});
        const Count sections = count_of(bounds_.section_begins),
                    blocks = count_of(bounds_.block_boxes);
        const Count groups = constants::group_size * blocks,
                    triangles = constants::group_size * groups;
        bounds_.triangles.resize(triangles);
        bounds_.triangle_boxes.resize(triangles);
        bounds_.in_groups.resize(groups);
        bounds_.group_slabs.resize(groups);
        bounds_.group_boxes.resize(groups);
        if (E::traits.host_reads) bounds_.group_heights.resize(groups);
        executor_.for_each(executor_.in_sixteens(groups),
                           stages::PlaceGroups{.bodies = bodies_of(scene),
                                               .drifting = interleaved(view_of(bounds_.triangles)),
                                               .triangle_boxes = view_of(bounds_.triangle_boxes),
                                               .packed = view_of(bounds_.in_groups),
                                               .slabs = view_of(bounds_.group_slabs),
                                               .boxes = view_of(bounds_.group_boxes),
                                               .heights = view_of(bounds_.group_heights)});
        bounds_.in_blocks.resize(blocks);
        bounds_.block_slabs.resize(blocks);
        executor_.for_each(executor_.in_sixteens(blocks),
                           stages::BoundBlocks{.groups = view_of(bounds_.group_slabs),
                                               .group_boxes = view_of(bounds_.group_boxes),
                                               .packed = view_of(bounds_.in_blocks),
                                               .slabs = view_of(bounds_.block_slabs),
                                               .boxes = view_of(bounds_.block_boxes)});
        bounds_.in_sections.resize(sections);
        bounds_.section_ends.resize(sections);
        executor_.for_each(
            executor_.in_sixteens(sections),
            stages::BoundSections{.section_offsets = view_of(places_.section_offsets),
                                  .block_offsets = view_of(places_.block_offsets),
                                  .blocks = view_of(places_.block_counts),
                                  .block_boxes = view_of(bounds_.block_boxes),
                                  .packed = view_of(bounds_.in_sections),
                                  .begins = view_of(bounds_.section_begins),
                                  .ends = view_of(bounds_.section_ends)});
    }

    /// Finds the corners of triangles around which nothing folds.
    void find_flat_corners(const Scene& scene) {
        const stages::SheetBodies bodies = bodies_of(scene);
        bounds_.flat.resize(count_of(bounds_.vertices));
        bounds_.flat_corners.resize(count_of(bounds_.triangles));
        executor_.for_each(count_of(bounds_.vertices),
                           stages::FindFlatStars{bodies, view_of(bounds_.flat)});
        executor_.for_each(
            count_of(bounds_.triangles),
            stages::PlaceFlatCorners{bodies, view_of(bounds_.flat), view_of(bounds_.flat_corners)});
    }

    /// Finds the features of triangles that may meet, and which of them are contacts.
    void meet(const Scene& scene, const Buffer<Pair>& pairs) {
        executor_.emit(
            ListId::feature_triangles, count_of(search_.triangles),
            stages::FindFeatures{view_of(search_.pairs), interleaved(view_of(bounds_.triangles)),
                                 view_of(search_.triangles)},
            features_.triangles);
        executor_.emit(ListId::open_triangles, count_of(features_.triangles),
                       stages::IsOpen{view_of(features_.triangles)}, features_.open);
        executor_.for_each(count_of(features_.open),
                           stages::FindOpenFeatures{.bodies = bodies_of(scene),
                                                    .pairs = view_of(search_.pairs),
                                                    .open = view_of(features_.open),
                                                    .triangles = view_of(features_.triangles)});
        executor_.emit(ListId::features, count_of(features_.triangles),
                       stages::ListFeatures{.bodies = bodies_of(scene),
                                            .pairs = view_of(search_.pairs),
                                            .triangles = view_of(features_.triangles),
                                            .sheet_key = now_.sheet_key},
                       features_.features, sort_.keys, sort_.values);
        const stages::SheetMemory memory{.links = view_of(search_.links),
                                         .keys = view_of(last_.keys),
                                         .records = view_of(last_.records),
                                         .sheet_key = last_.sheet_key};
        executor_.beside([&] { judge(scene, pairs, memory); });
        order_features(pairs);
        executor_.join();
        const Count kept = tools_.list(
            ListId::sheet_contacts, count_of(features_.features),
            stages::IsContact{view_of(features_.judgements), view_of(features_.order)},
            features_.kept);
        now_.keys.resize(kept);
        now_.records.resize(kept);
        features_.contacts.resize(kept);
        executor_.for_each(kept,
                           stages::FillSheetContact{.bodies = bodies_of(scene),
                                                    .pairs = view_of(search_.pairs),
                                                    .features = view_of(features_.features),
                                                    .meetings = view_of(features_.meetings),
                                                    .judgements = view_of(features_.judgements),
                                                    .ages = view_of(features_.ages),
                                                    .kept = view_of(features_.kept),
                                                    .sheet_key = now_.sheet_key,
                                                    .keys = view_of(now_.keys),
                                                    .records = view_of(now_.records),
                                                    .deepest = view_of(now_.deepest),
                                                    .contacts = view_of(features_.contacts)});
    }

    /// Sorts the features into the order of contacts, and makes room for the contacts' records.
    void order_features(const Buffer<Pair>& pairs) {
        const Count count = count_of(features_.features);
        const int pair_bits = std::bit_width(static_cast<std::uint32_t>(pairs.size()));
        tools_.sort(pair_bits + static_cast<int>(SheetKey::kind_bits + now_.sheet_key.bits),
                    sort_.keys, sort_.values, features_.keys, features_.order);
        executor_.for_each(count,
                           stages::OrderTies{view_of(features_.features), view_of(features_.keys),
                                             view_of(features_.order)});
        // The keys after the last contact's key keep this value: the next step searches the whole
        // list.
        executor_.assign(now_.keys, static_cast<std::uint32_t>(features_.features.size()),
                         ~std::uint64_t{0});
        now_.deepest.resize(count_of(pairs));
        executor_.for_each(count_of(pairs), stages::Clear{view_of(now_.deepest)});
    }

    /// Finds which features are contacts, and for how long.
    void judge(const Scene& scene, const Buffer<Pair>& pairs, const stages::SheetMemory& memory) {
        const Count count = count_of(features_.features);
        features_.meetings.resize(count);
        features_.judgements.resize(count);
        executor_.emit(ListId::undecided_features, count,
                       stages::MeetFeatures<false>{.bodies = bodies_of(scene),
                                                   .pairs = view_of(pairs),
                                                   .sheet_pairs = view_of(search_.pairs),
                                                   .features = view_of(features_.features),
                                                   .undecided = {},
                                                   .memory = memory,
                                                   .meetings = view_of(features_.meetings),
                                                   .judgements = view_of(features_.judgements)},
                       features_.undecided);
        executor_.for_each(count_of(features_.undecided),
                           stages::MeetFeatures<true>{.bodies = bodies_of(scene),
                                                      .pairs = view_of(pairs),
                                                      .sheet_pairs = view_of(search_.pairs),
                                                      .features = view_of(features_.features),
                                                      .undecided = view_of(features_.undecided),
                                                      .memory = memory,
                                                      .meetings = view_of(features_.meetings),
                                                      .judgements = view_of(features_.judgements)});
        features_.ages.resize(count);
        executor_.for_each(
            count, stages::FindAge{view_of(features_.features), memory, view_of(features_.ages)});
    }

    stages::SheetBodies bodies_of(const Scene& scene) {
        return {.views = scene.bodies,
                .vertex_offsets = view_of(places_.vertex_offsets),
                .block_offsets = view_of(places_.block_offsets),
                .vertices = view_of(bounds_.vertices)};
    }

    StepTools<E, T>& tools_;
    E& executor_;
    bool is_bound_ = false;      ///< bound_all() was called in this step
    std::uint64_t planned_ = 0;  ///< revision of the plan whose bodies are placed, all of them
    SheetRecords<E> now_, last_;
    SheetPlaces<E> places_;
    SheetBounds<E> bounds_;
    SheetSearchLists<E> search_;
    SheetFeatureLists<E> features_;
    SortScratch<E> sort_;
};

}  // namespace pierce
