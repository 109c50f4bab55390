#pragma once

#include <cstddef>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pierce/body.hpp"
#include "pierce/box.hpp"
#include "pierce/contact.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/explain.hpp"
#include "pierce/filter.hpp"
#include "pierce/impact_contact.hpp"
#include "pierce/mesh.hpp"
#include "pierce/overlap.hpp"
#include "pierce/parting.hpp"
#include "pierce/plan.hpp"
#include "pierce/pose.hpp"
#include "pierce/settings.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {

class Backend;

/// The point where a line of sight first meets a body.
struct RayHit {
    BodyId body;
    std::uint32_t triangle = no_triangle;
    double t = 0;  ///< [length] along the direction
    Vec3d normal;  ///< of the triangle, unit, world space
};

/// What is pressed against a point of a sensor, or near it.
struct ProbeContact {
    BodyId body;
    std::uint32_t triangle = no_triangle;
    double distance = 0;  ///< [length] along the sensor's normal: negative where the body is
                          ///< pressed in, positive where it is still away
    Vec3d normal;         ///< of the triangle, unit, outward, world space
};

/// Which contacts are of which world: those of worlds[i] are the contacts from solids[i] to
/// solids[i + 1], and from sheets[i] to sheets[i + 1]. Contacts between bodies that are in all
/// worlds follow. Within a world, contacts are those of the same world alone, in the same order.
struct WorldOffsets {
    std::vector<std::int32_t> worlds;
    std::vector<std::uint32_t> solids;  ///< worlds.size() + 1, like the next one
    std::vector<std::uint32_t> sheets;
};

/// Contacts of a step that outlast it, and the world.
struct KeptContacts {
    std::shared_ptr<const Contact> first;
    std::size_t count = 0;

    std::span<const Contact> all() const { return {first.get(), count}; }
};

/// Bodies and their contacts. Not thread-safe; one step uses as many threads as its backend has.
/// Calls that take a handle throw InputError if the handle is null or what it names was removed. A
/// call that throws changes nothing, but for a step that runs out of memory, on the host or on a
/// device: it has no contacts, and the next one remembers nothing.
class World {
public:
    /// Makes a world on the reference backend (reference_backends.hpp), which is slow, and right by
    /// definition.
    explicit World(const Settings& settings = {});
    /// Makes a world on a backend such as embree_backend() returns. Throws InputError for
    /// impossible settings.
    explicit World(std::unique_ptr<Backend> backend, const Settings& settings = {});
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;
    ~World();

    /// Checks and keeps a mesh; Mesh says what is refused. `name` appears in messages.
    MeshId add_mesh(std::string name, MeshData data, MeshOptions options = {});
    /// Keeps a mesh that other worlds may share; the mesh is checked and measured once. Throws
    /// InputError if `mesh` is null.
    MeshId add_mesh(std::shared_ptr<const Mesh> mesh);
    /// The same for a mesh that is mostly `before`, cut, torn or grown (Mesh). It costs in
    /// proportion to this mesh, and measuring it in proportion to what has changed.
    MeshId add_mesh(std::string name, MeshData data, MeshId before, MeshOptions options = {});
    /// Throws InputError while a body still uses the mesh.
    void remove_mesh(MeshId mesh);
    /// The mesh of a handle, until it is removed.
    const Mesh& mesh(MeshId mesh) const;
    /// The same, for other worlds, and for as long as it is kept.
    std::shared_ptr<const Mesh> share_mesh(MeshId mesh) const;

    /// Adds a body that does not move. Two fixed bodies are never in contact.
    BodyId add_fixed_body(MeshId mesh, const Pose& pose = {});
    /// Adds a body that moves by its pose.
    BodyId add_rigid_body(MeshId mesh, const Pose& pose = {});
    /// Adds a body whose vertices are given in world space; they start at the mesh's rest positions
    /// if no positions are given.
    BodyId add_deforming_body(MeshId mesh, std::span<const Vec3f> positions = {});
    void remove_body(BodyId body);

    /// Sets what the body is in contact with besides solids that it overlaps; by default that is
    /// nothing. Throws InputError for a body that does not deform and is to be a sheet or to meet
    /// itself, for a thickness or a margin that is not finite, for a thickness that is negative or
    /// of a solid, for rays along the velocities of a solid, for an open mesh that is to meet
    /// itself without being a sheet, and for a sheet of a mesh whose holes are closed.
    void set_collision(BodyId body, const Collision& collision);
    const Collision& collision_of(BodyId body) const;

