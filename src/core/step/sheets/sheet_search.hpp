#pragma once

#include <bit>

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/bits.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/sheets/four_heights.hpp"
#include "core/step/sheets/group_heights.hpp"
#include "pierce/min_max.hpp"

/// Sheets, first part: which triangles of a sheet and another body, or of a sheet alone, may meet
/// during the step or come closer than the thickness. Boxes around triangles, groups of them and
/// blocks of groups, over the whole step, are compared sixteen at a time, from the largest to the
/// smallest, section by section (sixteen blocks). There is no tree, because all boxes change in
/// every step. No triangles that meet are left out.
namespace pierce::stages {

/// How a pair with a sheet is searched.
struct alignas(16) SheetPair {
    std::uint32_t first = 0, second = 0;  ///< bodies: the pair's a and b
    bool searches = false;                ///< a sheet is part of it
    bool is_solid[2] = {};                ///< the first, the second
    bool was_through = false;  ///< the last step remembered sides: of what touches or is through
    std::uint8_t padding[4] = {};
    double thickness = 0;  ///< [length]
    double margin = 0;     ///< [length] vertices this close to triangles matter; more than the
                           ///< thickness if some vertices are through: as deep as they were, and as
                           ///< far as the bodies have come since
    float quick_thickness = 0, quick_margin = 0;  ///< the same in float32, not less
    std::uint32_t more_padding[2] = {};
    BodyId ids[2];

    PIERCE_HD bool is_self() const { return first == second; }
};

/// Per pair: how it is searched, and which of last step's pairs it was, as far as sheets remember.
/// Reads how deep vertices were on the wrong side in the last step. Marks the bodies of pairs with
/// a sheet.
struct PlanSheetPair {
    View<const BodyView> bodies;
    View<const BodyId> ids;
    View<const Pair> pairs;
    View<const std::uint32_t> links;
    View<const std::uint32_t> forgets;  ///< Scene::forgets_sides; the stage reads it, because a
                                        ///< captured step is repeated with either value
    View<const std::uint32_t> last_deepest;  ///< per pair of the last step, as the bits of a
                                             ///< float32
    View<SheetPair> sheet_pairs;
    View<std::uint32_t> sheet_links;
    View<std::uint32_t> wanted;  ///< per body

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Pair pair = pairs[i];
        const Collision &a = bodies[pair.a].collision, &b = bodies[pair.b].collision;
        SheetPair s;
        s.first = pair.a;
        s.second = pair.b;
        s.ids[0] = ids[pair.a];
        s.ids[1] = ids[pair.b];
        s.thickness = s.margin = max_of(a.thickness, b.thickness);
        s.is_solid[0] = bodies[pair.a].is_solid();
        s.is_solid[1] = bodies[pair.b].is_solid();
        const std::uint32_t link = forgets[0] != 0 ? no_pair : links[i];
        sheet_links[i] = link;
        if (link < last_deepest.size && last_deepest[link] != 0) {
            s.was_through = true;
            s.margin += static_cast<double>(std::bit_cast<float>(last_deepest[link])) +
                        bodies[pair.a].travel + bodies[pair.b].travel;
        }
        s.quick_thickness = round_up(s.thickness);
        s.quick_margin = round_up(s.margin);
        s.searches = pair.is_self() ? a.sheet && a.self == SelfCollision::on : a.sheet || b.sheet;
        sheet_pairs[i] = s;
        if (!s.searches) return;
        atomic_mark(wanted[pair.a]);
        atomic_mark(wanted[pair.b]);
    }
};

/// Per body, if it is wanted: how many sections and blocks of triangles it has, and how many
/// vertices.
struct CountSheetItems {
    View<const BodyView> bodies;
    View<const std::uint32_t> wanted;
    View<std::uint32_t> sections, blocks, vertices;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeshView& mesh = bodies[i].mesh;
        blocks[i] = wanted[i]
                        ? (mesh.triangles.size + triangles_per_block - 1) / triangles_per_block
                        : 0;
        sections[i] = (blocks[i] + constants::group_size - 1) / constants::group_size;
        vertices[i] = wanted[i] ? mesh.positions.size : 0;
    }
};

/// A section of a pair's first body.
struct SectionRow {
    std::uint32_t pair = 0;
    std::uint32_t section = 0;  ///< its place among all
};

