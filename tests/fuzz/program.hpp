#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pierce/body.hpp"
#include "pierce/filter.hpp"
#include "pierce/mesh.hpp"
#include "pierce/pose.hpp"
#include "pierce/settings.hpp"

namespace pierce::fuzz {

/// A call of a World's member of the same name. Meshes and bodies are named by their number among
/// all that the program has tried to add.
struct Call {
    enum class Kind : std::uint8_t {
        add_mesh,
        remove_mesh,
        add_fixed_body,
        add_rigid_body,
        add_deforming_body,
        remove_body,
        set_collision,
        set_pose,
        set_positions,
        set_pose_motion,      ///< set_motion of a fixed or rigid body
        set_position_motion,  ///< set_motion of a deforming body
        set_mesh,
        set_filter,
        exclude,
        include,
        replicate,  ///< the new bodies have no numbers
        copy_places,
        remove_world,
        set_world_active,
        forget_sides,
        detect,
        explain,
        cast_rays,
        probe,
        overlap,
        parting,
        impacts,
        restore,  ///< save(), and restore() into a new world
    };

    static constexpr std::uint32_t no_mesh = 0xffffffffu;

    Kind kind = Kind::detect;
    std::uint32_t mesh = 0;
    std::uint32_t body = 0;
    std::uint32_t other = 0;   ///< body, of calls that name two
    std::uint32_t vertex = 0;  ///< of explain
    MeshData data{};
    Inside inside = Inside::automatic;  ///< of add_mesh, like the next one
    std::uint32_t before = no_mesh;     ///< the mesh that it comes from
    Pose start_pose{}, pose{};          ///< the position of `pose` is the origin of cast_rays, too
    std::vector<Vec3f> start{}, positions{};  ///< normals and points of probe, and directions of
                                              ///< cast_rays, too
    Collision collision{};
    Filter filter{};
    std::int32_t world = 0, other_world = 0;  ///< copy_places has both
    std::uint32_t count = 0;                  ///< of replicate, and the most per pair of impacts
    bool active = true;                       ///< of set_world_active
    double radius = 0;                        ///< of probe
};

/// What a world is made with, and what is asked of it, one call after the other.
struct Program {
    Settings settings;
    std::vector<Call> calls;
};

const char* name_of(Call::Kind kind);

/// As JSON, a line per call. Numbers are exact.
std::string to_text(const Program& program);
/// Throws std::runtime_error for what is no program.
Program program_of(const std::string& text);

}  // namespace pierce::fuzz