    /// Sets which other bodies the body meets; by default those of all groups and worlds. Pairs
    /// that filters leave out cost no ray. Throws InputError for a world below all_worlds, and for
    /// one that is not below constants::most_worlds. When the first body gets a world, and when the
    /// last one loses its, contacts begin a new age, and sheets forget their sides; so do those of
    /// bodies that go to another world.
    void set_filter(BodyId body, const Filter& filter);
    const Filter& filter_of(BodyId body) const;
    /// Leaves out the pair of two bodies, whatever their filters, until include() takes it in
    /// again or one of them is removed. Both throw InputError for a body and itself.
    void exclude(BodyId a, BodyId b);
    void include(BodyId a, BodyId b);
    /// The pairs that are left out so, each one's lower body first, sorted.
    std::vector<std::pair<BodyId, BodyId>> excluded_pairs() const;
    /// Asks the caller whether two bodies meet, where filters allow it and their boxes overlap,
    /// once a step for every such pair; an empty function asks nothing. It is called by all threads
    /// of the backend at the same time, must not throw and must not call the world. explain() and
    /// impacts() ask it, too; parting() and overlap() do not, and it is not saved. Throws
    /// InputError if the backend runs on a device.
    void set_pair_filter(PairFilter filter);

    /// The worlds that bodies are in, sorted, without all_worlds.
    std::vector<std::int32_t> worlds() const;
    /// The bodies of a world, in the order in which they are sorted in contacts(); none if there
    /// is no such world.
    std::vector<BodyId> bodies_of(std::int32_t world) const;
    /// Copies all bodies of a world, with their meshes, places, collisions, groups, chains and
    /// excluded pairs, into `count` new worlds, and returns the first of those; they follow each
    /// other after the highest world there is. Throws InputError if the world has no bodies, or if
    /// there would be too many worlds or bodies. Places in device memory are copied to the host.
    std::int32_t replicate(std::int32_t world, std::uint32_t count);
    /// Puts the bodies of a world where those of another one are, which has the same bodies, as a
    /// copy has. Their next step begins there. Throws InputError for worlds that differ.
    void copy_places(std::int32_t from, std::int32_t to);
    /// Removes all bodies of a world. Throws InputError for all_worlds.
    void remove_world(std::int32_t world);
    /// Leaves the bodies of a world out of steps, or takes them in again. A world that has lost all
    /// its bodies is left out no more. Throws InputError for all_worlds, and for a world without
    /// bodies.
    void set_world_active(std::int32_t world, bool active);
    /// Which of the last step's contacts are of which world. Throws InputError if bodies were
    /// added, removed, moved or changed since.
    WorldOffsets world_offsets() const;

    MeshId mesh_of(BodyId body) const;
    Motion motion_of(BodyId body) const;
    /// The world position of a vertex as the last set_pose or set_positions left it.
    Vec3d vertex_position(BodyId body, std::uint32_t vertex) const;
    /// The same of all vertices of a body.
    std::vector<Vec3d> vertex_positions(BodyId body) const;
    /// Where the last set_pose left a fixed or rigid body. Throws InputError for a deforming body.
    Pose pose_of(BodyId body) const;

