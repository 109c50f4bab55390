#pragma once

#include <bit>

#include "pierce/core/atomics.hpp"
#include "pierce/core/bits.hpp"
#include "pierce/core/stages/pairs.hpp"
#include "pierce/core/stages/quick_triangle.hpp"
#include "pierce/core/whole.hpp"

/// Sheets, first part: which triangles of a sheet and another body, or of a sheet alone, may meet during the step or come
/// closer than the thickness. Boxes around triangles, groups of them and blocks of groups, over the whole step, are compared
/// sixteen at a time, from the largest to the smallest; no tree, as all of them change in every step. Nothing that meets is
/// left out.
namespace pierce::stages {

/// How a pair with a sheet is searched.
struct SheetPair {
    std::uint32_t first = 0, second = 0;  ///< bodies: the pair's a and b
    bool searches = false;                ///< a sheet is part of it
    std::uint8_t padding[7] = {};
    double thickness = 0;  ///< [length]
    double margin = 0;     ///< [length] vertices this close to triangles matter; more than the thickness if some are through
};

/// Per pair: how it is searched. Reads how deep vertices were on the wrong side in the last step. Marks the bodies of pairs
/// with a sheet.
struct PlanSheetPair {
    View<const BodyView> bodies;
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
        s.thickness = s.margin = max_of(a.thickness, b.thickness);
        if (links[i] != no_pair && links[i] < last_deepest.size)
            s.margin += static_cast<double>(std::bit_cast<float>(last_deepest[links[i]]));
        s.searches = pair.is_self() ? a.sheet && a.self == SelfCollision::on : a.sheet || b.sheet;
        sheet_pairs[i] = s;
        if (!s.searches) return;
        atomic_mark(wanted[pair.a]);
        atomic_mark(wanted[pair.b]);
    }
};

/// Per body: how many blocks of groups of triangles it has, if it is wanted, and how many vertices.
struct CountSheetItems {
    View<const BodyView> bodies;
    View<const std::uint32_t> wanted;
    View<std::uint32_t> blocks, vertices;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeshView& mesh = bodies[i].mesh;
        blocks[i] = wanted[i] ? (mesh.triangles.size + triangles_per_block - 1) / triangles_per_block : 0;
        vertices[i] = wanted[i] ? mesh.positions.size : 0;
    }
};

/// Per pair: how many blocks the first body has, if the pair is searched.
struct CountRows {
    View<const SheetPair> pairs;
    View<const std::uint32_t> blocks;  ///< per body
    View<std::uint32_t> counts;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { counts[i] = pairs[i].searches ? blocks[pairs[i].first] : 0; }
};

/// Two things of a pair's bodies that are close: blocks or groups, by their places among all.
struct alignas(16) ClosePair {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;
    std::uint32_t padding = 0;
};

/// Per block of a pair's first body: the second's blocks that are near, counted or written. In a body itself, each two once.
struct FindBlocks {
    View<const SheetPair> pairs;
    View<const std::uint32_t> row_offsets;            ///< per pair; ones past the last
    View<const std::uint32_t> block_offsets, blocks;  ///< per body
    View<const Boxes> boxes;                          ///< of blocks
    View<const Slab> slabs;                           ///< of blocks
    View<std::uint32_t> counts;                       ///< written if `found` is empty
    View<const std::uint32_t> offsets;
    View<ClosePair> found;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const OwnedItem row = owned_item(row_offsets, i);
        const SheetPair& pair = pairs[row.owner];
        const std::uint32_t mine = block_offsets[pair.first] + row.index;
        const std::uint32_t begin = pair.first == pair.second ? mine : block_offsets[pair.second];
        const std::uint32_t end = block_offsets[pair.second] + blocks[pair.second];
        const Slab slab = read_whole(slabs[mine]);
        std::uint32_t count = 0;
        for (std::uint32_t from = begin / constants::group_size * constants::group_size; from < end;
             from += constants::group_size) {
            std::uint32_t mask = boxes[from / constants::group_size].near(boxes[mine / constants::group_size],
                                                                          mine % constants::group_size, pair.margin);
            for (; mask != 0; mask &= mask - 1) {
                const std::uint32_t other = from + lowest_bit(mask);
                if (other < begin || other >= end || slab.is_apart(read_whole(slabs[other]), round_up(pair.margin)))
                    continue;
                if (found.data != nullptr) write_whole(found[offsets[i] + count], {row.owner, mine, other});
                ++count;
            }
        }
        if (found.data == nullptr) counts[i] = count;
    }
};

/// Per group of a near block: a bit for each group of the other block that is near, and their number.
struct FindGroups {
    View<const SheetPair> pairs;
    View<const ClosePair> close;  ///< blocks
    View<const Boxes> boxes;      ///< of groups, per block
    View<const Slab> slabs;       ///< of groups
    View<std::uint32_t> masks, counts;

    static constexpr int threads_at_once = 768;  // measured: with 512 a fifth slower

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair c = read_whole(close[i / constants::group_size]);
        const std::uint32_t k = i % constants::group_size;
        std::uint32_t mask = boxes[c.second].near(boxes[c.first], k, pairs[c.pair].margin);
        // In a block itself each two once, and each with itself.
        if (c.first == c.second) mask &= ~std::uint32_t{0} << k;
        const Slab mine = read_whole(slabs[c.first * constants::group_size + k]);
        const float margin = round_up(pairs[c.pair].margin);
        for (std::uint32_t left = mask; left != 0; left &= left - 1) {
            const std::uint32_t bit = lowest_bit(left);
            const Slab other = read_whole(slabs[c.second * constants::group_size + bit]);
            if (mine.is_apart(other, margin)) mask &= ~(1u << bit);
        }
        masks[i] = mask;
        counts[i] = bit_count(mask);
    }
};

