#pragma once

#include <mpi.h>

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pierce/backend.hpp"
#include "pierce/world.hpp"

namespace pierce::mpi {

/// Whose bodies have become others'.
struct Migration {
    std::vector<BodyId> arrived;  ///< this rank owns them now
    std::vector<BodyId> left;     ///< this rank has owned them
};

/// A world whose bodies are spread over the processes of an MPI communicator, its *ranks*. Every
/// body belongs to one rank, its owner, which adds it, moves it and asks about it with the calls of
/// pierce::World. Contacts are those of one world with all bodies, bit for bit, with their ages;
/// each is found on one rank (docs/scale.md). Each rank decides for itself when proofs rest
/// (Settings::may_rest), so Contact::found may tell another way to the same contact. A mesh that
/// add_mesh() has made from another one is measured anew on other ranks; if it is folded through
/// itself or inside out, contacts may differ there.
///
/// Calls marked *collective* have to be made by all ranks in the same order. If one of them fails
/// on a rank, it throws the same message on all ranks; then there are no contacts, and the next
/// step remembers nothing. Bodies are numbered by the caller: a number is unique over all ranks and
/// decides the order of contacts, as the order of adding does in one world. Memory and time of
/// every rank grow with the largest number, by some hundred bytes each, so numbers should follow
/// each other. Not thread-safe. MPI must be initialized before, and finalized after.
class World {
public:
    /// Collective. `ranks` is duplicated. Each rank may have another backend. Throws InputError for
    /// impossible settings, and if ranks have different settings.
    World(MPI_Comm ranks, std::unique_ptr<Backend> backend, const Settings& settings = {});
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;
    ~World();

    int rank() const;
    int ranks() const;

    // Meshes, as in pierce::World. Other ranks get those that they need.

    MeshId add_mesh(std::string name, MeshData data, MeshOptions options = {});
    MeshId add_mesh(std::shared_ptr<const Mesh> mesh);
    MeshId add_mesh(std::string name, MeshData data, MeshId before, MeshOptions options = {});
    void remove_mesh(MeshId mesh);
    const Mesh& mesh(MeshId mesh) const;

    // Bodies, as in pierce::World. This rank owns what it adds. Throw InputError for a number that
    // this rank knows to be taken; the next detect() throws if two ranks have taken the same, or if
    // another rank has removed the body of that number since the last one.

    BodyId add_fixed_body(std::uint32_t number, MeshId mesh, const Pose& pose = {});
    BodyId add_rigid_body(std::uint32_t number, MeshId mesh, const Pose& pose = {});
    BodyId add_deforming_body(std::uint32_t number, MeshId mesh,
                              std::span<const Vec3f> positions = {});

    /// The bodies that this rank owns, by their numbers.
    std::vector<BodyId> bodies() const;
    bool owns(BodyId body) const;

    // As in pierce::World, for bodies that this rank owns. Throw InputError for others.

    void remove_body(BodyId body);
    void set_collision(BodyId body, const Collision& collision);
    void set_filter(BodyId body, const Filter& filter);
    void set_pose(BodyId body, const Pose& pose);
    void set_poses(std::span<const BodyId> bodies, std::span<const Pose> poses);
    void set_positions(BodyId body, std::span<const Vec3f> positions);
    void set_positions(std::span<const BodyId> bodies, std::span<const Vec3f> positions);
    void set_motion(BodyId body, std::span<const Vec3f> start, std::span<const Vec3f> positions);
    void set_motion(BodyId body, const Pose& start, const Pose& pose);
    void set_mesh(BodyId body, MeshId mesh, std::span<const Vec3f> positions);
    void set_mesh(BodyId body, MeshId mesh);

    // The same for backends that run on a device, whose memory has the places. Bodies that are near
    // other ranks are sent through pinned memory of the host.

    void set_device_positions(BodyId body, const Vec3f* positions);
    void set_device_positions(std::span<const BodyId> bodies, const Vec3f* positions);
    void set_device_motion(BodyId body, const Vec3f* start, const Vec3f* positions);
    void set_device_poses(std::span<const BodyId> bodies, const float* poses);
    void set_device_poses(std::span<const BodyId> bodies, const double* poses);
    void set_stream(void* stream);

    /// As in pierce::World, for bodies of any ranks; one rank has to say it.
    void exclude(BodyId a, BodyId b);
    void include(BodyId a, BodyId b);
    /// As in pierce::World; all ranks have to set the same.
    void set_pair_filter(PairFilter filter);
    /// As in pierce::World, also of a world whose bodies are on other ranks; all ranks have to set
    /// the same. A world is left out until no rank has a body of it when bodies were added, removed
    /// or changed before a step.
    void set_world_active(std::int32_t world, bool active);
    /// As in pierce::World, on all ranks if one calls it.
    void forget_sides();

    /// Collective. Runs one step: bodies that are near another rank's are sent there, and every
    /// rank finds the contacts of its pairs. A pair of two moving bodies belongs to the lower one
    /// of their ranks, a pair with a fixed body to the other one's.
    const StepStats& detect();
    /// The contacts that this rank has found in the last step, sorted as in pierce::World.
    std::span<const Contact> contacts() const;
    /// What this rank's last step did.
    const StepStats& stats() const;
    /// Collective. All ranks' contacts in the order of one world, on rank `root`; empty on others.
    /// Throws InputError if there is no such rank, and if bodies were added, removed or changed
    /// since the last detect(), or have migrated.
    std::vector<Contact> gather_contacts(int root = 0) const;

    /// Collective. Gives ranks other bodies, so that all have the same work and what is near each
    /// other is together: space is cut into compact parts. What the last step remembers goes with
    /// the bodies. Meshes of bodies that arrive are added to those of this rank. Bodies with places
    /// in device memory arrive with them on the host, as they are now, for the next step.
    Migration migrate();
    /// The work of the busiest rank over the mean, in triangles in the last step, ghosts counted in
    /// part; 1 before it.
    double uneven() const;

    /// Collective. Writes all ranks' bodies on rank 0 as one world, which pierce::World::restore()
    /// reads, too. `out` is not used on other ranks. Places in device memory are saved as they are
    /// now.
    void save(std::ostream& out) const;
    /// Collective. Reads a world that save(), or pierce::World::save(), has written, for any number
    /// of ranks; every rank reads all of it and keeps its part. Bodies keep their handles, and the
    /// next steps' contacts are those that the saved world would have had, but for Contact::found.
    static World restore(MPI_Comm ranks, std::istream& in, std::unique_ptr<Backend> backend);

    /// This rank's bodies, and those of others that were near in the last step, for questions:
    /// explain(), parting(), probe() and the like. To change it, or to step it, is an error that is
    /// not noticed.
    pierce::World& nearby();
    const pierce::World& nearby() const;

private:
    struct State;
    explicit World(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace pierce::mpi
