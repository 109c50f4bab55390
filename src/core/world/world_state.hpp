#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/base/slot_map.hpp"
#include "core/base/usable.hpp"
#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/world/memory_rest.hpp"
#include "core/world/pair_copy.hpp"
#include "pierce/backend.hpp"
#include "pierce/world.hpp"

namespace pierce {

/// True if a body can be there: all coordinates are finite and none is too large.
bool is_usable(std::span<const Vec3f> positions);

/// Keys of saved worlds are not larger, so that none comes again.
inline constexpr std::uint64_t largest_key = ~std::uint64_t{0} >> 1;

/// A mesh of a world.
struct MeshEntry {
    std::shared_ptr<const Mesh> mesh;
    std::uint64_t key = 0;
};

/// A body of a world.
struct BodyEntry {
    BodyEntry() = default;
    BodyEntry(MeshId its_mesh, Motion its_motion, const Pose& its_pose)
        : mesh(its_mesh), motion(its_motion), pose(its_pose) {}

    MeshId mesh;
    Motion motion = Motion::fixed;
    Pose pose;
    std::vector<Vec3f> positions;  ///< of a deforming body
    std::vector<Vec3f> start;  ///< of a deforming body that has moved: where it was when the step
                               ///< began
    Pose start_pose;           ///< of any other body that has moved: its pose when the step began
    bool moved = false;        ///< since the last step
    Collision collision;
    Filter filter;
    const Vec3f* device_positions = nullptr;  ///< in place of `positions`
    const Vec3f* device_start = nullptr;
    DevicePose device_pose;                 ///< in place of `pose`
    const Vec3f* last_positions = nullptr;  ///< in device memory, where the last step read them
    std::vector<PatchBlock> blocks;         ///< of a deforming body
    std::vector<Offsets> patches;
    std::vector<BoxNode> box_nodes;
    std::vector<SeenPatch> seen;
    std::uint64_t positions_version = 0;  ///< another one whenever `positions` are others, or
                                          ///< elsewhere in memory
    bool usable = true;                   ///< all coordinates are finite and none is too large
    std::uint32_t part = 0;  ///< which of the worlds that share their bodies owns this one
    bool away = false;       ///< it belongs to another one, and is not near

    /// True if the host does not know where the body is.
    bool is_on_device() const { return device_positions != nullptr || device_pose.exists(); }
    /// True if the place that the entry has is one.
    bool is_placed() const;
    /// The last step has not seen the body: it begins where it is put first.
    void forget_start() {
        start_pose.position.x = NAN;
        if (!start.empty()) start[0].x = NAN;
    }
    void leave_device() {
        device_positions = device_start = last_positions = nullptr;
        device_pose = {};
    }
};

/// What bodies there are, as far as it decides what all steps do.
struct BodyKinds {
    bool solids = false;  ///< some body has an inside that counts
    bool deforming = false;
    bool margins = false;  ///< some body is in contact before it touches
    bool sheets = false;
    bool velocity_rays = false;  ///< some sheet is looked for in itself by rays along velocities
    bool meets_itself = false;   ///< some solid is looked for in itself
    bool worlds = false;         ///< some body is in one world only
    std::uint32_t feature_bits = 0;  ///< of the largest number of a vertex, edge or triangle

    void add(const BodyKinds& other);
    friend bool operator==(const BodyKinds&, const BodyKinds&) = default;
};

/// Two bodies, the one in the lower slot first.
struct BodyIdPair {
    BodyId a, b;

    BodyIdPair() = default;
    BodyIdPair(BodyId one, BodyId other) : a(std::min(one, other)), b(std::max(one, other)) {}

    friend auto operator<=>(const BodyIdPair&, const BodyIdPair&) = default;
};

/// Throws InputError unless there are as many positions as the mesh has.
void check_count(std::size_t given, const Mesh& mesh);

/// What a World is made of; world.cpp changes it, and world_plan.cpp derives the step's input from
/// it.
struct World::State {
    std::unique_ptr<Backend> backend;
    Settings settings;
    SlotMap<MeshTag, MeshEntry> meshes;
    SlotMap<BodyTag, BodyEntry> bodies;
    std::uint64_t next_key = 1;
    std::set<BodyIdPair> excluded;    ///< pairs that are not wanted
    PairFilter pair_filter;           ///< of the caller; empty: none
    std::uint32_t part = 0;           ///< of the worlds that share their bodies, this one
    BodyKinds elsewhere;              ///< the bodies of the others
    std::set<std::int32_t> left_out;  ///< worlds that take no part in steps
    bool forgets_sides = false;       ///< the next step forgets the sides of sheets
    bool stepped = false;             ///< bodies are where the last step saw them
    bool still = false;               ///< nothing had changed in the last step

    // What a step reads. It is made anew when bodies are added, removed or change kind, and adapted
    // when some have only got other meshes.
    bool planned = false, planning = false;
    std::optional<std::vector<std::uint32_t>> reshaped;  ///< what is not planned: these bodies have
                                                         ///< other meshes, and nothing else
    Plan plan;
    Plan resting_plan;  ///< the same without memory
    MemoryRest rest;
    std::vector<View<SeenPatch>> not_seen;  ///< what a resting step compares deforming bodies with
    std::vector<std::uint32_t> changed;     ///< bodies whose views are out of date
    std::vector<std::uint32_t> changed_last;  ///< before the last step, where a motion ended
    std::vector<std::uint32_t> refreshed;     ///< for the last step
    std::set<std::uint32_t> unusable;         ///< bodies that take no part
    std::vector<BodyView> views;
    std::vector<BodyId> ids;
    std::vector<BlockItem> block_items;
    std::vector<BlockRange> ranges;
    std::vector<View<PatchBlock>> blocks;
    std::vector<View<Offsets>> patches;
    std::vector<NodeItem> node_items;
    LevelBegins level_begin{};
    std::vector<View<BoxNode>> box_nodes;
    std::vector<View<SeenPatch>> seen;
    std::vector<Pair> excluded_pairs;         ///< of bodies that are there, sorted
    std::vector<std::int32_t> worlds;         ///< sorted; without all_worlds
    std::vector<std::uint32_t> world_begins;  ///< as Scene has it
    StepStats stats;
    std::unique_ptr<PairCopy> pair;  ///< what parting() moves, once it was called

