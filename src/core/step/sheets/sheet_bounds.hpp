#pragma once

#include "core/body/body_view.hpp"
#include "core/device/interleaved.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/geometry/grid_boxes.hpp"
#include "core/geometry/moving_point.hpp"
#include "core/geometry/sixteen_boxes.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/sheets/four_reach.hpp"
#include "core/step/sheets/group_heights.hpp"
#include "core/step/sheets/placed_triangle.hpp"
#include "core/step/sheets/slab.hpp"
#include "pierce/body.hpp"
#include "pierce/min_max.hpp"

/// Where the bodies that sheets meet are over the step: vertices, and boxes and slabs (slab.hpp)
/// around triangles, groups of sixteen triangles and blocks of sixteen groups.
namespace pierce::stages {

inline constexpr std::uint32_t triangles_per_block = constants::group_size * constants::group_size;

/// A vertex during the step, in world space. float32, as the positions of sheets are; a rigid
/// body's vertices are rounded to float32 once for all readers.
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
    std::uint32_t first_place;  ///< of its triangles, among those of all bodies

    PIERCE_HD MovingPoint vertex(std::uint32_t v) const {
        const MovingVertex m = read_whole(vertices[v]);
        return {to_double(m.start), to_double(m.end)};
    }
    PIERCE_HD bool has_triangle_at(std::uint32_t place) const {
        return place - first_place < mesh.triangles.size && view.active;
    }
    PIERCE_HD std::uint32_t triangle_at(std::uint32_t place) const {
        return mesh.group_triangles[place - first_place];
    }
    PIERCE_HD PlacedTriangle placed(std::uint32_t triangle) const {
        PlacedTriangle placed;
        const Triangle t = mesh.triangles[triangle];
        for (int k = 0; k < 3; ++k) {
            const MovingVertex v = read_whole(vertices[t.vertex[k]]);
            placed.start[k] = v.start;
            placed.end[k] = v.end;
        }
        placed.triangle = triangle;
        placed.own = mesh.features[triangle].own;
        return placed;
    }
};

/// The bodies of pairs with a sheet, and their vertices and triangles.
struct SheetBodies {
    View<const BodyView> views;
    View<const std::uint32_t> vertex_offsets, block_offsets;  ///< per body
    View<const MovingVertex> vertices;

    PIERCE_HD SheetBody operator[](std::uint32_t body) const {
        return {.view = views[body],
                .mesh = views[body].mesh,
                .vertices = vertices.data + vertex_offsets[body],
                .first_place = block_offsets[body] * triangles_per_block};
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

    PIERCE_HD MovingTriangle(const MovingPoint& a, const MovingPoint& b, const MovingPoint& c,
                             Vec3d origin)
        : corner{{a.start - origin, a.end - origin},
                 {b.start - origin, b.end - origin},
                 {c.start - origin, c.end - origin}} {}
    PIERCE_HD MovingTriangle(const SheetBody& body, std::uint32_t triangle, Vec3d origin) {
        const Triangle& t = body.mesh.triangles[triangle];
        for (int k = 0; k < 3; ++k) {
            const MovingPoint p = body.vertex(t.vertex[k]);
            corner[k] = {p.start - origin, p.end - origin};
        }
    }

    PIERCE_HD Vec3d start_normal() const {
        return cross(corner[1].start - corner[0].start, corner[2].start - corner[0].start);
    }
    PIERCE_HD Vec3d end_normal() const {
        return cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end);
    }
};

/// An item of a list that holds the items of several owners one after the other.
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
        write_whole(vertices[i], vertex);
    }
};

/// Where the parts of sections or blocks are: among all blocks or groups.
struct Parts {
    View<const std::uint32_t> begins, ends;  ///< empty: one after the other, sixteen each

    PIERCE_HD std::uint32_t begin(std::uint32_t whole) const {
        return begins.size > 0 ? begins[whole] : whole * constants::group_size;
    }
    PIERCE_HD bool has(std::uint32_t whole, std::uint32_t k) const {
        return ends.size == 0 || begins[whole] + k < ends[whole];
    }
};

static_assert(constants::group_size == Sixteen<QuickBox>::count);

/// Per group: its triangles over the step as culling sees them, their boxes and heights, and the
/// slab and the box around them.
struct PlaceGroups {
    SheetBodies bodies;
    Interleaved<DriftingTriangle> drifting;
    View<QuickBox> triangle_boxes;
    View<GridBoxes> packed;
    View<Slab> slabs;
    View<QuickBox> boxes;
    View<GroupHeights> heights;  ///< empty where nobody reads them

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t group = Sixteen<PlacedTriangle>::group_of(i),
                            first = group * constants::group_size;
        const SheetBody
            body = bodies[owned_item(bodies.block_offsets, group / constants::group_size).owner];
        Sixteen<PlacedTriangle> triangles;
        Sixteen<QuickBox> own_boxes;
        triangles.each([&](std::uint32_t k, PlacedTriangle& p) {
            p = {};
            if (body.has_triangle_at(first + k)) p = body.placed(body.triangle_at(first + k));
        });
        triangles.each([&](std::uint32_t k, const PlacedTriangle& p) {
            drifting.write(first + k, DriftingTriangle(p));
        });
        own_boxes.each([&](std::uint32_t k, QuickBox& box) {
            box = with_tolerance(triangles.at(k).box());
            write_whole(triangle_boxes[first + k], box);
        });
        const QuickBox box = box_around(own_boxes);
        pack(packed[group], own_boxes, box);
        const Slab slab = box.empty() ? Slab{} : slab_around(triangles, box, group);
        if (!Sixteen<PlacedTriangle>::is_first()) return;
        write_whole(boxes[group], box);
        write_whole(slabs[group], slab);
    }

