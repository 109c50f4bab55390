#pragma once

#include "pierce/core/body.hpp"
#include "pierce/core/interleaved.hpp"
#include "pierce/core/moving_point.hpp"
#include "pierce/core/quick_vec3.hpp"
#include "pierce/core/stages/quick_reach.hpp"
#include "pierce/core/stages/slab.hpp"

/// Where the bodies that sheets meet are over the step: vertices, and boxes and slabs (slab.hpp) around triangles, groups of
/// sixteen triangles and blocks of sixteen groups.
namespace pierce::stages {

inline constexpr std::uint32_t triangles_per_block = constants::group_size * constants::group_size;

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
        const MovingVertex m = read_whole(vertices[v]);
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

    /// A vertex by its place among those of all bodies.
    PIERCE_HD MovingPoint vertex(std::uint32_t place) const {
        const MovingVertex m = read_whole(vertices[place]);
        return {to_double(m.start), to_double(m.end)};
    }
};

/// A triangle during the step, in world space, relative to `origin`.
struct MovingTriangle {
    MovingPoint corner[3];

    PIERCE_HD MovingTriangle(const MovingPoint& a, const MovingPoint& b, const MovingPoint& c, Vec3d origin)
        : corner{
              {a.start - origin, a.end - origin}, {b.start - origin, b.end - origin}, {c.start - origin, c.end - origin}} {}
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

/// Sixteen boxes side by side, float32, not smaller than what they hold.
struct Boxes {
    /// Of four boxes: a vector register, and what a GPU reads at once.
    struct alignas(16) Four {
        float of[4];
    };
    static constexpr std::uint32_t fours = constants::group_size / 4;

    Four lower[3][fours], upper[3][fours];

    PIERCE_HD void set(std::uint32_t k, const Box& box) {
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis][k / 4].of[k % 4] = round_down(box.lower[axis]);
            upper[axis][k / 4].of[k % 4] = round_up(box.upper[axis]);
        }
    }
    /// An infinite empty one if there is none.
    PIERCE_HD Box at(std::uint32_t k) const {
        Box box;
        for (int axis = 0; axis < 3; ++axis) {
            box.lower[axis] = static_cast<double>(lower[axis][k / 4].of[k % 4]);
            box.upper[axis] = static_cast<double>(upper[axis][k / 4].of[k % 4]);
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
        const float grown = round_up(margin);
        float low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = not_above(others.lower[axis][k / 4].of[k % 4] - grown);
            high[axis] = not_below(others.upper[axis][k / 4].of[k % 4] + grown);
        }
        std::uint32_t mask = 0;
        for (std::uint32_t four = 0; four < fours; ++four) {
            Four least[3], most[3];
            for (int axis = 0; axis < 3; ++axis) {
                least[axis] = read_whole(lower[axis][four]);
                most[axis] = read_whole(upper[axis][four]);
            }
            // Bits are looked up, not shifted: then all of it becomes vector instructions.
            constexpr std::uint32_t bit[4] = {1, 2, 4, 8};
            std::uint32_t hits = 0;
            PIERCE_VECTOR_LOOP
            for (std::uint32_t i = 0; i < 4; ++i) {
                const bool hit = (least[0].of[i] <= high[0]) & (low[0] <= most[0].of[i]) & (least[1].of[i] <= high[1]) &
                                 (low[1] <= most[1].of[i]) & (least[2].of[i] <= high[2]) & (low[2] <= most[2].of[i]);
                hits |= hit ? bit[i] : 0u;
            }
            mask |= hits << (4 * four);
        }
        return mask;
    }
};

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
        write_whole(vertices[i], vertex);
    }
};

/// A triangle during the step, in world space, at its place in a group.
struct alignas(16) PlacedTriangle {
    Vec3f start[3], end[3];
    std::uint32_t triangle = no_triangle;  ///< none: its group has no more, or its body takes no part
    std::uint32_t own = 0;                 ///< TriangleFeatures::own
    /// Its vertices around which nothing folds (flat_stars.hpp); no_vertex for the others.
    std::uint32_t flat[3] = {no_vertex, no_vertex, no_vertex};
    std::uint32_t padding = 0;

    PIERCE_HD Vec3d end_normal() const {
        const Vec3d a = to_double(end[0]);
        return cross(to_double(end[1]) - a, to_double(end[2]) - a);
    }

    /// True if another triangle of the same body hangs together with it around such a vertex.
    PIERCE_HD bool shares_flat_star(const PlacedTriangle& other) const {
        bool shares = false;
        for (std::uint32_t v : flat)
            shares |= v != no_vertex && (v == other.flat[0] || v == other.flat[1] || v == other.flat[2]);
        return shares;
    }
};

/// A placed triangle's normal, and what float32 sees of its corners, relative to the first one's place at the end.
struct alignas(16) Facing {
    Vec3f normal;    ///< at the end of the step, of any length
    Reach reach;     ///< of the corners, along the normal
    float size = 0;  ///< no coordinate is larger

    Facing() = default;
    PIERCE_HD explicit Facing(const PlacedTriangle& t) {
        QuickPoint corner[3];
        for (int k = 0; k < 3; ++k) {
            corner[k] = {t.start[k] - t.end[0], t.end[k] - t.end[0]};
            for (int axis = 0; axis < 3; ++axis)
                size = quick_max(quick_max(std::fabs(corner[k].start[axis]), std::fabs(corner[k].end[axis])), size);
        }
        normal = quick_cross(corner[1].end, corner[2].end);
        reach = Reach(normal, corner);
    }
};

