#pragma once

#include <memory>

#include "pierce/world.hpp"
#include "scenes/detect/method.hpp"
#include "scenes/named/scene.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::scenes {

/// Finds contacts of a scene's bodies wherever they are put, by any method. This is the open loop,
/// in which all methods see the same frames.
class Detector {
public:
    virtual ~Detector() = default;

    /// Bodies by their index in the scene.
    virtual void set_pose(std::uint32_t body, const Pose& pose) = 0;
    virtual void set_positions(std::uint32_t body, std::span<const Vec3f> positions) = 0;
    /// Gives a deforming body the recording's mesh of that number, unless it has it. Throws
    /// InputError if the method cannot do that.
    virtual void set_mesh(std::uint32_t body, const Recording& recording, std::uint32_t mesh,
                          std::span<const Vec3f> positions);
    virtual FrameResult detect() = 0;
    /// The contacts of the last detect().
    virtual std::vector<MethodContact> contacts() const = 0;
    /// The detector's world, if the method is rays; else null.
    virtual World* world() { return nullptr; }
};

/// Makes a detector for a method. Throws InputError if the method cannot handle the scene.
std::unique_ptr<Detector> make_detector(const SceneSetup& scene, Method method,
                                        const RaySettings& rays = {});

/// Makes a detector that uses rays, with any backend.
std::unique_ptr<Detector> make_detector(const SceneSetup& scene, std::unique_ptr<Backend> backend,
                                        const Settings& settings);

/// Puts all bodies where a recording has them in a frame; the detector's scene must be the
/// recording's.
void put_frame(Detector& detector, const Recording& recording, std::uint32_t frame);

/// A World with a scene's meshes and bodies, in their order.
struct SceneWorld {
    World world;
    std::vector<BodyId> bodies;

    /// Gives a deforming body another mesh. The last one is removed if no other body has it.
    void set_mesh(std::uint32_t body, const SceneMesh& mesh, std::span<const Vec3f> positions);

    SceneWorld(const SceneSetup& scene, const RaySettings& settings);
    SceneWorld(const SceneSetup& scene, std::unique_ptr<Backend> backend, const Settings& settings,
               const MeshOptions& options = {});
    /// Index into the scene's bodies: a World gives out handles in order, and a scene never
    /// removes a body.
    std::uint32_t index_of(BodyId body) const;
    /// The last step's results.
    FrameResult result() const;

private:
    MeshOptions options_;
};

}  // namespace pierce::scenes