private:
    /// Features that come as close as the meeting tolerance meet: boxes around them must be near
    /// then, by more than a half of it for each of the two triangles.
    PIERCE_HD static QuickBox with_tolerance(const QuickBox& box) {
        constexpr auto twice = static_cast<float>(2 * constants::meeting_tolerance);
        return box.empty() ? box : box.inflated(twice * largest_of(box.upper - box.lower));
    }

    PIERCE_HD Slab slab_around(const Sixteen<PlacedTriangle>& triangles, const QuickBox& box,
                               [[maybe_unused]] std::uint32_t group) const {
        const SlabFrame frame(triangles.joined<Vec3d>(
            [](std::uint32_t, const PlacedTriangle& t) { return t.end_normal(); },
            [](Vec3d& all, Vec3d part) { all += part; }));
        const Vec3d origin = to_double(box.lower);
#if defined(PIERCE_FOUR_LANES)
        const FourReach four(frame, box);
        Box all, reach[constants::group_size];
        for (std::uint32_t k = 0; k < constants::group_size; ++k) {
            if (triangles.at(k).triangle != no_triangle) reach[k] = four.of(triangles.at(k));
            all.extend(reach[k]);
        }
        if (heights.size > 0) heights[group].set(reach);
#else
        const auto extent_of = [&](std::uint32_t, const PlacedTriangle& t) {
            Box extent;
            for (int c = 0; c < 3 && t.triangle != no_triangle; ++c) {
                extent.extend(frame.along(to_double(t.start[c]) - origin));
                extent.extend(frame.along(to_double(t.end[c]) - origin));
            }
            return extent;
        };
        const Box all = triangles.joined<Box>(extent_of,
                                              [](Box& sum, const Box& part) { sum.extend(part); });
#endif
        return frame.slab(all, origin);
    }
};

/// Per block: the slab and the box around its groups, and their boxes beside each other.
struct BoundBlocks {
    View<const Slab> groups;
    View<const QuickBox> group_boxes;
    View<GridBoxes> packed;
    View<Slab> slabs;
    View<QuickBox> boxes;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t block = Sixteen<Slab>::group_of(i),
                            first = block * constants::group_size;
        Sixteen<QuickBox> parts;
        parts.each(
            [&](std::uint32_t k, QuickBox& part) { part = read_whole(group_boxes[first + k]); });
        const QuickBox box = box_around(parts);
        pack(packed[block], parts, box);
        Sixteen<Slab> held;
        held.each([&](std::uint32_t k, Slab& slab) { slab = read_whole(groups[first + k]); });
        const Slab slab = box.empty() ? Slab{} : slab_around(held, box);
        if (!Sixteen<Slab>::is_first()) return;
        write_whole(boxes[block], box);
        write_whole(slabs[block], slab);
    }

private:
    PIERCE_HD static Slab slab_around(const Sixteen<Slab>& held, const QuickBox& box) {
        const SlabFrame frame(held.joined<Vec3d>(
            [](std::uint32_t, const Slab& slab) { return to_double(slab.axis[0]); },
            [](Vec3d& all, Vec3d part) { all += part; }));
        const Vec3d origin = to_double(box.lower);
        const auto extent_of = [&](std::uint32_t, const Slab& slab) {
            if (!slab.holds_something()) return Box{};
            const Vec3d middle = frame.along(to_double(slab.center) - origin);
            Vec3d reach;
            for (int axis = 0; axis < 3; ++axis) {
                reach[axis] = static_cast<double>(slab.rounding);
                for (int j = 0; j < 3; ++j)
                    reach[axis] += static_cast<double>(slab.half[j]) *
                                   std::fabs(dot(frame.axis[axis], to_double(slab.axis[j])));
            }
            return Box{middle - reach, middle + reach};
        };
        return frame.slab(
            held.joined<Box>(extent_of, [](Box& all, const Box& part) { all.extend(part); }),
            origin);
    }
};

/// Per section: where its blocks are, and their boxes beside each other.
struct BoundSections {
    View<const std::uint32_t> section_offsets, block_offsets, blocks;  ///< per body
    View<const QuickBox> block_boxes;
    View<GridBoxes> packed;
    View<std::uint32_t> begins, ends;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t section = Sixteen<QuickBox>::group_of(i);
        const OwnedItem item = owned_item(section_offsets, section);
        const std::uint32_t place = item.index * constants::group_size,
                            offset = block_offsets[item.owner];
        const std::uint32_t begin = offset + place;
        const std::uint32_t end = offset +
                                  min_of(place + constants::group_size, blocks[item.owner]);
        Sixteen<QuickBox> parts;
        parts.each([&](std::uint32_t k, QuickBox& part) {
            part = begin + k < end ? read_whole(block_boxes[begin + k]) : QuickBox{};
        });
        pack(packed[section], parts, box_around(parts));
        if (!Sixteen<QuickBox>::is_first()) return;
        begins[section] = begin;
        ends[section] = end;
    }
};

}  // namespace pierce::stages
