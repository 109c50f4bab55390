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
#include "core/step/sheets/sheet_contacts.hpp"

namespace pierce {

/// Finds the contacts of sheets with themselves and others over the motion of a step, and remembers their sides.
template <Executor E, Tracer<E> T>
class Sheets {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    explicit Sheets(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Where all bodies are over the step, beside what comes until find(), which need not find it out then.
    void bound_all(const Scene& scene) {
        // The first step of a plan is one whose counts the host knows, so that they hold for the others.
        if (planned_ != scene.plan->revision) {
            executor_.assign(wanted_, scene.bodies.size, 1u);
            place(scene);
            planned_ = scene.plan->revision;
        }
        executor_.beside([&] { bound(scene); });
        is_bound_ = true;
    }

    /// All contacts of sheets, sorted by pair, kind and feature. `links`: which of last step's pairs each pair was.
    void find(const Scene& scene, const Buffer<Pair>& pairs, View<const std::uint32_t> links) {
        bits_ = scene.plan->feature_bits;
        search(scene, pairs, links);
        meet(scene, pairs);
    }

    /// What the last step has left for the next one.
    void save(StepMemory& m) const {
        m.sheet_bits = bits_;
        m.sheet_keys = executor_.download(keys_);
        m.sheet_records = executor_.download(records_);
        m.deepest = executor_.download(deepest_);
    }
    void restore(const StepMemory& m) {
        bits_ = m.sheet_bits;
        executor_.upload(std::span(m.sheet_keys), keys_);
        executor_.upload(std::span(m.sheet_records), records_);
        executor_.upload(std::span(m.deepest), deepest_);
    }

    /// There are no sheets in this step.
    void forget() {
        contacts_.clear();
        keys_.clear();
        records_.clear();
        deepest_.clear();
    }

    const Buffer<Contact>& contacts() const { return contacts_; }
    /// What its contacts add up to.
    void add_up(typename E::template Sum<stages::ContactSums>& sums) {
        executor_.reduce("count_sheet_contacts", count_of(contacts_),
                         stages::CountSheetContact{view_of(keys_), view_of(records_), bits_}, sums);
    }
    std::uint32_t triangle_pairs() const { return executor_.number(count_of(triangles_)); }
    std::uint32_t feature_pairs() const { return executor_.number(count_of(features_)); }

    /// This step's memory becomes last step's.
    void recall() {
        std::swap(keys_, last_keys_);
        std::swap(bits_, last_bits_);
        std::swap(records_, last_records_);
        std::swap(deepest_, last_deepest_);
    }

private:
    /// Triangles that may meet.
    void search(const Scene& scene, const Buffer<Pair>& pairs, View<const std::uint32_t> links) {
        const Count pair_count = count_of(pairs);
        const std::uint32_t bodies = scene.bodies.size;
        sheet_pairs_.resize(pair_count);
        links_.resize(pair_count);
        if (!is_bound_) executor_.assign(wanted_, bodies, 0u);
        executor_.for_each("plan_sheet_pair", pair_count,
                           stages::PlanSheetPair{.bodies = scene.bodies,
                                                 .ids = scene.ids,
                                                 .pairs = view_of(pairs),
                                                 .links = links,
                                                 .forgets = scene.forgets_sides,
                                                 .last_deepest = view_of(last_deepest_),
                                                 .sheet_pairs = view_of(sheet_pairs_),
                                                 .sheet_links = view_of(links_),
                                                 .wanted = view_of(wanted_)});
        if (!is_bound_) {
            place(scene);
            bound(scene);
        }
        executor_.emit("find_rows", pair_count,
                       stages::FindRows{view_of(sheet_pairs_), view_of(section_offsets_), view_of(section_counts_)},
                       section_rows_);
        executor_.emit("find_sections", count_of(section_rows_),
                       stages::FindSections{view_of(sheet_pairs_), view_of(section_rows_), view_of(section_offsets_),
                                            view_of(section_counts_)},
                       sections_);
        if (is_bound_) executor_.join();
        is_bound_ = false;
        executor_.beside([&] { find_flat_corners(scene); });

        executor_.emit("find_blocks", constants::group_size * count_of(sections_),
                       stages::FindParts{view_of(sheet_pairs_),
                                         view_of(sections_),
                                         {view_of(section_begins_), view_of(section_ends_)},
                                         view_of(block_boxes_),
                                         view_of(in_sections_),
                                         view_of(block_slabs_)},
                       blocks_);
        executor_.emit("find_groups", constants::group_size * count_of(blocks_),
                       stages::FindParts{view_of(sheet_pairs_),
                                         view_of(blocks_),
                                         {},
                                         view_of(group_boxes_),
                                         view_of(in_blocks_),
                                         view_of(group_slabs_)},
                       groups_);
        executor_.emit("find_triangles", stages::FindTriangles::per_group * count_of(groups_),
                       stages::FindTriangles{view_of(sheet_pairs_), view_of(groups_), view_of(boxes_), view_of(in_groups_)},
                       near_);
        executor_.join();
        executor_.emit("cull_triangles", count_of(near_),
                       stages::CullTriangles{view_of(sheet_pairs_), view_of(near_), interleaved(view_of(drifting_)),
                                             view_of(flat_corners_)},
                       triangles_);
    }

    /// Where the vertices, blocks and sections of wanted bodies are among those of all.
    void place(const Scene& scene) {
        const std::uint32_t bodies = scene.bodies.size;
        section_counts_.resize(bodies);
        block_counts_.resize(bodies);
        counts_.resize(bodies);
        executor_.for_each("count_sheet_items", bodies,
                           stages::CountSheetItems{scene.bodies, view_of(wanted_), view_of(section_counts_),
                                                   view_of(block_counts_), view_of(counts_)});
        vertices_.resize(tools_.place("vertex_scan", counts_, vertex_offsets_));
        section_begins_.resize(tools_.place("sheet_section_scan", section_counts_, section_offsets_));
        block_boxes_.resize(tools_.place("sheet_block_scan", block_counts_, block_offsets_));
    }

    /// Where they are over the step: vertices, triangles, and bounds of those.
    void bound(const Scene& scene) {
        executor_.for_each("move_vertices", count_of(vertices_),
                           stages::MoveVertices{scene.bodies, view_of(vertex_offsets_), view_of(vertices_)});
        const Count sections = count_of(section_begins_), blocks = count_of(block_boxes_);
        const Count groups = constants::group_size * blocks, triangles = constants::group_size * groups;
        drifting_.resize(triangles);
        boxes_.resize(triangles);
        in_groups_.resize(groups);
        group_slabs_.resize(groups);
        group_boxes_.resize(groups);
        executor_.for_each("place_groups", executor_.in_sixteens(groups),
                           stages::PlaceGroups{bodies_of(scene), interleaved(view_of(drifting_)), view_of(boxes_),
                                               view_of(in_groups_), view_of(group_slabs_), view_of(group_boxes_)});
        in_blocks_.resize(blocks);
        block_slabs_.resize(blocks);
        executor_.for_each("bound_blocks", executor_.in_sixteens(blocks),
                           stages::BoundBlocks{view_of(group_slabs_), view_of(group_boxes_), view_of(in_blocks_),
                                               view_of(block_slabs_), view_of(block_boxes_)});
        in_sections_.resize(sections);
        section_ends_.resize(sections);
        executor_.for_each("bound_sections", executor_.in_sixteens(sections),
                           stages::BoundSections{view_of(section_offsets_), view_of(block_offsets_), view_of(block_counts_),
                                                 view_of(block_boxes_), view_of(in_sections_), view_of(section_begins_),
                                                 view_of(section_ends_)});
    }

    /// Corners of triangles around which nothing folds.
    void find_flat_corners(const Scene& scene) {
        const stages::SheetBodies bodies = bodies_of(scene);
        flat_.resize(count_of(vertices_));
        flat_corners_.resize(count_of(drifting_));
        executor_.for_each("find_flat_stars", count_of(vertices_), stages::FindFlatStars{bodies, view_of(flat_)});
        executor_.for_each("place_flat_corners", count_of(drifting_),
                           stages::PlaceFlatCorners{bodies, view_of(flat_), view_of(flat_corners_)});
    }

    /// Their features, and which of those are contacts.
    void meet(const Scene& scene, const Buffer<Pair>& pairs) {
        executor_.emit("find_features", count_of(triangles_),
                       stages::FindFeatures{view_of(sheet_pairs_), interleaved(view_of(drifting_)), view_of(triangles_)},
                       meeting_triangles_);
        executor_.emit("open_list", count_of(meeting_triangles_), stages::IsOpen{view_of(meeting_triangles_)}, open_);
        executor_.for_each(
            "find_open_features", count_of(open_),
            stages::FindOpenFeatures{bodies_of(scene), view_of(sheet_pairs_), view_of(open_), view_of(meeting_triangles_)});
        executor_.emit("list_features", count_of(meeting_triangles_),
                       stages::ListFeatures{bodies_of(scene), view_of(sheet_pairs_), view_of(meeting_triangles_), bits_},
                       features_, unsorted_keys_, unsorted_);
        const stages::SheetMemory memory{view_of(links_), view_of(last_keys_), view_of(last_records_), last_bits_};
        executor_.beside([&] { judge(scene, pairs, memory); });
        order_features(pairs);
        executor_.join();
        const Count kept = tools_.list("sheet_contact_list", count_of(features_),
                                       stages::IsContact{view_of(judgements_), view_of(order_)}, kept_);
        keys_.resize(kept);
        records_.resize(kept);
        contacts_.resize(kept);
        executor_.for_each(
            "fill_sheet_contact", kept,
            stages::FillSheetContact{bodies_of(scene), view_of(sheet_pairs_), view_of(features_), view_of(meetings_),
                                     view_of(judgements_), view_of(ages_), view_of(kept_), bits_, view_of(keys_),
                                     view_of(records_), view_of(deepest_), view_of(contacts_)});
    }

    /// The order of features, as that of the contacts among them, and room for what is remembered of those.
    void order_features(const Buffer<Pair>& pairs) {
        const Count count = count_of(features_);
        const int pair_bits = std::bit_width(static_cast<std::uint32_t>(pairs.size()));
        tools_.sort("feature_sort", pair_bits + 3 + static_cast<int>(bits_), unsorted_keys_, unsorted_, feature_keys_,
                    order_);
        executor_.for_each("order_ties", count,
                           stages::OrderTies{view_of(features_), view_of(feature_keys_), view_of(order_)});
        // What is past the last contact's stays: the next step searches in all of it.
        executor_.assign(keys_, static_cast<std::uint32_t>(features_.size()), ~std::uint64_t{0});
        deepest_.resize(count_of(pairs));
        executor_.for_each("clear_deepest", count_of(pairs), stages::Clear{view_of(deepest_)});
    }

    /// Which features are contacts, and for how long.
    void judge(const Scene& scene, const Buffer<Pair>& pairs, const stages::SheetMemory& memory) {
        const Count count = count_of(features_);
        meetings_.resize(count);
        judgements_.resize(count);
        executor_.emit("meet_features", count,
                       stages::MeetFeatures<false>{bodies_of(scene),
                                                   view_of(pairs),
                                                   view_of(sheet_pairs_),
                                                   view_of(features_),
                                                   {},
                                                   memory,
                                                   view_of(meetings_),
                                                   view_of(judgements_)},
                       undecided_);
        executor_.for_each(
            "search_meetings", count_of(undecided_),
            stages::MeetFeatures<true>{bodies_of(scene), view_of(pairs), view_of(sheet_pairs_), view_of(features_),
                                       view_of(undecided_), memory, view_of(meetings_), view_of(judgements_)});
        ages_.resize(count);
        executor_.for_each("find_age", count, stages::FindAge{view_of(features_), memory, view_of(ages_)});
    }

    stages::SheetBodies bodies_of(const Scene& scene) {
        return {scene.bodies, view_of(vertex_offsets_), view_of(block_offsets_), view_of(vertices_)};
    }

    StepTools<E, T>& tools_;
    E& executor_;
    bool is_bound_ = false;      ///< bound_all() was called in this step
    std::uint64_t planned_ = 0;  ///< revision of the plan whose bodies are placed, all of them
    Buffer<stages::MovingVertex> vertices_;
    Buffer<stages::SheetPair> sheet_pairs_;
    Buffer<std::uint32_t> links_;  ///< per pair, which of last step's it was; none if sheets forget
    Buffer<std::uint32_t> wanted_, section_counts_, section_offsets_, section_begins_, section_ends_, block_counts_,
        block_offsets_, vertex_offsets_, flat_;
    Buffer<std::uint32_t> counts_, open_, undecided_, kept_, unsorted_, order_, ages_;
    Buffer<std::uint64_t> unsorted_keys_, feature_keys_;
    Buffer<stages::QuickBox> boxes_, group_boxes_, block_boxes_;
    Buffer<stages::GridBoxes> in_groups_, in_blocks_, in_sections_;
    Buffer<stages::DriftingTriangle> drifting_;
    Buffer<stages::FlatCorners> flat_corners_;
    Buffer<stages::Slab> group_slabs_, block_slabs_;
    Buffer<stages::SectionRow> section_rows_;
    Buffer<stages::ClosePair> sections_, blocks_, groups_;
    Buffer<stages::NearTriangles> near_;
    Buffer<stages::TrianglePair> triangles_;
    Buffer<stages::MeetingTriangles> meeting_triangles_;
    Buffer<stages::FeaturePair> features_;
    Buffer<stages::SheetMeeting> meetings_;
    Buffer<stages::Judgement> judgements_;
    Buffer<Contact> contacts_;

    // What steps remember, and last step's: per contact in the order of the contacts, and per pair.
    std::uint32_t bits_ = 0, last_bits_ = 0;  ///< of the keys
    Buffer<std::uint64_t> keys_, last_keys_;
    Buffer<SheetRecord> records_, last_records_;
    Buffer<std::uint32_t> deepest_, last_deepest_;
};

}  // namespace pierce
