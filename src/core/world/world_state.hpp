#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/slot_map.hpp"
#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/backend.hpp"
#include "pierce/world.hpp"

namespace pierce {

/// True for a place where a body can be: all coordinates are finite and none is too large, and a
/// rotation is one.
bool is_usable(const Pose& pose);
bool is_usable(std::span<const Vec3f> positions);

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
    Pose start_pose;           ///< of any other, likewise
    bool moved = false;        ///< since the last step
    Collision collision;
    const Vec3f* device_positions = nullptr;  ///< in place of those
    const Vec3f* device_start = nullptr;
    std::vector<PatchBlock> blocks;  ///< of a deforming body
    std::vector<Offsets> patches;
    std::vector<SeenPatch> seen;
    std::uint64_t positions_version = 0;
    bool usable = true;  ///< all coordinates are finite and none is too large
};

/// What a World is made of; world.cpp changes it, and world_plan.cpp derives the step's input from
/// it.
struct World::State {
    std::unique_ptr<Backend> backend;
    Settings settings;
    SlotMap<MeshTag, MeshEntry> meshes;
    SlotMap<BodyTag, BodyEntry> bodies;
    std::uint64_t next_key = 1;
    bool forgets_sides = false;  ///< the next step does
    bool stepped = false;        ///< bodies stand as the last step has seen them

    // What a step reads; remade when bodies are added, removed or change kind.
    bool planned = false;
    Plan plan;
    std::vector<BodyView> views;
    std::vector<BodyId> ids;
    std::vector<BlockItem> block_items;
    std::vector<BlockRange> ranges;
    std::vector<View<PatchBlock>> blocks;
    std::vector<View<Offsets>> patches;
    std::vector<View<SeenPatch>> seen;
    StepStats stats;

    const Mesh& mesh_of(const BodyEntry& body) const { return *meshes.get(body.mesh, "mesh").mesh; }

    BodyId add(BodyEntry body) {
        change();
        return bodies.add(std::move(body));
    }
    /// Bodies are about to be added, removed or changed.
    void change() { planned = stepped = false; }
    /// Throws InputError unless bodies stand as the last step has seen them.
    void check_stepped(const char* who) const;

    /// Throws InputError, naming the body, for what it cannot be in contact with.
    void check_collision(const BodyEntry& body, const Collision& collision,
                         const std::string& name) const;
    /// Throws InputError for a body that cannot have been saved.
    void check_restored(const BodyEntry& body) const;
    /// What does not change between steps.
    void make_plan();
    void add_blocks(std::uint32_t body);
    void describe(const BodyEntry& body, const Mesh& mesh);
    /// A body is about to get a new place: where it is, is where the next step begins. Of a
    /// deforming body, the positions are anything then.
    void begin_motion(BodyEntry& body);
    /// The step is over: the next one begins where it has ended, whatever is given.
    void end_motion();
    /// What may have changed since the last step.
    void refresh_views();
    /// Where a deforming body's vertices are kept, in its view.
    void place_vertices(std::uint32_t index);
};

}  // namespace pierce