/// Per group of a near block: lists the near groups of its mask.
struct ListGroups {
    View<const ClosePair> close;
    View<const std::uint32_t> masks, offsets;
    View<ClosePair> found;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair c = read_whole(close[i / constants::group_size]);
        std::uint32_t place = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1)
            write_whole(found[place++], {c.pair, c.first * constants::group_size + i % constants::group_size,
                                         c.second * constants::group_size + lowest_bit(mask)});
    }
};

/// Per triangle of a near group: a bit for each triangle of the other group whose box is near.
struct FindTriangles {
    View<const SheetPair> pairs;
    View<const ClosePair> close;  ///< groups
    View<const Boxes> boxes;      ///< of triangles, per group
    View<std::uint32_t> masks;

    static constexpr int threads_at_once = 1536;  // measured: with 448 a quarter slower

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair c = read_whole(close[i / constants::group_size]);
        const std::uint32_t k = i % constants::group_size;
        const std::uint32_t mask = boxes[c.second].near(boxes[c.first], k, pairs[c.pair].margin);
        masks[i] = c.first == c.second ? mask & ~std::uint32_t{1} << k : mask;
    }
};

/// True for triangles with another one near.
struct HasNear {
    View<const std::uint32_t> masks;

    PIERCE_HD bool operator()(std::uint32_t i) const { return masks[i] != 0; }
};

/// Per triangle with another one near: leaves out those that a normal of the two keeps apart, and those that hang together
/// where nothing folds; and counts the rest.
struct CullTriangles {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const ClosePair> close;  ///< groups
    View<const std::uint32_t> rows;
    View<const PlacedTriangle> placed;
    View<const std::uint32_t> vertex_offsets;  ///< per body
    View<const std::uint32_t> flat;
    View<std::uint32_t> masks, counts;  ///< masks: of all; counts: per row

    static constexpr std::uint32_t separate_shift = constants::group_size;  ///< of the bits for those that do not meet

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair c = read_whole(close[rows[i] / constants::group_size]);
        const SheetPair& pair = pairs[c.pair];
        const std::uint32_t k = rows[i] % constants::group_size;
        std::uint32_t separate = 0;
        std::uint32_t mask = keep_near(c, round_up(pair.margin), k, masks[rows[i]], separate);
        if (mask != 0 && pair.first == pair.second) mask = keep_folding(c, pair, k, mask);
        masks[rows[i]] = mask | separate << separate_shift;
        counts[i] = bit_count(mask);
    }

private:
    PIERCE_HD std::uint32_t keep_near(const ClosePair& c, float margin, std::uint32_t k, std::uint32_t mask,
                                      std::uint32_t& separate) const {
        const PlacedTriangle mine = read_whole(placed[c.first * constants::group_size + k]);
        const QuickTriangle a(mine, mine.end[0]);
        const float size = quick_max(a.start_size(), a.end_size());
        const Vec3f normal = a.end_normal();
        for (std::uint32_t left = mask; left != 0; left &= left - 1) {
            const std::uint32_t bit = lowest_bit(left);
            const QuickTriangle b(read_whole(placed[c.second * constants::group_size + bit]), mine.end[0]);
            const float larger = quick_max(size, quick_max(b.start_size(), b.end_size()));
            Company company = company_along(normal, a.corner, b.corner, margin, larger);
            if (!company.is_settled()) company.learn(company_along(b.end_normal(), a.corner, b.corner, margin, larger));
            if (company.is_settled()) mask &= ~(1u << bit);
            separate |= static_cast<std::uint32_t>(company.separate) << bit;
        }
        return mask;
    }

    PIERCE_HD std::uint32_t keep_folding(const ClosePair& c, const SheetPair& pair, std::uint32_t k,
                                         std::uint32_t mask) const {
        const BodyView& body = bodies[pair.first];
        const std::uint32_t* const is_flat = flat.data + vertex_offsets[pair.first];
        const Triangle t = body.mesh.triangles[placed[c.first * constants::group_size + k].triangle];
        for (std::uint32_t left = mask; left != 0; left &= left - 1) {
            const std::uint32_t bit = lowest_bit(left);
            const Triangle other = body.mesh.triangles[placed[c.second * constants::group_size + bit].triangle];
            for (std::uint32_t v : t.vertex)
                if (has_vertex(other, v) && is_flat[v]) mask &= ~(1u << bit);
        }
        return mask;
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
        const std::uint32_t separate = masks[rows[i]] >> CullTriangles::separate_shift;
        std::uint32_t mask = masks[rows[i]] & ((1u << CullTriangles::separate_shift) - 1), place = offsets[i];
        if (mask == 0) return;
        const ClosePair c = read_whole(close[rows[i] / constants::group_size]);
        const std::uint32_t first = c.first * constants::group_size + rows[i] % constants::group_size;
        for (; mask != 0; mask &= mask - 1) {
            const std::uint32_t bit = lowest_bit(mask);
            write_whole(found[place++], {c.pair, first, c.second * constants::group_size + bit, separate >> bit & 1});
        }
    }
};

}  // namespace pierce::stages
