#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pierce/backend.hpp"
#include "pierce/ids.hpp"
#include "pierce/mesh.hpp"
#include "pierce/settings.hpp"
#include "pierce/step_stats.hpp"
#include "pierce/tree_builder.hpp"
#include "pierce/vec3.hpp"

namespace pierce::scenes {

/// The method that finds the contacts.
enum class Method : std::uint8_t {
    rays,
    gjk_epa,
    gjk_hull,
    gimpact,
    fcl,
    bullet_clusters,  ///< for sheets: Bullet's own method for soft bodies that meet themselves
};

inline constexpr std::array<std::pair<const char*, Method>, 6> method_names = {
    {{"rays", Method::rays},
     {"gjk-epa", Method::gjk_epa},
     {"gjk-hull", Method::gjk_hull},
     {"gimpact", Method::gimpact},
     {"fcl", Method::fcl},
     {"bullet-clusters", Method::bullet_clusters}}};

/// Throws InputError for an unknown name.
Method method_named(const std::string& name);

/// The backend that traces the rays.
struct RaySettings {
    std::string backend = "embree";  ///< or "automatic", "cuda", "bvh" or "reference"
    int threads = 0;                 ///< 0: all threads of the machine
    Settings world = {};
    std::optional<TreeBuilder> builder = {};  ///< of "bvh" and "cuda"; none: the backend's own
    bool rebuild = false;                     ///< of these two: trees are built in every step
    bool graph = true;                        ///< of "cuda": false to time stage by stage
    Inside inside = Inside::automatic;        ///< of meshes that do not say
    std::filesystem::path mesh_cache = {};    ///< of what is measured of meshes; empty: none
    /// Told how far meshes are (MeshOptions).
    std::function<void(std::string_view what, double share)> mesh_progress = {};
    /// Makes the backend that this process has in common with others from its own; empty: it is
    /// alone.
    std::function<std::unique_ptr<Backend>(std::unique_ptr<Backend>)> shared = {};
    int parts = 1;  ///< so many backends share a world: of "cuda" one per device, of others with a
                    ///< part of the threads
    double host_share = 0;  ///< of the work of one device, which Embree does beside "cuda"

    MeshOptions mesh_options() const {
        return {.inside = inside,
                .cache = mesh_cache,
                .threads = static_cast<std::uint32_t>(threads),
                .progress = mesh_progress};
    }
};

/// True if this build has CUDA and there is a device for it.
bool cuda_can_run();

/// Throws InputError for an unknown backend, negative threads, less than one part, or
/// a share of the host without a device.
std::unique_ptr<Backend> make_backend(const RaySettings& settings);

/// How long a part of a frame took; the method names the part.
struct NamedTime {
    std::string name;
    double milliseconds = 0;
};

/// How long one frame's detection took and what it found, in the same terms for every method.
/// Counts that a method does not have are zero.
struct FrameResult : StepStats {
    std::vector<NamedTime> times;
    double update_ms = 0;    ///< boxes, pairs, acceleration structures
    double narrow_ms = 0;    ///< which bodies touch, and where
    double response_ms = 0;  ///< depth and normal, in the form a solver works on
    double total_ms = 0;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> touching;     ///< indices into the scene's
                                                                       ///< bodies, sorted
    std::vector<std::pair<std::uint32_t, std::uint32_t>> penetrating;  ///< of these, with a contact
                                                                       ///< of some depth
    std::uint64_t hash = 0;
    // Results of sheets.
    std::uint32_t rounds = 0;          ///< rounds of moving sheets apart
    std::uint32_t pulled_back = 0;     ///< vertices that had to go back to where the step began, or
                                       ///< towards it
    std::uint32_t held_bodies = 0;     ///< free bodies that had to stay where the step began
    std::uint32_t crossings_left = 0;  ///< meetings left with bodies that sheets cannot move
    std::uint32_t self_crossings = 0;  ///< edges of a simulated sheet through triangles of its own
                                       ///< at the end of the step
    double self_penetration = 0;       ///< [length] the deepest of these; 0 if there are none
    std::uint32_t tears = 0;           ///< vertices that were split before the step

    /// Appends the times of a step's stages to `times`, by their names.
    void name_stages(const std::vector<StageTime>& its_stages);
    /// For a step in which nothing was looked for.
    void forget_times();
};

/// A contact in the same terms for every method: bodies by their index in the scene, a < b.
struct MethodContact {
    std::uint32_t a = 0, b = 0;
    std::uint32_t source = 0;  ///< the body a vertex of which is inside the other one; a if no
                               ///< vertex is named
    std::uint32_t vertex = no_vertex;  ///< of the source; no_vertex for anything else
    double depth = 0;                  ///< [length] zero where the bodies only touch
    Vec3d normal;                      ///< unit, from a to b
};

}  // namespace pierce::scenes
