#pragma once

#include <bit>

#include "pierce/core/atomics.hpp"
#include "pierce/core/bits.hpp"
#include "pierce/core/body.hpp"
#include "pierce/core/moving_point.hpp"
#include "pierce/core/stages/pairs.hpp"

/// Sheets, first part: which triangles of a sheet and another body, or of a sheet alone, may meet during the step or come
/// closer than the thickness. Boxes around triangles, groups of them and blocks of groups, over the whole step, are compared
/// sixteen at a time, from the largest to the smallest; no tree, as all of them change in every step. Nothing that meets is
/// left out.
namespace pierce::stages {

/// A vertex during the step, in world space. float32, as the positions of sheets are; a rigid body's are rounded to that,
/// once for all who look at them.
struct alignas(16) MovingVertex {
    Vec3f start;
    float start_padding = 0;
    Vec3f end;
    float end_padding = 0;
};

/// A body as sheets see it.
struct SheetBody {
    const BodyView& view;
    const MeshView& mesh;
    const MovingVertex* vertices;

    PIERCE_HD MovingPoint vertex(std::uint32_t v) const {
        const MovingVertex m = vertices[v];
        return {to_double(m.start), to_double(m.end)};
    }
};

/// The bodies of pairs with a sheet, and their vertices.
struct SheetBodies {
    View<const BodyView> views;
    View<const std::uint32_t> vertex_offsets;  ///< per body
    View<const MovingVertex> vertices;

    PIERCE_HD SheetBody operator[](std::uint32_t body) const {
        return {views[body], views[body].mesh, vertices.data + vertex_offsets[body]};
    }
};

/// A triangle during the step, in world space, relative to `origin`.
struct MovingTriangle {
    MovingPoint corner[3];

    PIERCE_HD MovingTriangle(const SheetBody& body, std::uint32_t triangle, Vec3d origin) {
        const Triangle& t = body.mesh.triangles[triangle];
        for (int k = 0; k < 3; ++k) {
            const MovingPoint p = body.vertex(t.vertex[k]);
            corner[k] = {p.start - origin, p.end - origin};
        }
    }

    PIERCE_HD Box box() const {
        Box all;
        for (const MovingPoint& p : corner) {
            all.extend(p.start);
            all.extend(p.end);
        }
        return all;
    }
    PIERCE_HD Vec3d start_normal() const {
        return cross(corner[1].start - corner[0].start, corner[2].start - corner[0].start);
    }
    PIERCE_HD Vec3d end_normal() const { return cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end); }
};

/// How a pair with a sheet is searched.
struct SheetPair {
    std::uint32_t first = 0, second = 0;  ///< bodies: the pair's a and b
    bool searches = false;                ///< a sheet is part of it
    std::uint8_t padding[7] = {};
    double thickness = 0;  ///< [length]
    double margin = 0;     ///< [length] vertices this close to triangles matter; more than the thickness if some are through
};

/// Sixteen boxes side by side, float32, not smaller than what they hold.
struct alignas(16) Boxes {
    float lower[3][constants::group_size], upper[3][constants::group_size];

    PIERCE_HD void set(std::uint32_t k, const Box& box) {
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis][k] = round_down(box.lower[axis]);
            upper[axis][k] = round_up(box.upper[axis]);
        }
    }
    /// An infinite empty one if there is none.
    PIERCE_HD Box at(std::uint32_t k) const {
        Box box;
        for (int axis = 0; axis < 3; ++axis) {
            box.lower[axis] = static_cast<double>(lower[axis][k]);
            box.upper[axis] = static_cast<double>(upper[axis][k]);
        }
        return box;
    }
    PIERCE_HD Box all() const {
        Box box;
        for (std::uint32_t k = 0; k < constants::group_size; ++k) box.extend(at(k));
        return box;
    }

    /// A bit for each that the k-th of `others`, grown by `margin`, overlaps.
    PIERCE_HD std::uint32_t near(const Boxes& others, std::uint32_t k, double margin) const {
        float low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = round_down(static_cast<double>(others.lower[axis][k]) - margin);
            high[axis] = round_up(static_cast<double>(others.upper[axis][k]) + margin);
        }
        // Bits are looked up, not shifted: then all of it becomes vector instructions.
        constexpr std::uint32_t bit[constants::group_size] = {1u << 0,  1u << 1,  1u << 2,  1u << 3, 1u << 4,  1u << 5,
                                                              1u << 6,  1u << 7,  1u << 8,  1u << 9, 1u << 10, 1u << 11,
                                                              1u << 12, 1u << 13, 1u << 14, 1u << 15};
        std::uint32_t mask = 0;
        PIERCE_VECTOR_LOOP
        for (std::uint32_t i = 0; i < constants::group_size; ++i) {
            const bool hit = (lower[0][i] <= high[0]) & (low[0] <= upper[0][i]) & (lower[1][i] <= high[1]) &
                             (low[1] <= upper[1][i]) & (lower[2][i] <= high[2]) & (low[2] <= upper[2][i]);
            mask |= hit ? bit[i] : 0u;
        }
        return mask;
    }
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
    static constexpr std::uint32_t per_block = constants::group_size * constants::group_size;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeshView& mesh = bodies[i].mesh;
        blocks[i] = wanted[i] ? (mesh.triangles.size + per_block - 1) / per_block : 0;
        vertices[i] = wanted[i] ? mesh.positions.size : 0;
    }
};