    /// Moves a fixed or rigid body. A pose that is not finite, further away than
    /// constants::largest_coordinate or without a rotation excludes the body from detect() until a
    /// usable pose is set. Throws InputError for a deforming body.
    void set_pose(BodyId body, const Pose& pose);
    /// set_pose() of many bodies. Throws InputError for lists of different lengths.
    void set_poses(std::span<const BodyId> bodies, std::span<const Pose> poses);
    /// The same from seven numbers a body: the position x, y, z and the quaternion x, y, z, w.
    void set_poses(std::span<const BodyId> bodies, std::span<const double> poses);
    void set_poses(std::span<const BodyId> bodies, std::span<const float> poses);
    /// Moves the vertices of a deforming body; the positions are copied. Positions that are not
    /// finite, or further away than constants::largest_coordinate, exclude the body from detect()
    /// until usable ones are set. Throws InputError for a wrong count or a body that does not
    /// deform.
    void set_positions(BodyId body, std::span<const Vec3f> positions);
    /// set_positions() of many bodies, whose positions follow each other.
    void set_positions(std::span<const BodyId> bodies, std::span<const Vec3f> positions);
    /// Moves the vertices of a deforming body and sets where they were when the step began, in
    /// place of where the last step left them. This is for solvers that try several ends of one
    /// step. Unusable positions at the start exclude the body, too.
    void set_motion(BodyId body, std::span<const Vec3f> start, std::span<const Vec3f> positions);
    /// The same for a fixed or rigid body. The body's points are taken to move in straight lines
    /// between the two poses.
    void set_motion(BodyId body, const Pose& start, const Pose& pose);
    /// set_positions() with positions in device memory. Every step reads them there, until others
    /// are set; they must not change while it does. The positions are not checked: a body with a
    /// position that is not finite has no contacts or wrong ones. Throws InputError unless the
    /// backend runs on the device, or if some body is a sheet.
    void set_device_positions(BodyId body, const Vec3f* positions);
    /// The same for many bodies, whose positions follow each other.
    void set_device_positions(std::span<const BodyId> bodies, const Vec3f* positions);
    /// The same for both ends of the step; a world with a sheet needs both. Where set_positions()
    /// follows a step, the positions must still be there: the next step begins at them.
    void set_device_motion(BodyId body, const Vec3f* start, const Vec3f* positions);
    /// set_poses() with poses in device memory, seven numbers each. Every step reads them there,
    /// until others are set; they must not change while it does. A pose that set_pose() would
    /// exclude leaves the body out of the step; StepStats does not count it. Throws InputError
    /// unless the backend runs on the device, for a body that deforms, or if some body is a sheet;
    /// where bodies have changed since the last step, detect() says that.
    void set_device_poses(std::span<const BodyId> bodies, const float* poses);
    void set_device_poses(std::span<const BodyId> bodies, const double* poses);
    /// Names the CUDA stream, a cudaStream_t, on which the caller writes places and reads contacts
    /// in device memory: a step begins when what was issued there before is done, and what is
    /// issued there after detect() or device_contacts() sees their results. It may be a stream of
    /// any of several devices. Null: none. Throws InputError unless the backend runs on the device.
    void set_stream(void* stream);
    /// Gives a deforming body other triangles: the topology of `mesh`, at `positions`. Only what
    /// belongs to this body is made anew. What is remembered of pairs without it stays.
    void set_mesh(BodyId body, MeshId mesh, std::span<const Vec3f> positions);
    /// Gives a fixed or rigid body another mesh. It stays where it is.
    void set_mesh(BodyId body, MeshId mesh);

    /// Makes the next detect() assume that no sheet is through anything when its step begins,
    /// whatever the last detect() found. Everything remembered between surfaces is forgotten,
    /// including the age of their contacts; contacts that rays find keep theirs. This is for
    /// solvers that try several ends of one step.
    void forget_sides();

    /// Writes the world: settings, meshes, bodies, and what the last step keeps for the next one.
    /// The last step's contacts are not written. Places in device memory are written as they are
    /// now; the world that is read has them on the host. Throws InputError if writing fails.
    void save(std::ostream& out) const;
    /// Reads a world that save() has written, on any backend. Handles stay valid, and the next
    /// steps' contacts are those that the saved world would have had, but for Contact::found: what
    /// stands still is looked for once more; and but for those of meshes that add_mesh() has made
    /// from another mesh and that are folded through themselves or inside out, which are measured
    /// anew. Throws InputError for any other content, whatever its version and whoever made it.
    static World restore(std::istream& in, std::unique_ptr<Backend> backend);

    /// For bodies that are fast for their size: the first meeting of every pair of solids that are
    /// apart where the next step begins and meet on their way to where they are now, sorted by
    /// (a, b). None is missed that is deeper than the touch tolerance, also of bodies that have
    /// passed through each other. Points move in straight lines from where the last detect(), or
    /// set_motion(), has them. It changes nothing, takes one thread of the host, and costs in
    /// proportion to the triangles whose ways come near each other; detect() does not need it.
    /// Filters count. Each pair has up to `most_per_pair` meetings, and one at least: after the
    /// first one, first meetings of other vertices, far from each other, so that a face that comes
    /// flat is held in more than one place. Throws InputError for places in device memory.
    std::vector<ImpactContact> impacts(std::uint32_t most_per_pair = 1) const;
    /// The same for rigid bodies on their way from where they are now to the given poses, while all
    /// others stay. Throws InputError for a body that is not rigid or is named twice, for a pose
    /// that is not finite, too far away or has no rotation, and for places in device memory.
    std::vector<ImpactContact> impacts_ahead(std::span<const PoseAhead> ahead,
                                             std::uint32_t most_per_pair = 1) const;