/// Per pair, if it is searched: the first body's sections.
struct FindRows {
    View<const SheetPair> pairs;
    View<const std::uint32_t> section_offsets, sections;  ///< per body

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        return pairs[i].searches ? sections[pairs[i].first] : 0;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         SectionRow* rows) const {
        for (std::uint32_t k = 0; k < found; ++k)
            rows[place + k] = {i, section_offsets[pairs[i].first] + k};
    }
};

/// Two things of a pair's bodies that may be close: sections, blocks or groups, by their places
/// among all.
struct alignas(16) ClosePair {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;
    std::uint32_t padding = 0;
};

/// Per section of a pair's first body: the second body's sections. For a body against itself, each
/// two sections once.
struct FindSections {
    View<const SheetPair> pairs;
    View<const SectionRow> rows;
    View<const std::uint32_t> section_offsets, sections;  ///< per body

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const SheetPair& pair = pairs[rows[i].pair];
        return section_offsets[pair.second] + sections[pair.second] - begin(i);
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         ClosePair* close) const {
        for (std::uint32_t k = 0; k < found; ++k)
            write_whole(close[place + k], {rows[i].pair, rows[i].section, begin(i) + k});
    }

private:
    PIERCE_HD std::uint32_t begin(std::uint32_t i) const {
        const SheetPair& pair = pairs[rows[i].pair];
        return pair.is_self() ? rows[i].section : section_offsets[pair.second];
    }
};

/// Per part, a sixteenth of a section or block that is close to another one: the parts of the other
/// one that are near.
struct FindParts {
    View<const SheetPair> pairs;
    View<const ClosePair> close;  ///< sections, or blocks
    Parts parts;
    View<const QuickBox> boxes;    ///< of the parts
    View<const GridBoxes> packed;  ///< of the parts, per section or block
    View<const Slab> slabs;        ///< of the parts
    View<const QuickBox> wholes;   ///< the boxes of blocks; empty for sections

    /// A bit for each part of the other one.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const ClosePair c = read_whole(close[i / constants::group_size]);
        const std::uint32_t k = i % constants::group_size;
        std::uint32_t mask = 0;
        if (parts.has(c.first, k))
            mask = packed[c.second].near(
                read_whole(boxes[parts.begin(c.first) + k]).inflated(pairs[c.pair].quick_margin));
        // Within one section or block, each two parts once, and each part with itself.
        if (c.first == c.second) mask &= ~std::uint32_t{0} << k;
        return ask_bits(mask, i, *this);
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
#if defined(PIERCE_FOUR_LANES)
    /// What find() would find, without the parts that are not near the other one's box.
    void find_all(std::uint32_t begin, std::uint32_t end, std::uint32_t* found) const {
        for (std::uint32_t i = begin; i < end;) {
            const ClosePair& c = close[i / constants::group_size];
            std::uint32_t reach = ~std::uint32_t{0};
            if (wholes.size > 0)
                reach = packed[c.first].near(wholes[c.second].inflated(pairs[c.pair].quick_margin));
            for (std::uint32_t k = i % constants::group_size; k < constants::group_size && i < end;
                 ++k, ++i)
                found[i - begin] = reach >> k & 1 ? find(i) : 0;
        }
    }
#endif
    PIERCE_HD void write(std::uint32_t i, std::uint32_t mask, std::uint32_t place,
                         ClosePair* found) const {
        write_bits<asked_bits>(
            mask, i, place,
            [&](std::uint32_t part, std::uint32_t, std::uint32_t bit, std::uint32_t at) {
                const ClosePair c = read_whole(close[part / constants::group_size]);
                write_whole(found[at], {c.pair, parts.begin(c.first) + part % constants::group_size,
                                        parts.begin(c.second) + bit});
            });
    }

    /// For a part and one of the other's parts: 1 if they may be near.
    PIERCE_HD std::uint32_t operator()(std::uint32_t i, std::uint32_t bit) const {
        const ClosePair c = read_whole(close[i / constants::group_size]);
        const Slab mine = read_whole(slabs[parts.begin(c.first) + i % constants::group_size]);
        return !mine.is_apart(read_whole(slabs[parts.begin(c.second) + bit]),
                              pairs[c.pair].quick_margin);
    }
};

/// A triangle and those of a group that are near it.
struct alignas(16) NearInGroup {
    std::uint32_t pair = 0;
    std::uint32_t first = 0;   ///< its place
    std::uint32_t others = 0;  ///< where the group begins
    std::uint32_t mask = 0;    ///< a bit for each triangle of the group
};

/// What is known of groups as wholes.
struct Groups {
    View<const QuickBox> boxes;
    View<const Slab> slabs;
    View<const GroupHeights> heights;  ///< on the host only
};

