#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pierce/body.hpp"
#include "pierce/filter.hpp"
#include "pierce/mesh.hpp"
#include "pierce/pose.hpp"

namespace pierce::scenes {

/// A mesh of a scene.
struct SceneMesh {
    std::string name;
    MeshData data;
    std::vector<std::vector<Vec3f>> convex_pieces;  ///< point sets whose hulls make up the mesh;
                                                    ///< may be empty
    Inside inside = Inside::automatic;              ///< sheets have none
};

/// The material of a sheet, in Bullet's terms.
struct SheetMaterial {
    double area_density = 0.2;  ///< [kg/m^2]
    double stretch = 1.0;       ///< of links along edges [0..1]
    double bend = 0.005;        ///< of links across edges [0..1]
    double damping = 0.01;      ///< share of velocity lost in a step
    int iterations = 16;        ///< over all links in a step
};

/// Vertices whose motion is given.
struct Guide {
    std::vector<std::uint32_t> vertices;
    /// Where a vertex is at `time` [s] after the start; `start`: its place at the start. Nothing:
    /// the vertex is let go for good.
    std::function<std::optional<Vec3d>(Vec3d start, double time)> place;
};

/// How a soft body tears.
struct TearSettings {
    double limit = 1.5;              ///< a link that is stretched to more times its length tears
    std::uint32_t most_at_once = 1;  ///< nodes that are split in a step
    std::uint32_t least_part = 40;   ///< triangles that hang together at least
};

/// A body of a scene at its start.
struct SceneBody {
    std::string name;
    std::uint32_t mesh = 0;  ///< index into Scene::meshes
    Motion motion = Motion::rigid;
    Pose pose;            ///< of a deforming body: where its rest shape is placed at the start
    bool ground = false;  ///< no body gets below or beside it, so Bullet's own methods may use the
                          ///< plane through its top
    Collision collision = {};     ///< of a deforming body
    double shape_matching = 0.3;  ///< of a deforming solid: how fast it goes back to its shape [1 /
                                  ///< step]
    int solid_iterations = 8;     ///< of a deforming solid: over all links in a step
    std::vector<std::pair<std::uint32_t, std::uint32_t>> struts = {};  ///< of a deforming solid:
                                                                       ///< vertices that are linked
                                                                       ///< through its inside
    SheetMaterial material = {};                                       ///< of a sheet
    std::vector<Guide> guides = {};                                    ///< of a deforming body
    std::optional<TearSettings> tears = {};      ///< of a deforming body; none: it never tears
    std::function<Pose(double time)> path = {};  ///< of a fixed body: the path along which it is
                                                 ///< led
    std::function<void(double time, std::span<Vec3f> positions)> motion_of = {};  ///< of a
                                                                                  ///< deforming
                                                                                  ///< body: its
                                                                                  ///< whole motion
    Filter filter = {};
};

/// Two bodies of a scene, the lower one first.
using BodyPair = std::pair<std::uint32_t, std::uint32_t>;

/// The input of a simulation: meshes and bodies at their start. Lengths in metres, density 1.
struct SceneSetup {
    std::string name;
    std::vector<SceneMesh> meshes;
    std::vector<SceneBody> bodies;
    double gravity = 9.81;                       ///< [m/s^2] along -z
    double dt = 1.0 / 60;                        ///< [s] the time step that the scene is made for
    std::optional<double> baseline_margin = {};  ///< [length] around hulls of Bullet's own methods;
                                                 ///< none: Bullet's own
    std::set<BodyPair> excluded = {};            ///< pairs of bodies that do not meet
};

/// Parameters of a named scene.
struct SceneParameters {
    std::uint32_t count = 100;  ///< number of falling bodies
    bool soft = false;          ///< falling bodies deform
    std::uint32_t seed = 1;
    std::uint32_t nodes = 0;  ///< of a sheet, along a side; of a torus, around its hole; 0: as many
                              ///< as the scene was made for
};

/// A named scene, and which of SceneParameters it has.
struct SceneInfo {
    std::string name;
    std::string description;
    bool has_count = false, may_be_soft = false, has_seed = false, has_nodes = false;
};

/// The scenes by name.
std::span<const SceneInfo> scene_list();

/// Makes a named scene. Throws InputError for an unknown name or a count of zero.
SceneSetup make_scene(const std::string& name, const SceneParameters& parameters = {});

}  // namespace pierce::scenes
