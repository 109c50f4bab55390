#pragma once

#include <bit>

#include "core/device/atomics.hpp"
#include "core/device/order_ties.hpp"
#include "core/device/view.hpp"
#include "core/execute/stage_traits.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/contact_keys.hpp"
#include "core/step/common/count.hpp"
#include "core/step/common/records.hpp"
#include "core/step/sheets/sheet_meetings.hpp"
#include "pierce/constants.hpp"
#include "pierce/contact.hpp"
#include "pierce/min_max.hpp"

/// Sheets, last part: the list of their contacts, in order, what is remembered of each, and what
/// they add up to.
namespace pierce::stages {

/// Per two features in their order: the first of those with the same key brings them into the order
/// of their other features.
struct OrderTies {
    View<const FeaturePair> features;
    View<const std::uint64_t> keys;
    View<std::uint32_t> order;

    PIERCE_HD void operator()(std::uint32_t first) const {
        // Features of one key have different other features; the places only make sure of one
        // order.
        order_ties(keys, order, first, [&](std::uint32_t a, std::uint32_t b) {
            const std::uint32_t x = features[a].other, y = features[b].other;
            return x != y ? x < y : a < b;
        });
    }
};

/// Per two features: for how many steps they have been a contact. Reads the memory of the last
/// step.
struct FindAge {
    View<const FeaturePair> features;
    SheetMemory memory;
    View<std::uint32_t> ages;

    PIERCE_HD void operator()(std::uint32_t i) const {
        ages[i] = memory.age(read_whole(features[i]));
    }
};

/// True for features that are a contact; lists those in their order.
struct IsContact {
    View<const Judgement> judgements;
    View<const std::uint32_t> order;

    PIERCE_HD bool operator()(std::uint32_t place) const {
        return judgements[order[place]].verdict == Verdict::contact;
    }
    PIERCE_HD std::uint32_t listed(std::uint32_t place) const { return order[place]; }
};

/// What a contact adds to the sums, by its record. A pair whose rays have found contacts, too, is
/// counted with those.
struct CountSheetContact {
    View<const std::uint64_t> keys;
    View<const SheetRecord> records;
    SheetKey sheet_key;
    View<const std::uint64_t> ray_keys;  ///< of contacts that rays have found

    PIERCE_HD ContactSums operator()(std::uint32_t i) const {
        const SheetRecord r = records[i];
        const std::uint32_t pair = sheet_key.pair_of(keys[i]);
        const bool first = (i == 0 || sheet_key.pair_of(keys[i - 1]) != pair) &&
                           !has_ray_contact(pair);
        const double depth = max_of(-r.distance, 0.0);
        return {.touching_pairs = first,
                .edges = r.is_edge,
                .reprojected = 0,
                .predictions_true = 0,
                .self = r.is_self,
                .crossings = r.found == Found::crossing,
                .remembered = r.found == Found::remembered,
                .tangled = r.found == Found::tangled,
                .depth = depth,
                .depth_max = depth};
    }

private:
    PIERCE_HD bool has_ray_contact(std::uint32_t pair) const {
        const std::uint32_t place = first_not_less(ray_keys, ContactKey::first_of(pair));
        return place < ray_keys.size && ContactKey::pair_of(ray_keys[place]) == pair;
    }
};

/// Per contact of a sheet: everything in it, and what the next step will know of it.
struct FillSheetContact {
    SheetBodies bodies;
    View<const SheetPair> pairs;
    View<const FeaturePair> features;
    View<const SheetMeeting> meetings;
    View<const Judgement> judgements;
    View<const std::uint32_t> ages;
    View<const std::uint32_t> kept;  ///< features, in their order
    SheetKey sheet_key;
    View<std::uint64_t> keys;
    View<SheetRecord> records;
    View<std::uint32_t> deepest;  ///< per pair
    View<Contact> contacts;