/// One of the things that lists of several owners hold one after the other.
struct OwnedItem {
    std::uint32_t owner = 0;
    std::uint32_t index = 0;
};

/// Whose the item at `place` is; `offsets`: where each owner's begin, ones after the last owner's.
PIERCE_HD inline OwnedItem owned_item(View<const std::uint32_t> offsets, std::uint32_t place) {
    std::uint32_t low = 0, high = offsets.size;
    while (high - low > 1) {
        const std::uint32_t middle = low + (high - low) / 2;
        (offsets[middle] <= place ? low : high) = middle;
    }
    return {low, place - offsets[low]};
}

/// Per vertex of a wanted body: where it is.
struct MoveVertices {
    View<const BodyView> bodies;
    View<const std::uint32_t> vertex_offsets;
    View<MovingVertex> vertices;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const OwnedItem item = owned_item(vertex_offsets, i);
        const BodyView& body = bodies[item.owner];
        const Vec3f p = body.positions[item.index];
        MovingVertex vertex;
        if (body.motion == Motion::deforming) {
            vertex.start = body.start[item.index];
            vertex.end = p;
        } else {
            vertex.start = to_float(body.start_space.to_parent(to_double(p)));
            vertex.end = to_float(body.space.to_parent(to_double(p)));
        }
        vertices[i] = vertex;
    }
};

/// Per place of a group: the box of its triangle over the step.
struct BoxTriangles {
    SheetBodies bodies;
    View<const std::uint32_t> block_offsets;  ///< per body
    View<Boxes> boxes;                        ///< per group

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t group = i / constants::group_size;
        const OwnedItem block = owned_item(block_offsets, group / constants::group_size);
        const SheetBody body = bodies[block.owner];
        const std::uint32_t place = i - block_offsets[block.owner] * CountSheetItems::per_block;
        boxes[group].set(i % constants::group_size, place < body.mesh.triangles.size && body.view.active
                                                        ? MovingTriangle(body, body.mesh.group_triangles[place], {}).box()
                                                        : Box{});
    }
};

/// A triangle or a group of them over the step, between two planes along its mean normal and within a rectangle across it:
/// float32, not smaller than what it holds. Layers that lie on each other aslant have boxes that overlap those of many
/// others; slabs do not.
struct Slab {
    Vec3f center;
    Vec3f axis[3];  ///< the normal, and two at right angles to it; unit
    float half[3] = {};
    float rounding = 0;  ///< [length] by how much sums of the above may be wrong

    /// True if along this slab's normal the other one is further away than `margin`.
    PIERCE_HD bool is_apart(const Slab& other, float margin) const {
        const Vec3f n = axis[0];
        float reach = half[0] + margin + rounding + other.rounding;
        for (int k = 0; k < 3; ++k) reach += other.half[k] * std::fabs(dot(n, other.axis[k]));
        return std::fabs(dot(n, other.center - center)) > reach;
    }
};

