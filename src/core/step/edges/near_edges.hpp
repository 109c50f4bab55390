#pragma once

#include "core/body/body_view.hpp"
#include "core/device/loops.hpp"
#include "core/device/view.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "pierce/min_max.hpp"

/// edges, second part: which triangles of the target an edge may cross. Boxes around edges, sixteen
/// at a time, are compared with the target's tree of boxes. No triangle that an edge crosses is
/// left out.
namespace pierce::stages {

/// Boxes around a group's edges in the space of its target, larger by `margin`.
struct EdgeBoxes {
    float lower[3][Offsets::count], upper[3][Offsets::count];

    PIERCE_HD EdgeBoxes(const BodyView& source, const DirectedPair& d, const EdgeGroup& group,
                        double margin) {
        const Vec3d center = to_double(source.positions[source.mesh.edges[group.first].vertex[0]]);
        const Vec3f c = to_float(center);  // a float32 position: nothing is lost
        Offsets middles, halves;
        for (std::uint32_t k = 0; k < group.count; ++k) {
            const Edge& edge = source.mesh.edges[group.first + k];
            const Vec3f a = source.positions[edge.vertex[0]] - c,
                        b = source.positions[edge.vertex[1]] - c;
            middles.set(k, 0.5f * (a + b));
            halves.set(k, 0.5f * (b - a));
        }
        const TurnedOffsets<> middle(middles, d.to_space.rotation),
            half(halves, d.to_space.rotation);
        const Vec3d placed = d.to_space.to_parent(center);
        const double span = static_cast<double>(longest(middles)) +
                            static_cast<double>(longest(halves));
        // The centre, the rotation, the offsets and their sums are rounded to float32: each by at
        // most an ulp of its size.
        const float more = round_up(margin + 4 * constants::float_ulp *
                                                 (std::fabs(placed.x) + std::fabs(placed.y) +
                                                  std::fabs(placed.z) + 2 * span));
        const Vec3f at = to_float(placed);
        for (int r = 0; r < 3; ++r) {
            PIERCE_VECTOR_LOOP
            for (std::uint32_t k = 0; k < Offsets::count; ++k) {
                const float x = at[r] + middle.at[r][k], reach = std::fabs(half.at[r][k]) + more;
                lower[r][k] = x - reach;
                upper[r][k] = x + reach;
            }
        }
    }

    PIERCE_HD QuickBox box(std::uint32_t k) const {
        QuickBox box;
        for (int r = 0; r < 3; ++r) {
            box.lower[r] = lower[r][k];
            box.upper[r] = upper[r][k];
        }
        return box;
    }

    /// The box around the first `count`.
    PIERCE_HD QuickBox around(std::uint32_t count) const {
        QuickBox all;
        for (std::uint32_t k = 0; k < count; ++k) all.extend(box(k));
        return all;
    }

    /// A bit for each that overlaps `other`.
    PIERCE_HD std::uint32_t overlap(const QuickBox& other) const {
        std::uint32_t apart[Offsets::count] = {};
        for (int r = 0; r < 3; ++r) {
            PIERCE_VECTOR_LOOP
            for (std::uint32_t k = 0; k < Offsets::count; ++k)
                apart[k] |= static_cast<std::uint32_t>(lower[r][k] > other.upper[r]) |
                            static_cast<std::uint32_t>(upper[r][k] < other.lower[r]);
        }
        std::uint32_t mask = 0;
        for (std::uint32_t k = 0; k < Offsets::count; ++k) mask |= (apart[k] ^ 1u) << k;
        return mask;
    }
};

/// Per group of edges: lists the edges that may cross triangles of the target, and these triangles.
struct FindNearEdges {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeGroup> groups;
    bool remembers = false;

    static constexpr bool in_order = true;

    /// The first of what is found.
    struct Found {
        static constexpr std::uint32_t most = 15;

        std::uint32_t count = 0;
        std::uint32_t group[most];
        std::uint16_t mask[most];
        std::uint8_t edge[most];
        std::uint8_t padding[3];
    };

    PIERCE_HD Found find(std::uint32_t i) const {
        Found found;
        search(i, [&](std::uint32_t k, std::uint32_t group, std::uint32_t mask) {
            if (found.count < Found::most) {
                found.group[found.count] = group;
                found.mask[found.count] = static_cast<std::uint16_t>(mask);
                found.edge[found.count] = static_cast<std::uint8_t>(k);
            }
            ++found.count;
        });
        return found;
    }
    PIERCE_HD static std::uint32_t count(const Found& found) { return found.count; }
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         NearEdge* near) const {
        const EdgeGroup& edges = groups[i];
        if (found.count <= Found::most) {
            for (std::uint32_t k = 0; k < found.count; ++k)
                near[place + k] = {edges.directed, edges.first + found.edge[k], found.group[k],
                                   found.mask[k]};
            return;
        }
        search(i, [&](std::uint32_t k, std::uint32_t group, std::uint32_t mask) {
            near[place++] = {edges.directed, edges.first + k, group,
                             static_cast<std::uint16_t>(mask)};
        });
    }

private:
    /// Calls see(k, group, mask), edge after edge.
    template <class See>
    PIERCE_HD void search(std::uint32_t i, const See& see) const {
        constexpr std::uint32_t most = 16;
        const EdgeGroup edges = groups[i];
        const DirectedPair& d = directed[edges.directed];
        const View<const BoxNode> nodes = bodies[d.target].box_nodes;
        const BoxLevels levels(bodies[d.target].mesh.triangles.size);
        const EdgeBoxes boxes(
            bodies[d.source], d, edges,
            edge_margin(directed, edges.directed) + (remembers ? edge_skin(bodies, d) : 0.0));
        std::uint32_t group[most], overlap[most], count = 0, any = 0;
        for_each_group(nodes, levels, boxes.around(edges.count),
                       [&](std::uint32_t g, std::uint32_t) {
                           if (count < most) {
                               group[count] = g;
                               overlap[count] = boxes.overlap(nodes[g].around);
                               any |= overlap[count];
                           }
                           ++count;
                           return false;
                       });
        if (count > most) any = ~0u;
        for (any &= (1u << edges.count) - 1; any != 0; any &= any - 1) {
            const std::uint32_t k = lowest_bit(any);
            const QuickBox box = boxes.box(k);
            if (count > most) {
                for_each_group(nodes, levels, box, [&](std::uint32_t g, std::uint32_t mask) {
                    see(k, g, mask);
                    return false;
                });
                continue;
            }
            for (std::uint32_t n = 0; n < count; ++n) {
                if (!(overlap[n] >> k & 1)) continue;
                const std::uint32_t mask = nodes[group[n]].boxes.near(box);
                if (mask != 0) see(k, group[n], mask);
            }
        }
    }
};

}  // namespace pierce::stages
