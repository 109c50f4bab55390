#pragma once

#include "pierce/core/body.hpp"
#include "pierce/core/interleaved.hpp"
#include "pierce/core/moving_point.hpp"
#include "pierce/core/stages/grid_boxes.hpp"
#include "pierce/core/stages/placed_triangle.hpp"
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

/// Per place of a group: its triangle over the step, as a whole and as culling sees it, and the box of that.
struct PlaceTriangles {
    SheetBodies bodies;
    View<const std::uint32_t> block_offsets;  ///< per body
    Interleaved<PlacedTriangle> placed;
    Interleaved<DriftingTriangle> drifting;
    View<QuickBox> boxes;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const OwnedItem block = owned_item(block_offsets, i / triangles_per_block);
        const SheetBody body = bodies[block.owner];
        const std::uint32_t place = i - block_offsets[block.owner] * triangles_per_block;
        PlacedTriangle p;
        QuickBox box;
        if (place < body.mesh.triangles.size && body.view.active) {
            p.triangle = body.mesh.group_triangles[place];
            p.own = body.mesh.features[p.triangle].own;
            const Triangle t = body.mesh.triangles[p.triangle];
            for (int k = 0; k < 3; ++k) {
                const MovingVertex v = read_whole(body.vertices[t.vertex[k]]);
                p.start[k] = v.start;
                p.end[k] = v.end;
                box.extend(v.start);
                box.extend(v.end);
            }
        }
        placed.write(i, p);
        drifting.write(i, DriftingTriangle(p));
        write_whole(boxes[i], box);
    }
};

/// Where the parts of sections, blocks or groups are: among all blocks, groups or places of triangles.
struct Parts {
    View<const std::uint32_t> begins, ends;  ///< empty: one after the other, sixteen each

    PIERCE_HD std::uint32_t begin(std::uint32_t whole) const {
        return begins.size > 0 ? begins[whole] : whole * constants::group_size;
    }
    PIERCE_HD bool has(std::uint32_t whole, std::uint32_t k) const {
        return ends.size == 0 || begins[whole] + k < ends[whole];
    }
};

/// Per sixteenth of a section, block or group: its box, beside the fifteen others.
struct PackBoxes {
    Parts parts;
    View<const QuickBox> wholes, boxes;
    View<GridBoxes> packed;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t whole = i / constants::group_size, k = i % constants::group_size;
        const BoxSteps steps(read_whole(wholes[whole]));
        if (k == 0) write_whole(packed[whole].steps, steps);
        packed[whole].set(k, steps, parts.has(whole, k) ? read_whole(boxes[parts.begin(whole) + k]) : QuickBox{});
    }
};

/// Per group: the slab and the box around its triangles.
struct BoundGroups {
    Interleaved<const PlacedTriangle> placed;
    View<const QuickBox> triangle_boxes;
    View<Slab> slabs;
    View<QuickBox> boxes;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t first = i * constants::group_size;
        QuickBox box;
        Vec3d normal;
        PIERCE_OVERLAPPED_LOOP
        for (std::uint32_t k = 0; k < constants::group_size; ++k) {
            box.extend(read_whole(triangle_boxes[first + k]));
            normal += placed.read(first + k).end_normal();  // zero where there is none
        }
        write_whole(boxes[i], box);
        if (box.empty()) return write_whole(slabs[i], {});
        const Vec3d origin = to_double(placed.read(first).end[0]);
        const SlabFrame frame(normal);
        Box extent;
        PIERCE_OVERLAPPED_LOOP
        for (std::uint32_t k = 0; k < constants::group_size; ++k) {
            const PlacedTriangle t = placed.read(first + k);
            if (t.triangle == no_triangle) continue;
            for (int c = 0; c < 3; ++c) {
                extent.extend(frame.along(to_double(t.start[c]) - origin));
                extent.extend(frame.along(to_double(t.end[c]) - origin));
            }
        }
        write_whole(slabs[i], frame.slab(extent, origin));
    }
};

/// Per block: the slab and the box around its groups.
struct BoundBlocks {
    View<const Slab> groups;
    View<const QuickBox> group_boxes;
    View<Slab> slabs;
    View<QuickBox> boxes;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t first = i * constants::group_size;
        QuickBox box;
        Vec3d normal;
        PIERCE_OVERLAPPED_LOOP
        for (std::uint32_t k = 0; k < constants::group_size; ++k) {
            box.extend(read_whole(group_boxes[first + k]));
            normal += to_double(groups[first + k].axis[0]);
        }
        write_whole(boxes[i], box);
        if (box.empty()) return write_whole(slabs[i], {});
        const Vec3d origin = to_double(groups[first].center);
        const SlabFrame frame(normal);
        Box extent;
        for (std::uint32_t k = 0; k < constants::group_size; ++k) {
            const Slab held = read_whole(groups[first + k]);
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
        write_whole(slabs[i], frame.slab(extent, origin));
    }
};

/// Per section: where its blocks are, and the box around them.
struct BoundSections {
    View<const std::uint32_t> section_offsets, block_offsets, blocks;  ///< per body
    View<const QuickBox> block_boxes;
    View<std::uint32_t> begins, ends;
    View<QuickBox> boxes;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const OwnedItem item = owned_item(section_offsets, i);
        const std::uint32_t first = item.index * constants::group_size, offset = block_offsets[item.owner];
        begins[i] = offset + first;
        ends[i] = offset + min_of(first + constants::group_size, blocks[item.owner]);
        QuickBox box;
        PIERCE_OVERLAPPED_LOOP
        for (std::uint32_t block = begins[i]; block < ends[i]; ++block) box.extend(read_whole(block_boxes[block]));
        write_whole(boxes[i], box);
    }
};
}  // namespace pierce::stages