    /// Runs one step: finds all contacts of the bodies where they are now. If nothing has changed
    /// in this step and the last one, contacts get older and nothing else is done, unless steps
    /// run on a device, or there are sheets or a pair filter, or with Temporal::paper.
    const StepStats& detect();
    /// The last step's contacts: first those that rays have found, then those between surfaces,
    /// which are those of sheets. Each part is sorted by pair, where bodies have worlds by world
    /// before that, and then as docs/contacts.md says. Valid until the next detect().
    std::span<const Contact> contacts() const;
    /// The same contacts, valid for as long as they are kept: later steps write elsewhere. Nothing
    /// is copied unless there are contacts of sheets, or steps run on a device.
    KeptContacts keep_contacts();
    /// The same contacts in device memory, valid until the next detect(). With a stream of the
    /// caller's this waits for nothing, else until they are there. With several devices, those that
    /// one of them has found (Plan::parts). Throws InputError unless the backend runs on the
    /// device, if there is no such part, or if bodies were added, removed, moved or changed since.
    DeviceContacts device_contacts(std::uint32_t part = 0) const;
    /// The last step's stages, counts and status bits.
    const StepStats& stats() const;
    /// Which stages this world's steps run and which rules do not apply to some body.
    const Plan& plan();
    std::string backend() const;

    /// A body and a world-space box around it, which need not be the smallest.
    struct BodyBox {
        BodyId body;
        Box box;
    };
    /// The boxes of all bodies that took part in the last detect(). Throws InputError if bodies
    /// were added, removed, moved or changed since.
    std::vector<BodyBox> body_boxes() const;

    /// Says why `vertex` of `body` has a contact with `other` after the last detect(), or none.
    /// `other` may be `body` itself if that is a sheet. Throws InputError if the vertex is out of
    /// range, for places in device memory, or if bodies were added, removed, moved or changed
    /// since.
    Explanation explain(BodyId body, BodyId other, std::uint32_t vertex);

    /// How far body b has to move, and where to, until it does not overlap body a any more, with
    /// both where the last set_pose or set_positions left them; nothing if they do not overlap by
    /// more than the touch tolerance. The move was tried: afterwards complete coverage sees no
    /// contact that is deeper; or it puts a plane between the two. Apart from that tolerance, the
    /// depth is not less than the shortest translation that parts them. For two convex meshes that
    /// are not large it is that; docs/contacts.md says how near others come to it, and where it
    /// fails. Nothing of the last step is used or changed; the pair is moved and looked at some ten
    /// to a hundred times, on one thread of the host. Throws InputError for a body and itself, and
    /// for a sheet.
    std::optional<Parting> parting(BodyId a, BodyId b);

    /// What two solids have in common, with both where the last set_pose or set_positions left
    /// them: volume, areas, how the volume changes, and patches. A patch is what overlaps along
    /// directions with at least `same_direction` as cosine. Nothing if they have no volume in
    /// common, or if the place of one is not usable. Which triangles cross is decided without
    /// rounding; positions are rounded to 1e-11 of the pair's extent first. Nothing of the last
    /// step is used or changed; it takes one thread of the host. Throws InputError for a body and
    /// itself, for a sheet or a mesh without an inside, and for a `same_direction` that is no
    /// cosine.
    std::optional<Overlap> overlap(BodyId a, BodyId b, double same_direction = 0.9);

    /// The first body along each line of sight from `origin`, with bodies where the last detect()
    /// saw them. Directions need not be unit; a zero direction meets nothing. From further away
    /// than constants::largest_coordinate, bodies may be missed; those thinner than their touch
    /// tolerance are. Throws InputError for an origin or a direction that is not finite, or if
    /// bodies were added, removed, moved or changed since.
    std::vector<std::optional<RayHit>> cast_rays(Vec3d origin, std::span<const Vec3d> directions);

    /// What touches a sensor, such as the skin of a finger: `points` on it, with normals that point
    /// out of it. For a point inside a solid, the solid is pressed in as far as one must go from
    /// the point, against the normal, to leave it. Others are near if the point meets them
    /// along the normal, `radius` away at most. Of several solids the one counts that is pressed in
    /// furthest, or nearest. `others`: the bodies that count; empty: all, the sensor's own ones as
    /// well. Sheets do not count. Bodies are where the last detect() saw them. Normals need not be
    /// unit; a zero normal meets nothing. Throws InputError for lists of different lengths,
    /// for numbers that are not finite, for a negative radius, or if bodies were added, removed,
    /// moved or changed since the last detect().
    std::vector<std::optional<ProbeContact>> probe(std::span<const Vec3d> points,
                                                   std::span<const Vec3d> normals, double radius,
                                                   std::span<const BodyId> others = {});

private:
    friend struct WorldInside;
    class PairCopy;
    class PartingSearch;
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce
