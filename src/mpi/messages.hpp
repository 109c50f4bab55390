#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/base/archive.hpp"
#include "core/step/common/records.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/world/archived.hpp"
#include "core/world/world_state.hpp"
#include "pierce/box.hpp"
#include "pierce/contact.hpp"

/// What ranks tell each other.
namespace pierce::mpi {

/// A body with all that its owner knows of it.
struct WholeBody {
    BodyId id;
    std::uint64_t mesh_key = 0;
    BodyEntry entry;   ///< the handle of the mesh is the sender's
    SeenBody in_last;  ///< how the last step saw it, if that matters
};

/// A body that has moved.
struct MovedBody {
    std::uint32_t number = 0;
    bool tells_start = false;             ///< where the step began
    Pose pose, start_pose;                ///< of a body that does not deform
    std::vector<Vec3f> positions, start;  ///< of one that does
};

/// From a rank to one whose bodies are near. What comes first is done first.
struct GhostMessage {
    std::vector<SavedMesh> meshes;
    std::vector<std::uint32_t> left;  ///< no longer near, or removed
    std::vector<WholeBody> bodies;    ///< near now, or changed
    std::vector<MovedBody> moved;
    std::vector<std::uint64_t> forgotten;  ///< keys of meshes

    bool empty() const {
        return meshes.empty() && left.empty() && bodies.empty() && moved.empty() &&
               forgotten.empty();
    }
};

/// From a rank to all, when bodies were added, removed or changed there.
struct News {
    BodyKinds kinds;  ///< of all its bodies
    std::vector<BodyId> added, removed;
    std::vector<BodyIdPair> excluded, included;
    std::vector<std::int32_t> worlds;  ///< of all its bodies

    bool empty() const {
        return added.empty() && removed.empty() && excluded.empty() && included.empty();
    }
};

/// From a rank to one that gets bodies of it, with what is remembered of their pairs.
struct Handover {
    std::vector<SavedMesh> meshes;
    std::vector<WholeBody> bodies;
    StepMemory memory;
};

/// What all ranks know of one in a step.
struct Summary {
    static constexpr std::size_t most_boxes = 80;

    bool failed = false;
    double work = 0;  ///< [triangles] ghosts count in part
    std::uint64_t box_count = 0;
    Box reach[most_boxes];  ///< of its moving bodies
};

/// A contact on its way to where all are gathered.
struct GatheredContact {
    std::uint64_t pair_key = 0;
    bool of_sheets = false;  ///< of the list of sheets
    Contact contact;
};

template <class A>
void transfer(A& archive, WholeBody& b) {
    transfer_all(archive, b.id, b.mesh_key, b.entry, b.in_last);
}

template <class A>
void transfer(A& archive, MovedBody& b) {
    transfer_all(archive, b.number, b.tells_start, b.pose, b.start_pose, b.positions, b.start);
}

template <class A>
void transfer(A& archive, GhostMessage& m) {
    transfer_all(archive, m.meshes, m.left, m.bodies, m.moved, m.forgotten);
}

template <class A>
void transfer(A& archive, News& n) {
    transfer_all(archive, n.kinds, n.added, n.removed, n.excluded, n.included, n.worlds);
}

template <class A>
void transfer(A& archive, Handover& h) {
    transfer_all(archive, h.meshes, h.bodies, h.memory);
}

template <class Message>
std::string to_bytes(Message& message) {
    ArchiveWriter archive;
    transfer(archive, message);
    return std::move(archive).take();
}

template <class Message>
Message from_bytes(std::string bytes) {
    Message message;
    ArchiveReader archive(std::move(bytes));
    transfer(archive, message);
    return message;
}

}  // namespace pierce::mpi
