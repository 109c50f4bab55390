#pragma once

#include "core/device/bits.hpp"
#include "core/device/view.hpp"
#include "core/geometry/grid_boxes.hpp"
#include "core/geometry/sixteen_boxes.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/ids.hpp"

/// A tree of boxes around a mesh's triangles, sixteen a node. It has no pointers: the leaves are
/// the groups of triangles in the order of MeshArrays::group_triangles, and every sixteen nodes of
/// a level, one after the other, are the children of a node of the next.
namespace pierce {

/// Where the levels of a tree of boxes begin among its nodes: leaves first, the root last.
struct BoxLevels {
    static constexpr std::uint32_t most = 8;  ///< enough for 16^8 triangles

    std::uint32_t begin[most + 1] = {};
    std::uint32_t count = 0;

    PIERCE_HD explicit BoxLevels(std::uint32_t triangles) {
        std::uint32_t nodes = triangles;
        do {
            nodes = (nodes + constants::group_size - 1) / constants::group_size;
            begin[count + 1] = begin[count] + nodes;
            ++count;
        } while (nodes > 1);
    }

    PIERCE_HD std::uint32_t nodes() const { return begin[count]; }
    PIERCE_HD std::uint32_t level_of(std::uint32_t node) const {
        std::uint32_t level = 0;
        while (!(node < begin[level + 1])) ++level;
        return level;
    }
};

/// The box of a triangle.
PIERCE_HD inline QuickBox box_of(const MeshView& mesh, View<const Vec3f> positions,
                                 std::uint32_t triangle) {
    QuickBox box;
    for (std::uint32_t v : mesh.triangles[triangle].vertex) box.extend(positions[v]);
    return box;
}

/// Measures a node of the mesh's tree at `positions`, on a GPU by sixteen threads; the nodes of the
/// level below are measured.
PIERCE_HD inline void measure_node(const MeshView& mesh, View<const Vec3f> positions,
                                   const BoxLevels& levels, std::uint32_t node,
                                   View<BoxNode> nodes) {
    const std::uint32_t level = levels.level_of(node);
    const std::uint32_t first = (node - levels.begin[level]) * constants::group_size;
    const std::uint32_t below = level == 0 ? mesh.group_triangles.size
                                           : levels.begin[level] - levels.begin[level - 1];
    Sixteen<QuickBox> boxes;
    boxes.each([&](std::uint32_t k, QuickBox& box) {
        box = {};
        if (!(first + k < below)) return;
        box = level == 0 ? box_of(mesh, positions, mesh.group_triangles[first + k])
                         : nodes[levels.begin[level - 1] + first + k].around;
    });
    const QuickBox around = box_around(boxes);
    pack(nodes[node].boxes, boxes, around);
    if (Sixteen<QuickBox>::is_first()) nodes[node].around = around;
}

/// Calls see(group, mask) for every group of triangles with a bit for each of its triangles whose
/// box may overlap `box`, one box or one of a few, if there are any; stops when see() returns true,
/// and returns true then.
template <class Box, class See>
PIERCE_HD bool for_each_group(View<const BoxNode> nodes, const BoxLevels& levels, const Box& box,
                              const See& see) {
    std::uint32_t place[BoxLevels::most], left[BoxLevels::most];
    std::uint32_t level = levels.count - 1;
    place[level] = 0;
    left[level] = nodes[levels.begin[level]].boxes.near(box);
    for (;;) {
        if (level == 0) {
            if (left[0] != 0 && see(place[0], left[0])) return true;
            left[0] = 0;
        }
        if (left[level] != 0) {
            const std::uint32_t child = place[level] * constants::group_size +
                                        lowest_bit(left[level]);
            left[level] &= left[level] - 1;
            --level;
            place[level] = child;
            left[level] = nodes[levels.begin[level] + child].boxes.near(box);
        } else if (++level == levels.count) {
            return false;
        }
    }
}

}  // namespace pierce