    /// Bodies by world, as they were when `filters_set` and arrivals together were `at`. Bodies
    /// that were removed since then may still be listed.
    struct {
        std::uint64_t at = 0;
        std::vector<std::pair<std::int32_t, std::uint32_t>> sorted;  ///< world and slot
    } by_world;
    std::uint64_t filters_set = 1;

    const Mesh& mesh_of(const BodyEntry& body) const { return *meshes.get(body.mesh, "mesh").mesh; }

    BodyId add(BodyEntry body) {
        change();
        return bodies.add(std::move(body));
    }
    /// What steps ask for pairs.
    const PairFilter* asked_filter() const { return pair_filter ? &pair_filter : nullptr; }
    /// True if a step would find the contacts of the last one.
    bool is_at_rest() const {
        return planned && still && changed.empty() && !forgets_sides &&
               may_keep_contacts(plan, asked_filter());
    }
    /// Throws InputError while a plan is made, which reads bodies.
    void check_not_planning() const;
    /// To be called before bodies are added, removed or changed.
    void change() {
        check_not_planning();
        planned = stepped = still = false;
        reshaped.reset();
    }
    /// To be called instead if a body only gets another mesh.
    void change_mesh(BodyId body);
    /// How many of the changed bodies may have moved. A plan made anew, or a restored world, does
    /// not move any.
    std::size_t moved_bodies() const;
    /// Throws InputError unless bodies are where the last step saw them.
    void check_stepped(const char* who) const;

    /// The numbers of all bodies.
    std::vector<std::uint32_t> used_bodies() const;
    /// Brings the places of bodies, by number, into their entries where they are in device memory,
    /// which stays where steps read them; without starts, only where steps end.
    void bring_places(std::span<const std::uint32_t> some, bool with_starts = true);
    /// The body, with its place.
    const BodyEntry& placed_body(BodyId body);
    /// Throws InputError for a body that deforms.
    void check_have_poses(std::span<const BodyId> some) const;
    /// Throws InputError for a body that does not deform.
    void check_has_positions(BodyId body) const;
    /// Lets steps read a deforming body's positions in device memory; `start` may be null.
    void put_on_device(BodyId body, const Vec3f* start, const Vec3f* positions);
    /// Throws InputError, naming the body, for a Collision that the body cannot have.
    void check_collision(Motion motion, const Mesh& mesh, const Collision& collision,
                         const std::string& name) const;
    /// Throws InputError for a world that cannot be.
    static void check_filter(const Filter& filter);
    /// The bodies of a world, in the order of their slots.
    std::vector<BodyId> bodies_of(std::int32_t world);
    /// To be called before a body is put into a world: one without bodies is not left out.
    void begin_world(std::int32_t world);
    /// Throws InputError for a body that cannot have been saved.
    void check_restored(const BodyEntry& body) const;
    BodyKinds kinds_of(const BodyEntry& body) const;
    /// Makes what does not change between steps. Throws InputError if it is doing so.
    void make_plan();
    /// The same where a plan is there and the bodies have only got other meshes; false if that
    /// changes what steps do.
    bool adapt_plan(std::span<const std::uint32_t> some);
    void decide_plan();
    void finish_plan();
    void make_view(std::uint32_t index);
    void arrange_worlds();
    /// What the next step reads; `rests`: it remembers nothing. `forgets`: 1 if sheets forget their
    /// sides; it must stay until the step is done.
    Scene scene(bool rests, const std::uint32_t& forgets);
    /// [length] How near other solids are in contact with the body.
    double margin_of(const BodyEntry& body) const;
    void list_blocks();
    void list_nodes();
    void describe_bodies();
    /// Throws InputError for bodies that do not exist, and for a body and itself.
    void check_pair(BodyId a, BodyId b) const;
    /// To be called before a body gets a new place: its present place becomes the place where the
    /// step begins. The positions of a deforming body are undefined afterwards.
    BodyEntry& begin_motion(BodyId body);
    /// Brings the place where the last step left a body into its entry; false if it is not known.
    bool bring_last_place(std::uint32_t index);
    /// Gives a fixed or rigid body a new pose.
    BodyEntry& place(BodyId body, const Pose& pose);
    /// To be called whenever a body has got another place, or takes part or not.
    void note_change(BodyId body);
    /// To be called after a step: the next step begins where this one has ended, whatever poses or
    /// positions are set.
    void end_motion();
    /// Updates what may have changed since the last step: of all bodies after a new plan, else of
    /// those that have changed.
    void refresh_views();
    void refresh_view(std::uint32_t index);
    /// Sets, in a deforming body's view, where its vertices are kept.
    void place_vertices(std::uint32_t index);
};

/// What those see of a world that share bodies between several.
struct WorldInside {
    using State = World::State;
    static State& state(World& world) { return *world.state_; }
};

}  // namespace pierce