/// Per group, or per triangle: its slab.
struct FitSlab {
    SheetBodies bodies;
    View<const std::uint32_t> block_offsets;  ///< per body
    View<Slab> slabs;
    std::uint32_t held = 1;  ///< triangles a slab holds

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t place = i * held;
        const OwnedItem block = owned_item(block_offsets, place / CountSheetItems::per_block);
        const SheetBody body = bodies[block.owner];
        const std::uint32_t begin = place - block_offsets[block.owner] * CountSheetItems::per_block;
        const std::uint32_t end = min_of(begin + held, body.mesh.triangles.size);
        Slab slab;
        if (begin < end && body.view.active) fit(body, begin, end, slab);
        slabs[i] = slab;
    }

private:
    PIERCE_HD static void fit(const SheetBody& body, std::uint32_t begin, std::uint32_t end, Slab& slab) {
        const Vec3d origin = body.vertex(body.mesh.triangles[body.mesh.group_triangles[begin]].vertex[0]).end;
        Vec3d normal;
        for (std::uint32_t k = begin; k < end; ++k)
            normal += MovingTriangle(body, body.mesh.group_triangles[k], origin).end_normal();
        Vec3d axis[3] = {normalized(normal)};
        if (length_squared(axis[0]) == 0) axis[0] = {0, 0, 1};
        const Vec3d n = axis[0];
        const int least = std::fabs(n.x) <= std::fabs(n.y) && std::fabs(n.x) <= std::fabs(n.z) ? 0
                          : std::fabs(n.y) <= std::fabs(n.z)                                   ? 1
                                                                                               : 2;
        Vec3d side;
        side[least] = 1;
        axis[1] = normalized(cross(n, side));
        axis[2] = cross(n, axis[1]);
        Box extent;  // along the axes
        for (std::uint32_t k = begin; k < end; ++k)
            for (const MovingPoint& p : MovingTriangle(body, body.mesh.group_triangles[k], origin).corner)
                for (const Vec3d at : {p.start, p.end})
                    extent.extend(Vec3d{dot(axis[0], at), dot(axis[1], at), dot(axis[2], at)});
        const Vec3d middle = extent.center(), half = extent.half_size();
        slab.center = to_float(origin + middle.x * axis[0] + middle.y * axis[1] + middle.z * axis[2]);
        double largest = length(half);
        for (int k = 0; k < 3; ++k) {
            slab.axis[k] = to_float(axis[k]);
            slab.half[k] = round_up(half[k]);
            largest = max_of(std::fabs(static_cast<double>(slab.center[k])), largest);
        }
        // u: half a float32 ulp. Two centres are at most 3.5 times the largest coordinate apart; their difference is off by
        // 4 u of it, the axis by 1 u, the dot product by 3 u more: 28 u in all, and as much again for the sum of the
        // reaches.
        slab.rounding = round_up(4 * constants::slab_margin * largest);
    }
};

/// Per sixteen boxes: none.
struct EmptyBoxes {
    View<Boxes> boxes;

    PIERCE_HD void operator()(std::uint32_t i) const {
        for (std::uint32_t k = 0; k < constants::group_size; ++k) boxes[i].set(k, {});
    }
};

/// Per sixteen boxes: the box around them, one of sixteen itself.
struct BoxAround {
    View<const Boxes> parts;
    View<Boxes> boxes;

    PIERCE_HD void operator()(std::uint32_t i) const {
        boxes[i / constants::group_size].set(i % constants::group_size, parts[i].all());
    }
};

/// Per vertex of a sheet: 1 if the triangles around it are proved not to meet during the step, except where they hang
/// together: they go around the vertex once, and seen along one direction each of them keeps facing it. Then their
/// shadows are sectors that share no more than their sides, at any time: a sector has less than half a turn while its
/// triangle faces that way, and the number of turns cannot change. Nothing folds there (Volino and Magnenat-Thalmann 1994).
struct FindFlatStars {
    SheetBodies bodies;
    View<std::uint32_t> flat;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const OwnedItem item = owned_item(bodies.vertex_offsets, i);
        const SheetBody body = bodies[item.owner];
        flat[i] = body.view.collision.sheet && is_flat(body, item.index);
    }

