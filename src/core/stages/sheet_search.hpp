#pragma once

#include <bit>

#include "pierce/core/atomics.hpp"
#include "pierce/core/bits.hpp"
#include "pierce/core/stages/flat_stars.hpp"
#include "pierce/core/stages/pairs.hpp"
#include "pierce/core/stages/quick_triangle.hpp"
#include "pierce/core/warp.hpp"

/// Sheets, first part: which triangles of a sheet and another body, or of a sheet alone, may meet during the step or come
/// closer than the thickness. Boxes around triangles, groups of them and blocks of groups, over the whole step, are compared
/// sixteen at a time, from the largest to the smallest, section by section (sixteen blocks); no tree, as all of them change
/// in every step. Nothing that meets is left out.
namespace pierce::stages {

/// How a pair with a sheet is searched.
struct alignas(16) SheetPair {
    std::uint32_t first = 0, second = 0;  ///< bodies: the pair's a and b
    bool searches = false;                ///< a sheet is part of it
    bool is_solid[2] = {};                ///< the first, the second
    bool was_through = false;             ///< vertices ended the last step on the wrong side
    std::uint8_t padding[4] = {};
    double thickness = 0;  ///< [length]
    double margin = 0;     ///< [length] vertices this close to triangles matter; more than the thickness if some are through
    float quick_thickness = 0, quick_margin = 0;  ///< not less
    std::uint32_t more_padding[2] = {};
    BodyId ids[2];

    PIERCE_HD bool is_self() const { return first == second; }
};

/// Per pair: how it is searched. Reads how deep vertices were on the wrong side in the last step. Marks the bodies of pairs
/// with a sheet.
struct PlanSheetPair {
    View<const BodyView> bodies;
    View<const BodyId> ids;
    View<const Pair> pairs;
    View<const std::uint32_t> links;
    View<const std::uint32_t> last_deepest;  ///< per pair of the last step, as the bits of a float32
    View<SheetPair> sheet_pairs;
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
        if (links[i] != no_pair && links[i] < last_deepest.size) {
            s.margin += static_cast<double>(std::bit_cast<float>(last_deepest[links[i]]));
            s.was_through = last_deepest[links[i]] != 0;
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

/// Per body, if it is wanted: how many sections and blocks of triangles it has, and how many vertices.
struct CountSheetItems {
    View<const BodyView> bodies;
    View<const std::uint32_t> wanted;
    View<std::uint32_t> sections, blocks, vertices;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeshView& mesh = bodies[i].mesh;
        blocks[i] = wanted[i] ? (mesh.triangles.size + triangles_per_block - 1) / triangles_per_block : 0;
        sections[i] = (blocks[i] + constants::group_size - 1) / constants::group_size;
        vertices[i] = wanted[i] ? mesh.positions.size : 0;
    }
};

/// Per pair: how many sections the first body has, if the pair is searched.
struct CountRows {
    View<const SheetPair> pairs;
    View<const std::uint32_t> sections;  ///< per body
    View<std::uint32_t> counts;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { counts[i] = pairs[i].searches ? sections[pairs[i].first] : 0; }
};

/// Two things of a pair's bodies that may be close: sections, blocks or groups, by their places among all.
struct alignas(16) ClosePair {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;
    std::uint32_t padding = 0;
};

/// Per section of a pair's first body: the second's sections, counted or listed. In a body itself, each two once.
struct ListSections {
    View<const SheetPair> pairs;
    View<const std::uint32_t> row_offsets;                ///< per pair; ones past the last
    View<const std::uint32_t> section_offsets, sections;  ///< per body
    View<std::uint32_t> counts;                           ///< written if `found` is empty
    View<const std::uint32_t> offsets;
    View<ClosePair> found;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const OwnedItem row = owned_item(row_offsets, i);
        const SheetPair& pair = pairs[row.owner];
        const std::uint32_t mine = section_offsets[pair.first] + row.index;
        const std::uint32_t begin = pair.is_self() ? mine : section_offsets[pair.second];
        const std::uint32_t end = section_offsets[pair.second] + sections[pair.second];
        if (found.data == nullptr) {
            counts[i] = end - begin;
            return;
        }
        for (std::uint32_t other = begin; other < end; ++other)
            write_whole(found[offsets[i] + other - begin], {row.owner, mine, other});
    }
};

/// Per sixteenth of a section or block that is close to another: a bit for each sixteenth of the other one that is near, and
/// their number.
struct FindParts {
    View<const SheetPair> pairs;
    View<const ClosePair> close;  ///< sections, or blocks
    Parts parts;
    View<const QuickBox> boxes;    ///< of the parts
    View<const GridBoxes> packed;  ///< of the parts, per section or block
    View<const Slab> slabs;        ///< of the parts
    View<std::uint32_t> masks, counts;

    static constexpr int threads_at_once = 768;  // measured: with 512 a fifth slower

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair c = read_whole(close[i / constants::group_size]);
        const std::uint32_t k = i % constants::group_size;
        std::uint32_t mask = 0;
        if (parts.has(c.first, k))
            mask = packed[c.second].near(read_whole(boxes[parts.begin(c.first) + k]).inflated(pairs[c.pair].quick_margin));
        // In one itself each two once, and each with itself.
        if (c.first == c.second) mask &= ~std::uint32_t{0} << k;
        masks[i] = ask_bits(mask, i, *this);
        counts[i] = bit_count(masks[i]);
    }