    static constexpr std::uint32_t ahead = 8;  ///< items

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t feature = kept[i], later = kept[min_of(i + ahead, kept.size - 1)];
        read_ahead(features[later]);
        read_ahead(meetings[later]);
        const FeaturePair f = read_whole(features[feature]);
        const SheetMeeting m = read_whole(meetings[feature]);
        const Judgement judgement = judgements[feature];
        const SheetPair pair = read_whole(pairs[f.pair]);
        const bool from_b = f.kind == FeatureKind::vertex_of_b ||
                            f.kind == FeatureKind::piercing_edge_of_b;
        const SheetBody source = bodies[from_b ? pair.second : pair.first],
                        target = bodies[from_b ? pair.first : pair.second];
        keys[i] = sheet_key.of(f.pair, f.kind, f.item);
        const bool is_vertex = f.kind == FeatureKind::vertex_of_a ||
                               f.kind == FeatureKind::vertex_of_b;
        std::uint32_t vertex = f.item, edge_end = no_vertex, triangle = f.other;
        double weight[3];
        Vec3d p, corner[3];
        if (is_vertex) {
            p = bodies.vertex(f.vertex[0]).end;
            for (int k = 0; k < 3; ++k) corner[k] = bodies.vertex(f.vertex[k + 1]).end;
        } else {
            const Edge& edge = source.mesh.edges[f.item];
            vertex = edge.vertex[0];
            edge_end = edge.vertex[1];
            p = (1 - m.along) * source.vertex(vertex).end + m.along * source.vertex(edge_end).end;
        }
        if (f.kind == FeatureKind::edges) {
            const Edge& edge = target.mesh.edges[f.other];
            triangle = edge.triangle[0];
            // A triangle may name a vertex twice: each end of the edge is one of its corners.
            const Triangle& t = target.mesh.triangles[triangle];
            const int first = corner_of(t, edge.vertex[0]), second = corner_of(t, edge.vertex[1]);
            for (int k = 0; k < 3; ++k)
                weight[k] = k == first ? 1 - m.weight[0] : k == second ? m.weight[0] : 0.0;
        } else {
            for (int k = 0; k < 3; ++k) weight[k] = m.weight_of(k);
        }
        if (!is_vertex)
            for (int k = 0; k < 3; ++k)
                corner[k] = target.vertex(target.mesh.triangles[triangle].vertex[k]).end;
        Vec3d q;
        for (int k = 0; k < 3; ++k) q += weight[k] * corner[k];
        // Every member is named, so that none is written twice.
        const Contact c{
            .a = pair.ids[0],
            .b = pair.ids[1],
            .source = from_b ? Side::b : Side::a,
            .grazing = false,
            .found = judgement.found,
            .reprojected = false,
            .of_sheet = true,
            .unknown_side = judgement.unknown,
            .padding_a = 0,
            .vertex = vertex,
            .edge_end = edge_end,
            .edge = is_vertex ? 0 : f.item,
            .chord = 0,
            .other_edge = f.kind == FeatureKind::edges ? f.other : 0,
            .triangle = triangle,
            .age = ages[feature],
            .padding_b = 0,
            .along = is_vertex ? 0 : m.along,
            .time = m.time,
            .distance = m.distance,
            .barycentric = {weight[0], weight[1], weight[2]},
            .point_a = from_b ? q : p,
            .point_b = from_b ? p : q,
            .normal = from_b ? m.out : -m.out,
            .face_normal = normalized(cross(corner[1] - corner[0], corner[2] - corner[0])),
            .padding_c = 0};
        write_side_by_side(contacts.data, i, [&](Contact& to) { to = c; });
        SheetRecord record;
        record.other = f.other;
        record.age = c.age;
        // What touches has come from somewhere, too.
        const bool keeps_side = !(m.distance > 0) &&
                                -m.distance <= target.view.memory + pair.thickness;
        record.side = keeps_side ? judgement.side : std::int8_t{0};
        record.found = judgement.found;
        record.is_self = pair.is_self();
        record.is_edge = !is_vertex;
        record.distance = m.distance;
        records[i] = record;
        if (record.side != 0)
            atomic_max(deepest[f.pair],
                       std::bit_cast<std::uint32_t>(max_of(round_up(-m.distance), smallest_float)));
    }
};

}  // namespace pierce::stages
