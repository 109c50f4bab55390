#pragma once

#include <span>
#include <string>
#include <vector>

#include "pierce/core/body.hpp"
#include "pierce/core/mesh.hpp"
#include "pierce/core/pose.hpp"

namespace pierce::scenes {

/// A mesh of a scene.
struct SceneMesh {
    std::string name;
    MeshData data;
    std::vector<std::vector<Vec3f>> convex_pieces;  ///< point sets whose hulls make up the mesh; may be empty
};

/// A body of a scene at its start.
struct SceneBody {
    std::string name;
    std::uint32_t mesh = 0;  ///< index into Scene::meshes
    Motion motion = Motion::rigid;
    Pose pose;            ///< of a deforming body: where its rest shape is placed at the start
    bool ground = false;  ///< nothing gets below or beside it: Bullet's own methods may take the plane through its top
};

/// What is simulated: meshes and bodies at their start. Lengths in metres, density 1.
struct SceneSetup {
    std::string name;
    std::vector<SceneMesh> meshes;
    std::vector<SceneBody> bodies;
};

/// What a named scene can be asked for.
struct SceneParameters {
    std::uint32_t count = 100;  ///< falling bodies
    bool soft = false;          ///< falling bodies deform
    std::uint32_t seed = 1;
};

struct SceneInfo {
    std::string name;
    std::string description;
};

/// The scenes by name.
std::span<const SceneInfo> scene_list();

/// Makes a named scene. Throws InputError for an unknown name or a count of zero.
SceneSetup make_scene(const std::string& name, const SceneParameters& parameters = {});

}  // namespace pierce::scenes