private:
    /// How a triangle at the vertex, given by the ways to its two other corners, faces `n` over the step: the least of the
    /// Bernstein coefficients of a quadratic, which is not above its least value.
    PIERCE_HD static double facing(const MovingPoint& u, const MovingPoint& w, Vec3d n) {
        const double start = dot(n, cross(u.start, w.start)), end = dot(n, cross(u.end, w.end));
        const double middle = 0.5 * (dot(n, cross(u.start, w.end)) + dot(n, cross(u.end, w.start)));
        return min_of(start, min_of(middle, end));
    }

    PIERCE_HD static bool is_flat(const SheetBody& body, std::uint32_t v) {
        const MeshView& mesh = body.mesh;
        const std::uint32_t begin = mesh.corner_offsets[v], end = mesh.corner_offsets[v + 1];
        if (end - begin < 3) return false;
        const MovingPoint at = body.vertex(v);
        const auto way_to = [&](std::uint32_t w) {
            const MovingPoint p = body.vertex(w);
            return MovingPoint{p.start - at.start, p.end - at.end};
        };
        Vec3d n;
        double size = 0;
        for (std::uint32_t c = begin; c < end; ++c) {
            const MovingPoint u = way_to(mesh.corners[c].next), w = way_to(mesh.corners[c].previous);
            n += cross(u.start, w.start) + cross(u.end, w.end);
            size = max_of(size, max_of(length_squared(u.start), length_squared(u.end)));
        }
        const double least = constants::motion_rounding * length(n) * size;
        const Vec3d first = way_to(mesh.corners[begin].next).start;
        std::uint32_t turns = 0;
        for (std::uint32_t c = begin; c < end; ++c) {
            const MovingPoint u = way_to(mesh.corners[c].next), w = way_to(mesh.corners[c].previous);
            if (!(facing(u, w, n) > least)) return false;
            turns += dot(n, cross(u.start, first)) >= 0 && dot(n, cross(first, w.start)) > 0;
            std::uint32_t before = 0;
            for (std::uint32_t d = begin; d < end; ++d) before += mesh.corners[d].previous == mesh.corners[c].next;
            if (before != 1) return false;  // a border, or more than a fan
        }
        return turns == 1;
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
struct ClosePair {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;
};

/// Per block of a pair's first body: the second's blocks that are near, counted or written. In a body itself, each two once.
struct FindBlocks {
    View<const SheetPair> pairs;
    View<const std::uint32_t> row_offsets;            ///< per pair; ones past the last
    View<const std::uint32_t> block_offsets, blocks;  ///< per body
    View<const Boxes> boxes;                          ///< of blocks
    View<std::uint32_t> counts;                       ///< written if `found` is empty
    View<const std::uint32_t> offsets;
    View<ClosePair> found;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const OwnedItem row = owned_item(row_offsets, i);
        const SheetPair& pair = pairs[row.owner];
        const std::uint32_t mine = block_offsets[pair.first] + row.index;
        const std::uint32_t begin = pair.first == pair.second ? mine : block_offsets[pair.second];
        const std::uint32_t end = block_offsets[pair.second] + blocks[pair.second];
        std::uint32_t count = 0;
        for (std::uint32_t from = begin / constants::group_size * constants::group_size; from < end;
             from += constants::group_size) {
            std::uint32_t mask = boxes[from / constants::group_size].near(boxes[mine / constants::group_size],
                                                                          mine % constants::group_size, pair.margin);
            for (; mask != 0; mask &= mask - 1) {
                const std::uint32_t other = from + lowest_bit(mask);
                if (other < begin || other >= end) continue;
                if (found.data != nullptr) found[offsets[i] + count] = {row.owner, mine, other};
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

    static constexpr int blocks_at_once = 12;  // of 64 threads; measured: with 8 a fifth slower

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair& c = close[i / constants::group_size];
        const std::uint32_t k = i % constants::group_size;
        std::uint32_t mask = boxes[c.second].near(boxes[c.first], k, pairs[c.pair].margin);
        // In a block itself each two once, and each with itself.
        if (c.first == c.second) mask &= ~std::uint32_t{0} << k;
        const Slab mine = slabs[c.first * constants::group_size + k];
        const float margin = round_up(pairs[c.pair].margin);
        for (std::uint32_t left = mask; left != 0; left &= left - 1) {
            const std::uint32_t bit = lowest_bit(left);
            const Slab other = slabs[c.second * constants::group_size + bit];
            if (mine.is_apart(other, margin) || other.is_apart(mine, margin)) mask &= ~(1u << bit);
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
        const ClosePair& c = close[i / constants::group_size];
        std::uint32_t place = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1)
            found[place++] = {c.pair, c.first * constants::group_size + i % constants::group_size,
                              c.second * constants::group_size + lowest_bit(mask)};
    }
};

/// The triangle at a place of a group; `first_block`: where its body's blocks begin.
PIERCE_HD inline std::uint32_t triangle_at(const BodyView& body, std::uint32_t first_block, std::uint32_t group,
                                           std::uint32_t k) {
    return body.mesh.group_triangles[(group - first_block * constants::group_size) * constants::group_size + k];
}

/// Per triangle of a near group: a bit for each triangle of the other group whose box is near.
struct FindTriangles {
    View<const SheetPair> pairs;
    View<const ClosePair> close;  ///< groups
    View<const Boxes> boxes;      ///< of triangles, per group
    View<std::uint32_t> masks;

    static constexpr int blocks_at_once = 24;  // of 64 threads; measured: with 7 a quarter slower

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair c = close[i / constants::group_size];
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

/// Per triangle with another one near: leaves out those that a slab separates, and those that hang together where nothing
/// folds; and counts the rest.
struct CullTriangles {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const ClosePair> close;  ///< groups
    View<const std::uint32_t> rows;
    View<const Slab> slabs;                                   ///< of triangles
    View<const std::uint32_t> block_offsets, vertex_offsets;  ///< per body
    View<const std::uint32_t> flat;
    View<std::uint32_t> masks, counts;  ///< masks: of all; counts: per row

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ClosePair c = close[rows[i] / constants::group_size];
        const SheetPair& pair = pairs[c.pair];
        const std::uint32_t k = rows[i] % constants::group_size;
        std::uint32_t mask = keep_near(c, round_up(pair.margin), k, masks[rows[i]]);
        if (mask != 0 && pair.first == pair.second) mask = keep_folding(c, pair, k, mask);
        masks[rows[i]] = mask;
        counts[i] = bit_count(mask);
    }

private:
    PIERCE_HD std::uint32_t keep_near(const ClosePair& c, float margin, std::uint32_t k, std::uint32_t mask) const {
        const Slab mine = slabs[c.first * constants::group_size + k];
        for (std::uint32_t left = mask; left != 0; left &= left - 1) {
            const std::uint32_t bit = lowest_bit(left);
            const Slab& other = slabs[c.second * constants::group_size + bit];
            if (mine.is_apart(other, margin) || other.is_apart(mine, margin)) mask &= ~(1u << bit);
        }
        return mask;
    }

    PIERCE_HD std::uint32_t keep_folding(const ClosePair& c, const SheetPair& pair, std::uint32_t k,
                                         std::uint32_t mask) const {
        const BodyView& body = bodies[pair.first];
        const std::uint32_t first_block = block_offsets[pair.first];
        const std::uint32_t* const is_flat = flat.data + vertex_offsets[pair.first];
        const Triangle t = body.mesh.triangles[triangle_at(body, first_block, c.first, k)];
        for (std::uint32_t left = mask; left != 0; left &= left - 1) {
            const std::uint32_t bit = lowest_bit(left);
            const Triangle other = body.mesh.triangles[triangle_at(body, first_block, c.second, bit)];
            for (std::uint32_t v : t.vertex)
                if (has_vertex(other, v) && is_flat[v]) mask &= ~(1u << bit);
        }
        return mask;
    }
};

/// Two triangles whose features are to be tested.
struct TrianglePair {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;  ///< triangles of the pair's first and second body
};

/// Per triangle with another one near: lists the triangles of its mask.
struct ListTriangles {
    View<const BodyView> bodies;
    View<const SheetPair> pairs;
    View<const ClosePair> close;
    View<const std::uint32_t> rows;
    View<const std::uint32_t> block_offsets;
    View<const std::uint32_t> masks, offsets;
    View<TrianglePair> found;

    PIERCE_HD void operator()(std::uint32_t i) const {
        std::uint32_t mask = masks[rows[i]], place = offsets[i];
        if (mask == 0) return;
        const ClosePair c = close[rows[i] / constants::group_size];
        const SheetPair& pair = pairs[c.pair];
        const BodyView &a = bodies[pair.first], &b = bodies[pair.second];
        const std::uint32_t t = triangle_at(a, block_offsets[pair.first], c.first, rows[i] % constants::group_size);
        for (; mask != 0; mask &= mask - 1)
            found[place++] = {c.pair, t, triangle_at(b, block_offsets[pair.second], c.second, lowest_bit(mask))};
    }
};

}  // namespace pierce::stages