    /// Of a part and one of the other's: 1 if they may be near.
    PIERCE_HD std::uint32_t operator()(std::uint32_t i, std::uint32_t bit) const {
        const ClosePair c = read_whole(close[i / constants::group_size]);
        const Slab mine = read_whole(slabs[parts.begin(c.first) + i % constants::group_size]);
        return !mine.is_apart(read_whole(slabs[parts.begin(c.second) + bit]), pairs[c.pair].quick_margin);
    }
};

/// Per sixteenth of a section or block: lists the near ones of its mask.
struct ListParts {
    View<const ClosePair> close;
    Parts parts;
    View<const std::uint32_t> masks, offsets;
    View<ClosePair> found;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        write_bits<asked_bits>(masks[i], i, offsets[i], [&](std::uint32_t part, std::uint32_t bit, std::uint32_t place) {
            const ClosePair c = read_whole(close[part / constants::group_size]);
            write_whole(found[place],
                        {c.pair, parts.begin(c.first) + part % constants::group_size, parts.begin(c.second) + bit});
        });
    }
};

/// Per triangle of a near group: a bit for each triangle of the other group whose box is near.
struct FindTriangles {
    View<const SheetPair> pairs;
    View<const ClosePair> close;   ///< groups
    View<const QuickBox> boxes;    ///< of triangles
    View<const GridBoxes> packed;  ///< of triangles, per group
    View<std::uint32_t> masks;

    static constexpr int threads_at_once = 1536;  // measured: with 448 a quarter slower

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair c = read_whole(close[i / constants::group_size]);
        const QuickBox box = read_whole(boxes[c.first * constants::group_size + i % constants::group_size]);
        const std::uint32_t mask = packed[c.second].near(box.inflated(pairs[c.pair].quick_margin));
        masks[i] = c.first == c.second ? mask & ~std::uint32_t{1} << i % constants::group_size : mask;
    }
};

/// True for triangles with another one near.
struct HasNear {
    View<const std::uint32_t> masks;

    PIERCE_HD bool operator()(std::uint32_t i) const { return masks[i] != 0; }
};

/// Per triangle with another one near: leaves out those that hang together where nothing folds, and those that a normal of
/// the two keeps apart; and counts the rest.
struct CullTriangles {
    View<const SheetPair> pairs;
    View<const ClosePair> close;  ///< groups
    View<const std::uint32_t> rows;
    Interleaved<const DriftingTriangle> drifting;
    View<const FlatCorners> flat_corners;
    View<std::uint32_t> masks, counts;  ///< masks: of all; counts: per row

    static constexpr int threads_at_once = 768;
    static constexpr std::uint32_t separate_shift = asked_bits;  ///< of the bits for those that do not meet
    static_assert(asked_bits == constants::group_size);

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t row = rows[i];
        masks[row] = ask_bits(masks[row], row, *this);
        counts[i] = bit_count(masks[row] & ((1u << separate_shift) - 1));
    }

    /// Of a triangle and another one near: 0 if they are left out, else 1, and 2 more if they do not meet.
    PIERCE_HD std::uint32_t operator()(std::uint32_t row, std::uint32_t bit) const {
        const ClosePair c = read_whole(close[row / constants::group_size]);
        const SheetPair& pair = pairs[c.pair];
        const std::uint32_t mine = c.first * constants::group_size + row % constants::group_size,
                            other = c.second * constants::group_size + bit;
        if (pair.is_self() && read_whole(flat_corners[mine]).shares_one(read_whole(flat_corners[other]))) return 0;
        const DriftingPair both(drifting.read(mine), drifting.read(other));
        Company company = both.along_normal_of_a(pair.quick_margin);
        if (!company.is_settled()) company.learn(both.along_normal_of_b(pair.quick_margin));
        return company.is_settled() ? 0 : 1 | static_cast<std::uint32_t>(company.separate) << 1;
    }
};

/// Two triangles whose features are to be tested.
struct alignas(16) TrianglePair {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;  ///< places of triangles of the pair's first and second body
    std::uint32_t separate = 0;           ///< 1: it is known that they do not meet
};

/// Per triangle with another one near: lists the triangles of its mask.
struct ListTriangles {
    View<const ClosePair> close;
    View<const std::uint32_t> rows;
    View<const std::uint32_t> masks, offsets;
    View<TrianglePair> found;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t near = masks[rows[i]] & ((1u << CullTriangles::separate_shift) - 1);
        write_bits<asked_bits>(near, rows[i], offsets[i], [&](std::uint32_t row, std::uint32_t bit, std::uint32_t place) {
            const ClosePair c = read_whole(close[row / constants::group_size]);
            write_whole(found[place],
                        {c.pair, c.first * constants::group_size + row % constants::group_size,
                         c.second * constants::group_size + bit, masks[row] >> (CullTriangles::separate_shift + bit) & 1});
        });
    }
};

}  // namespace pierce::stages
