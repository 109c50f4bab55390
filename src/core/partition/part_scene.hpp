#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/patch.hpp"
#include "core/partition/partition.hpp"
#include "pierce/plan.hpp"

namespace pierce {

/// What one part sees of a scene: the bodies that it owns, and those of other parts that are near,
/// its *ghosts*. Every body keeps its number, so that pairs have the same keys in all parts; of
/// bodies that are not resident, the place is empty. A resident ghost takes no part in steps before
/// it is near.
class PartScene {
public:
    explicit PartScene(std::uint32_t part) : part_(part) {}

    /// Brings what the part sees up to date; ghosts take part from the first time that they are
    /// near. `anew`: there are other bodies, or they have other owners.
    void show(const Scene& whole, const Partition& partition, bool anew);

    /// Takes over what the owners of ghosts that have arrived know of their shapes in the last
    /// step.
    void copy_seen(const Scene& whole);

    /// For the part's step.
    Scene scene(const Scene& whole);

    struct Sizes {
        std::uint32_t own = 0, ghosts = 0;  ///< bodies
        std::uint64_t triangles = 0;        ///< of both
    };
    /// How much of the scene takes part.
    Sizes sizes() const;

    View<BodyView> bodies() { return view_of(views_); }
    View<const BodyId> ids() const { return view_of(ids_); }
    View<const View<SeenPatch>> seen() const { return view_of(seen_); }
    /// True if nothing has changed in the last show().
    bool is_still() const { return is_still_; }
    /// Ghosts that take part since the last show().
    const std::vector<std::uint32_t>& arrived() const { return arrived_; }

private:
    /// Where a ghost's shape is kept while the part measures it.
    struct GhostShape {
        std::vector<PatchBlock> blocks;
        std::vector<Offsets> patches;
        std::vector<BoxNode> box_nodes;
        std::vector<SeenPatch> seen;
    };

    /// Makes bodies resident, and forgets all others.
    void settle(const Scene& whole, const Partition& partition, BodySet resident);
    /// True if all of these bodies are resident.
    bool has(const BodySet& bodies) const;
    /// Brings the residents up to date. `changed`: bodies whose input may differ since the last
    /// call or settle().
    void update(const Scene& whole, std::span<const std::uint32_t> changed, const BodySet& near);

    void place(const Scene& whole, std::uint32_t body, const Partition& partition);
    void list_items(const Scene& whole);
    void arrange_worlds(const Scene& whole);

    std::uint32_t part_;
    std::uint64_t revision_ = 0;
    bool is_still_ = false;
    BodySet resident_, near_, own_;
    std::vector<std::uint32_t> arrived_, changed_;
    Plan plan_;
    std::vector<BodyView> views_;
    std::vector<BodyId> ids_;
    std::vector<GhostShape> shapes_;
    std::vector<BlockItem> block_items_;
    std::uint32_t ghost_blocks_ = 0;
    std::vector<BlockRange> ranges_;
    std::vector<View<PatchBlock>> blocks_;
    std::vector<View<Offsets>> patches_;
    std::vector<View<SeenPatch>> seen_;
    std::vector<NodeItem> node_items_;
    LevelBegins level_begin_{};
    std::vector<View<BoxNode>> box_nodes_;
    std::vector<std::uint32_t> world_begins_;
};

}  // namespace pierce
