#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// From a frame on, a deforming body has another mesh.
struct RecordedMeshChange {
    std::uint32_t frame = 0;
    std::uint32_t mesh = 0;
};

/// The motion of one body: seven numbers (position, quaternion xyzw) a frame, or three per vertex
/// if it deforms.
struct RecordedBody {
    std::string name;
    std::uint32_t mesh = 0;
    Motion motion = Motion::rigid;
    bool ground = false;  ///< as in SceneBody
    std::vector<float> values;
    Collision collision = {};                           ///< as in SceneBody
    std::vector<RecordedMeshChange> mesh_changes = {};  ///< frames ascend, and are not 0
    Filter filter = {};
};

/// Bodies over time, the same for every method. On disk a folder; docs/recordings.md has the
/// format.
struct Recording {
    double dt = 0;  ///< [s] from frame to frame
    std::uint32_t frame_count = 0;
    std::vector<SceneMesh> meshes;
    std::vector<RecordedBody> bodies;
    std::set<BodyPair> excluded = {};  ///< pairs of bodies that do not meet

    /// Where a fixed or rigid body is in a frame. A body that is recorded for a single frame stays
    /// at that place.
    Pose pose(std::uint32_t body, std::uint32_t frame) const;
    /// The mesh of a body in a frame.
    std::uint32_t mesh_of(std::uint32_t body, std::uint32_t frame) const;
    /// The numbers of a body in a frame; not of one that stays, but for the first frame.
    std::span<const float> numbers(std::uint32_t body, std::uint32_t frame) const;
    /// Where a deforming body's vertices are in a frame.
    std::span<const Vec3f> positions(std::uint32_t body, std::uint32_t frame) const;
    /// Where these vertices were when the step from another frame began: a body that has got
    /// another mesh since then begins where it ends.
    std::span<const Vec3f> start_positions(std::uint32_t body, std::uint32_t from,
                                           std::uint32_t frame) const;
};

/// What decides on the inside of a mesh: what the recording says; if that is `automatic` and a
/// sheet has the mesh, nothing.
Inside inside_of(const Recording& recording, std::uint32_t mesh);

/// Throws InputError if a body's mesh changes: `what` needs meshes that stay.
void require_lasting_meshes(const Recording& recording, const std::string& what);

/// The scene a recording starts with.
SceneSetup scene_of(const Recording& recording);

/// Throws InputError, beginning with `what`, unless a time step is positive and finite.
void check_time_step(double dt, const std::string& what);

/// A recording without frames of a scene's meshes and bodies.
Recording start_recording(const SceneSetup& scene, double dt);

/// `progress` is told the share that is done. A folder that is not written to the end is no
/// recording. Throws InputError, naming the file, if the folder cannot be written.
void write_recording(const Recording& recording, const std::filesystem::path& folder,
                     const std::function<void(double share)>& progress = {});

/// `progress` is told the share that is done. Throws InputError, naming the file and what is wrong
/// in it, for anything but a sound recording.
Recording read_recording(const std::filesystem::path& folder,
                         const std::function<void(double share)>& progress = {});

/// `count` frames of a recording, from `first` on.
Recording excerpt(const Recording& recording, std::uint32_t first, std::uint32_t count);

/// About `frames` frames of a recording, evenly spread.
Recording thinned(const Recording& recording, std::uint32_t frames);

/// The recording with the motion of its rigid bodies given vertex by vertex, so that the two can be
/// compared.
Recording as_deforming(const Recording& recording);

}  // namespace pierce::scenes