/// Per place of a group: its triangle over the step, and the box of that.
struct PlaceTriangles {
    SheetBodies bodies;
    View<const std::uint32_t> block_offsets;  ///< per body
    View<const std::uint32_t> flat;           ///< per vertex
    Interleaved<PlacedTriangle> placed;
    Interleaved<Facing> facing;
    View<Boxes> boxes;  ///< per group

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t group = i / constants::group_size;
        const OwnedItem block = owned_item(block_offsets, group / constants::group_size);
        const SheetBody body = bodies[block.owner];
        const std::uint32_t place = i - block_offsets[block.owner] * triangles_per_block;
        PlacedTriangle p;
        Box box;
        if (place < body.mesh.triangles.size && body.view.active) {
            p.triangle = body.mesh.group_triangles[place];
            p.own = body.mesh.features[p.triangle].own;
            const Triangle t = body.mesh.triangles[p.triangle];
            for (int k = 0; k < 3; ++k) {
                const MovingVertex v = read_whole(body.vertices[t.vertex[k]]);
                if (flat[bodies.vertex_offsets[block.owner] + t.vertex[k]]) p.flat[k] = t.vertex[k];
                p.start[k] = v.start;
                p.end[k] = v.end;
                box.extend(to_double(v.start));
                box.extend(to_double(v.end));
            }
        }
        placed.write(i, p);
        facing.write(i, Facing(p));
        boxes[group].set(i % constants::group_size, box);
    }
};

/// Per group: the slab and the box around its triangles.
struct BoundGroups {
    Interleaved<const PlacedTriangle> placed;
    View<Slab> slabs;
    View<Boxes> boxes;  ///< per block

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t first = i * constants::group_size;
        std::uint32_t count = 0;
        Vec3d normal;
        Box box;
        for (; count < constants::group_size; ++count) {
            const PlacedTriangle t = placed.read(first + count);
            if (t.triangle == no_triangle) break;
            normal += t.end_normal();
            for (int c = 0; c < 3; ++c) {
                box.extend(to_double(t.start[c]));
                box.extend(to_double(t.end[c]));
            }
        }
        boxes[i / constants::group_size].set(i % constants::group_size, box);
        if (count == 0) return write_whole(slabs[i], {});
        const Vec3d origin = to_double(placed.read(first).end[0]);
        const SlabFrame frame(normal);
        Box extent;
        for (std::uint32_t k = 0; k < count; ++k) {
            const PlacedTriangle t = placed.read(first + k);
            for (int c = 0; c < 3; ++c) {
                extent.extend(frame.along(to_double(t.start[c]) - origin));
                extent.extend(frame.along(to_double(t.end[c]) - origin));
            }
        }
        write_whole(slabs[i], frame.slab(extent, origin));
    }
};

/// Per sixteen slabs: the one around them.
struct SlabAround {
    View<const Slab> parts;
    View<Slab> slabs;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Slab* const part = parts.data + i * constants::group_size;
        Vec3d normal;
        for (std::uint32_t k = 0; k < constants::group_size; ++k) normal += to_double(part[k].axis[0]);
        const Vec3d origin = to_double(part[0].center);
        const SlabFrame frame(normal);
        Box extent;
        for (std::uint32_t k = 0; k < constants::group_size; ++k) {
            const Slab held = read_whole(part[k]);
            if (!held.holds_something()) continue;
            const Vec3d middle = frame.along(to_double(held.center) - origin);
            Vec3d reach;
            for (int axis = 0; axis < 3; ++axis) {
                reach[axis] = static_cast<double>(held.rounding);
                for (int j = 0; j < 3; ++j)
                    reach[axis] +=
                        static_cast<double>(held.half[j]) * std::fabs(dot(frame.axis[axis], to_double(held.axis[j])));
            }
            extent.extend(middle - reach);
            extent.extend(middle + reach);
        }
        write_whole(slabs[i], part[0].holds_something() ? frame.slab(extent, origin) : Slab{});
    }
};

/// Where the parts of sections, or blocks, begin among all blocks, or groups.
struct Parts {
    View<const std::uint32_t> begins;  ///< empty: one after the other, sixteen each

    PIERCE_HD std::uint32_t begin(std::uint32_t whole) const {
        return begins.size > 0 ? begins[whole] : whole * constants::group_size;
    }
};

/// Per place of a section: the box of its block; an empty one if there is none. And where the section's blocks begin.
struct PlaceBlocks {
    View<const std::uint32_t> section_offsets, block_offsets, blocks;  ///< per body
    View<const Boxes> boxes;                                           ///< of groups, per block
    View<Boxes> in_sections;
    View<std::uint32_t> begins;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t section = i / constants::group_size, k = i % constants::group_size;
        const OwnedItem item = owned_item(section_offsets, section);
        const std::uint32_t place = item.index * constants::group_size + k, block = block_offsets[item.owner] + place;
        if (k == 0) begins[section] = block;
        in_sections[section].set(k, place < blocks[item.owner] ? boxes[block].all() : Box{});
    }
};

}  // namespace pierce::stages
