#pragma once

#include <utility>

#include "pierce/core/scene.hpp"
#include "pierce/core/stages/sheet_contacts.hpp"
#include "pierce/core/step_tools.hpp"

namespace pierce {

/// Finds the contacts of sheets with themselves and others over the motion of a step, and remembers their sides.
template <Executor E, Tracer<E> T>
class Sheets {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    explicit Sheets(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// All contacts of sheets, sorted by pair, kind and feature. `links`: which of last step's pairs each pair was.
    void find(const Scene& scene, const Buffer<Pair>& pairs, View<const std::uint32_t> links) {
        search(scene, pairs, links);
        meet(scene, pairs, links);
    }

    const Buffer<Contact>& contacts() const { return contacts_; }
    std::uint32_t triangle_pairs() const { return executor_.number(count_of(triangles_)); }
    std::uint32_t feature_pairs() const { return executor_.number(count_of(features_)); }

    /// This step's memory becomes last step's.
    void recall() {
        std::swap(keys_, last_keys_);
        std::swap(records_, last_records_);
        std::swap(deepest_, last_deepest_);
    }

private:
    /// Triangles that may meet, then their features.
    void search(const Scene& scene, const Buffer<Pair>& pairs, View<const std::uint32_t> links) {
        const Count pair_count = count_of(pairs);
        sheet_pairs_.resize(pair_count);
        counts_.resize(pair_count);
        executor_.for_each("plan_sheet_pair", pair_count,
                           stages::PlanSheetPair{scene.bodies, view_of(pairs), links, view_of(last_deepest_),
                                                 view_of(sheet_pairs_), view_of(counts_)});
        executor_.assign(item_offsets_, static_cast<std::uint32_t>(pairs.size()), ~std::uint32_t{0});
        const Count all = tools_.place("sheet_triangle_scan", counts_, item_offsets_);
        const Count near = tools_.list(
            "near_triangles", all, stages::IsNearBody{scene.bodies, view_of(sheet_pairs_), view_of(item_offsets_)}, items_);
        counts_.resize(near);
        stages::FindTriangles query{
            scene.bodies, view_of(sheet_pairs_), view_of(item_offsets_), view_of(items_), view_of(counts_), {}, {}};
        tools_.update_searched(scene.bodies, pair_count, view_of(sheet_pairs_));
        tools_.tracer.overlaps(executor_, "count_triangles", scene.bodies, near, query);
        triangles_.resize(tools_.place("triangle_scan", counts_, offsets_));
        if (!triangles_.empty()) {
            query.offsets = view_of(offsets_);
            query.found = view_of(triangles_);
            tools_.tracer.overlaps(executor_, "list_triangles", scene.bodies, near, query);
        }
        const Count met = count_of(triangles_);
        masks_.resize(met);
        counts_.resize(met);
        executor_.for_each("mask_features", met,
                           stages::MaskFeatures{scene.bodies, view_of(sheet_pairs_), view_of(triangles_), view_of(masks_),
                                                view_of(counts_)});
        features_.resize(tools_.place("feature_scan", counts_, offsets_));
        executor_.for_each("list_features", met,
                           stages::ListFeatures{scene.bodies, view_of(sheet_pairs_), view_of(triangles_), view_of(masks_),
                                                view_of(offsets_), view_of(features_)});
    }

    /// Which of them are contacts.
    void meet(const Scene& scene, const Buffer<Pair>& pairs, View<const std::uint32_t> links) {
        const stages::SheetMemory memory{links, view_of(last_keys_), view_of(last_records_)};
        const Count count = count_of(features_);
        meetings_.resize(count);
        keep_.resize(count);
        executor_.for_each("meet_features", count,
                           stages::MeetFeatures{scene.bodies, view_of(pairs), view_of(sheet_pairs_), view_of(features_),
                                                memory, view_of(meetings_), view_of(keep_)});
        const Count kept = tools_.list("sheet_contact_list", count, stages::IsInside{view_of(keep_)}, kept_);
        keys_.resize(kept);
        order_.resize(kept);
        records_.resize(kept);
        contacts_.resize(kept);
        deepest_.resize(count_of(pairs));
        executor_.for_each("clear_deepest", count_of(pairs), stages::Clear{view_of(deepest_)});
        executor_.for_each("key_sheet_contacts", kept,
                           stages::KeySheetContacts{view_of(features_), view_of(kept_), view_of(keys_), view_of(order_)});
        executor_.sort("sheet_sort", kept, 32, view_of(keys_), view_of(order_));
        executor_.for_each("key_by_feature", kept,
                           stages::KeyByFeature{view_of(features_), view_of(order_), view_of(keys_)});
        executor_.sort("sheet_sort", kept, 64, view_of(keys_), view_of(order_));
        executor_.for_each(
            "fill_sheet_contact", kept,
            stages::FillSheetContact{scene.bodies, scene.ids, view_of(pairs), view_of(features_), view_of(meetings_),
                                     view_of(order_), memory, view_of(records_), view_of(deepest_), view_of(contacts_)});
    }

    StepTools<E, T>& tools_;
    E& executor_;
    Buffer<stages::SheetPair> sheet_pairs_;
    Buffer<std::uint32_t> counts_, offsets_, item_offsets_, items_, masks_, keep_, kept_, order_;
    Buffer<stages::TrianglePair> triangles_;
    Buffer<stages::FeaturePair> features_;
    Buffer<stages::SheetMeeting> meetings_;
    Buffer<Contact> contacts_;

    // What steps remember, and last step's: per contact in the order of the contacts, and per pair.
    Buffer<std::uint64_t> keys_, last_keys_;
    Buffer<stages::SheetRecord> records_, last_records_;
    Buffer<std::uint32_t> deepest_, last_deepest_;
};

}  // namespace pierce
