#pragma once

#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/contact_keys.hpp"
#include "core/step/common/records.hpp"
#include "core/step/sheets/sheet_features.hpp"
#include "pierce/contact.hpp"

/// What steps remember of sheets' contacts: their ages, and the sides of vertices that are through.
namespace pierce::stages {

/// Last step's records, by pair of this step.
struct SheetMemory {
    View<const std::uint32_t> links;  ///< per pair, which of the last step's pairs it was, or
                                      ///< no_pair
    View<const std::uint64_t> keys;
    View<const SheetRecord> records;
    SheetKey sheet_key;

    /// The side of a triangle that a vertex belongs to; 0 if nothing is remembered. If it is
    /// remembered of several triangles, as in a fold, the one counts that shares most corners with
    /// this one, and of these the one that the vertex was nearest to.
    PIERCE_HD std::int32_t side(const FeaturePair& f, View<const Triangle> triangles) const {
        std::int32_t side = 0;
        int most = 0;
        double nearest = 0;
        each(f.pair, f.kind, f.item, [&](const SheetRecord& record) {
            if (record.side == 0) return false;
            if (record.other == f.other) {
                side = record.side;
                return true;
            }
            const int shared = shared_corners(triangles[record.other], triangles[f.other]);
            const double distance = record.distance < 0 ? -record.distance : record.distance;
            if (shared > most || (shared > 0 && shared == most && distance < nearest)) {
                side = record.side;
                most = shared;
                nearest = distance;
            }
            return false;
        });
        return side;
    }

    /// The side of one edge that another one belongs to, if they touched: +1 on that of the cross
    /// product of both; 0 if nothing is remembered.
    PIERCE_HD std::int32_t side_of_edges(const FeaturePair& f) const {
        std::int32_t side = 0;
        each(f.pair, f.kind, f.item, [&](const SheetRecord& record) {
            if (record.other == f.other) side = record.side;
            return side != 0;
        });
        return side;
    }

    /// For how many steps in a row the features have been a contact.
    PIERCE_HD std::uint32_t age(const FeaturePair& f) const {
        std::uint32_t age = 0;
        each(f.pair, f.kind, f.item, [&](const SheetRecord& record) {
            if (record.other == f.other) age = record.age + 1;
            return age != 0;
        });
        return age;
    }

    /// True if the side of a triangle that a vertex belongs to is remembered.
    PIERCE_HD bool knows(std::uint32_t pair, FeatureKind kind, std::uint32_t vertex,
                         std::uint32_t triangle, View<const Triangle> triangles) const {
        return side({pair, vertex, triangle, kind}, triangles) != 0;
    }

private:
    PIERCE_HD static int shared_corners(const Triangle& a, const Triangle& b) {
        return has_vertex(a, b.vertex[0]) + has_vertex(a, b.vertex[1]) + has_vertex(a, b.vertex[2]);
    }

    /// Calls see(record) for the feature's records until `see` returns true.
    template <class See>
    PIERCE_HD void each(std::uint32_t pair, FeatureKind kind, std::uint32_t item,
                        const See& see) const {
        if (keys.size == 0 || links[pair] == no_pair) return;
        const std::uint64_t key = sheet_key.of(links[pair], kind, item);
        // Searches by quarters: a GPU reads three keys at once and waits as long as for one.
        std::uint32_t low = 0, high = keys.size;
        while (low < high) {
            const std::uint32_t quarter = (high - low) / 4,
                                at[3] = {low + quarter, low + 2 * quarter, low + 3 * quarter};
            const bool before[3] = {keys[at[0]] < key, keys[at[1]] < key, keys[at[2]] < key};
            if (!before[2]) high = !before[0] ? at[0] : !before[1] ? at[1] : at[2];
            if (before[0]) low = before[2] ? at[2] + 1 : before[1] ? at[1] + 1 : at[0] + 1;
        }
        for (; low < keys.size && keys[low] == key; ++low)
            if (see(records[low])) return;
    }
};

}  // namespace pierce::stages
