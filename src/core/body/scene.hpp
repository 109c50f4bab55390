#pragma once

#include <array>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "pierce/body.hpp"
#include "pierce/filter.hpp"
#include "pierce/min_max.hpp"
#include "pierce/plan.hpp"

namespace pierce {

/// No body has this number: in a list with room for more, what follows the last item.
inline constexpr std::uint32_t no_body = 0xffffffffu;

/// A block of a deforming body's patches.
struct BlockItem {
    std::uint32_t body = no_body;
    std::uint32_t block = 0;

    PIERCE_HD std::uint32_t first_patch() const { return block * constants::block_size; }
    PIERCE_HD std::uint32_t last_patch(const MeshView& mesh) const {
        return min_of((block + 1) * constants::block_size, patch_count(mesh));
    }
};

/// The blocks of one deforming body.
struct BlockRange {
    std::uint32_t body = 0;
    std::uint32_t first = 0;
    std::uint32_t last = 0;
};

/// A node of a deforming body's tree of boxes.
struct NodeItem {
    std::uint32_t body = no_body;
    std::uint32_t node = 0;
};

/// Where the levels of all trees of boxes begin in a list of their nodes, and where the last ends.
using LevelBegins = std::array<std::uint32_t, BoxLevels::most + 1>;

/// All that a step reads of a world, and what the step keeps up to date there: bounds and fits of
/// the bodies.
struct Scene {
    View<BodyView> bodies;
    View<const BodyId> ids;
    View<const std::uint32_t> changed;        ///< bodies whose input may differ from that of the
                                              ///< last step; the rest is as it was
    View<const Pair> excluded;                ///< pairs that the caller does not want, sorted
    const PairFilter* pair_filter = nullptr;  ///< asked for other pairs; null: none
    View<const std::uint32_t> world_begins;   ///< where, in the order of worlds, the bodies of each
                                              ///< begin, then those that are in all worlds, and
                                              ///< where those end; empty if there are no worlds
    View<const BlockItem> block_items;        ///< of deforming bodies, ghosts last
    std::uint32_t ghost_blocks = 0;           ///< how many of these are of bodies of other parts
    View<const BlockRange> ranges;            ///< per deforming body, its blocks
    View<const View<PatchBlock>> blocks;      ///< per body, where a deforming body's spheres go
    View<const View<Offsets>> patches;        ///< per body, where its vertices' offsets go
    View<const View<SeenPatch>> seen;     ///< per body, where its shape of the last step is kept;
                                          ///< empty: nowhere
    View<const NodeItem> node_items;      ///< of deforming solids where the plan needs boxes,
                                          ///< level after level, leaves first
    LevelBegins level_begin{};            ///< where the levels begin there
    View<const View<BoxNode>> box_nodes;  ///< per body, where a deforming body's boxes go
    const Plan* plan = nullptr;
    bool meshes_change = false;  ///< a step may be repeated as it was issued, after bodies have got
                                 ///< meshes of other sizes
    std::uint32_t part = 0;      ///< of the backends that share a scene, the one that steps
    View<const std::uint32_t> forgets_sides;  ///< one number; if it is not 0, sheets forget the
                                              ///< last step

    std::uint32_t own_blocks() const { return block_items.size - ghost_blocks; }
};

/// True if pairs in which nothing changes may keep their contacts without being looked at.
inline bool may_keep_contacts(const Plan& plan, const PairFilter* filter) {
    return !plan.sheets && filter == nullptr && plan.settings.temporal != Temporal::paper;
}

}  // namespace pierce