/// Per two triangles of a near group, eight places apart: the triangles of the other group whose
/// boxes are near each of the two, if there are any.
struct FindTriangles {
    View<const SheetPair> pairs;
    View<const ClosePair> close;   ///< groups
    View<const QuickBox> boxes;    ///< of triangles
    View<const GridBoxes> packed;  ///< of triangles, per group
    Groups groups;
    Interleaved<const DriftingTriangle> drifting;

    static constexpr std::uint32_t per_group = constants::group_size / 2;  ///< items

    /// Sixteen bits for the first triangle, and sixteen for the second.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const ClosePair c = read_whole(close[i / per_group]);
        const std::uint32_t k = i % per_group, first = c.first * constants::group_size + k;
        const float margin = pairs[c.pair].quick_margin;
        const std::uint32_t mask = packed[c.second].near(
            read_whole(boxes[first]).inflated(margin),
            read_whole(boxes[first + per_group]).inflated(margin));
        // Within one group, each two triangles once.
        return c.first == c.second
                   ? mask & (later_than(k) | later_than(k + per_group) << constants::group_size)
                   : mask;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) {
        return std::uint32_t{(mask & of_one) != 0} + (mask > of_one);
    }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t mask, std::uint32_t place,
                         NearInGroup* near) const {
        if (mask == 0) return;
        const ClosePair c = read_whole(close[i / per_group]);
        const std::uint32_t first = c.first * constants::group_size + i % per_group,
                            others = c.second * constants::group_size;
        const std::uint32_t of_first = mask & of_one, of_second = mask >> constants::group_size;
        if (of_first != 0) write_whole(near[place++], {c.pair, first, others, of_first});
        if (of_second != 0)
            write_whole(near[place], {c.pair, first + per_group, others, of_second});
    }

#if defined(PIERCE_FOUR_LANES)
    /// What find() would find, for whole groups: without the triangles of the first group that are
    /// not near the second one's box, and without those that are further apart than the margin
    /// along its normal.
    void find_all(std::uint32_t begin, std::uint32_t end, std::uint32_t* found) const {
        for (std::uint32_t i = begin; i < end;) {
            std::uint32_t masks[constants::group_size] = {};
            find_near(read_whole(close[i / per_group]), masks);
            for (std::uint32_t k = i % per_group; k < per_group && i < end; ++k, ++i)
                found[i - begin] = masks[k] | masks[k + per_group] << constants::group_size;
        }
    }
#endif

private:
    static constexpr std::uint32_t of_one = (1u << constants::group_size) - 1;

    PIERCE_HD static std::uint32_t later_than(std::uint32_t k) {
        return of_one & ~std::uint32_t{1} << k;
    }

#if defined(PIERCE_FOUR_LANES)
    void find_near(const ClosePair& c, std::uint32_t (&masks)[constants::group_size]) const {
        const float margin = pairs[c.pair].quick_margin;
        const bool in_itself = pairs[c.pair].is_self();
        const std::uint32_t first = c.first * constants::group_size;
        const FourHeights heights(groups.boxes[c.first], groups.boxes[c.second],
                                  groups.slabs[c.second], margin);
        std::uint32_t left = packed[c.first].near(groups.boxes[c.second].inflated(margin));
        while (left != 0) {
            std::uint32_t k[Four::count], some = 0;
            FourTriangles triangles{};
            for (std::uint32_t lane = 0; lane < Four::count; ++lane) {
                // The last four may be fewer: the last one then stands in all lanes left.
                if (left != 0) {
                    k[lane] = lowest_bit(left);
                    left &= left - 1;
                    ++some;
                } else {
                    k[lane] = k[lane - 1];
                }
                triangles.triangle[lane] = &drifting.items[first + k[lane]];
            }
            std::uint32_t near[Four::count] = {of_one, of_one, of_one, of_one};
            // The parts of one sheet lie beside each other.
            if (!in_itself) heights.near(triangles, groups.heights[c.second], near);
            for (std::uint32_t lane = 0; lane < some; ++lane) {
                if (near[lane] == 0) continue;
                const QuickBox box = boxes[first + k[lane]].inflated(margin);
                masks[k[lane]] = near[lane] & packed[c.second].near(box) &
                                 // Within one group, each two triangles once.
                                 (c.first == c.second ? later_than(k[lane]) : of_one);
            }
        }
    }
#endif
};

}  // namespace pierce::stages
