#pragma once

#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pierce/body.hpp"
#include "pierce/box.hpp"
#include "pierce/contact.hpp"
#include "pierce/explain.hpp"
#include "pierce/mesh.hpp"
#include "pierce/plan.hpp"
#include "pierce/pose.hpp"
#include "pierce/settings.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {

class Backend;

/// Where a line of sight first meets a body.
struct RayHit {
    BodyId body;
    std::uint32_t triangle = no_triangle;
    double t = 0;  ///< [length] along the direction
    Vec3d normal;  ///< of the triangle, unit, world space
};

/// Bodies and their contacts. Not thread-safe; one step uses as many threads as its backend has.
/// Calls that take a handle throw InputError if it is null or its thing was removed; on any throw
/// nothing has changed.
class World {
public:
    /// On the reference backend (reference_backends.hpp): slow, and right by definition.
    explicit World(const Settings& settings = {});
    /// On a backend, as embree_backend() makes one. Throws InputError for settings that cannot be.
    explicit World(std::unique_ptr<Backend> backend, const Settings& settings = {});
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;
    ~World();

    /// Checks and keeps a mesh; see Mesh for what is refused. `name` appears in messages.
    MeshId add_mesh(std::string name, MeshData data);
    /// Keeps a mesh that other worlds may have, too: it is checked and measured once. Throws
    /// InputError if there is none.
    MeshId add_mesh(std::shared_ptr<const Mesh> mesh);
    /// Throws InputError while a body still uses the mesh.
    void remove_mesh(MeshId mesh);
    const Mesh& mesh(MeshId mesh) const;

    /// A body that does not move. Two of them are never in contact.
    BodyId add_fixed_body(MeshId mesh, const Pose& pose = {});
    /// A body that moves by its pose.
    BodyId add_rigid_body(MeshId mesh, const Pose& pose = {});
    /// A body whose vertices are given in world space; they start at the mesh's rest positions if
    /// none are given.
    BodyId add_deforming_body(MeshId mesh, std::span<const Vec3f> positions = {});
    void remove_body(BodyId body);

    /// What the body is in contact with besides solids it overlaps; nothing unless asked for.
    /// Throws InputError for a body that does not deform, a negative thickness, or an open mesh
    /// that is to meet itself and is no sheet.
    void set_collision(BodyId body, const Collision& collision);
    const Collision& collision_of(BodyId body) const;

    MeshId mesh_of(BodyId body) const;
    Motion motion_of(BodyId body) const;
    /// The world position of a vertex as the last set_pose or set_positions left it.
    Vec3d vertex_position(BodyId body, std::uint32_t vertex) const;

    /// Moves a fixed or rigid body. A pose that is not finite, further away than
    /// constants::largest_coordinate or without a rotation excludes the body from detect() until a
    /// good one is set. Throws InputError for a deforming body.
    void set_pose(BodyId body, const Pose& pose);
    /// Moves the vertices of a deforming body; copied. Positions that are not finite, or further
    /// away than constants::largest_coordinate, exclude the body from detect() until good ones are
    /// set. Throws InputError for a wrong count or a body that does not deform.
    void set_positions(BodyId body, std::span<const Vec3f> positions);
    /// The same, and where they were when the step began, in place of where the last step left
    /// them: for solvers that try several ends of one step. Positions at the start exclude the body
    /// likewise.
    void set_motion(BodyId body, std::span<const Vec3f> start, std::span<const Vec3f> positions);
    /// The same for a fixed or rigid body. Between the two poses its points are taken to move in
    /// straight lines.
    void set_motion(BodyId body, const Pose& start, const Pose& pose);
    /// set_positions() with positions in device memory, which must stay as they are until the next
    /// detect() is over. Nobody checks them: a body with a position that is not finite has no
    /// contacts or wrong ones. Throws InputError unless the backend runs on the device, or if some
    /// body is a sheet.
    void set_device_positions(BodyId body, const Vec3f* positions);
    /// The same for both ends of the step, which is what a world with a sheet needs.
    void set_device_motion(BodyId body, const Vec3f* start, const Vec3f* positions);
    /// Gives a deforming body other triangles: the topology of `mesh`, at `positions`.
    void set_mesh(BodyId body, MeshId mesh, std::span<const Vec3f> positions);

    /// The next detect() takes it that no sheet is through anything when its step begins, whatever
    /// the last one has found: nothing is remembered of sheets, also not the age of their contacts.
    /// For solvers that try several ends of one step.
    void forget_sides();

    /// Writes the world: settings, meshes, bodies, and what the last step has left for the next
    /// one; not that step's contacts. Throws InputError if it cannot be written, or if a body has
    /// its positions in device memory.
    void save(std::ostream& out) const;
    /// A world as save() has written it, on any backend: handles stay what they were, and the next
    /// steps' contacts are those the saved world would have had. Throws InputError for anything
    /// else, of this version or not, whoever made it.
    static World restore(std::istream& in, std::unique_ptr<Backend> backend);

    /// One step: finds all contacts of the bodies as they stand.
    const StepStats& detect();
    /// The last step's contacts, sorted by (a, b, source, vertex): first those of solids, then
    /// those of sheets. Valid until the next detect().
    std::span<const Contact> contacts() const;
    /// The last step's stages, counts and status bits.
    const StepStats& stats() const;
    /// Which stages this world's steps run and which rules do not apply to some body.
    const Plan& plan();
    std::string backend() const;

    /// A body and the world-space box it stands in.
    struct BodyBox {
        BodyId body;
        Box box;
    };
    /// The boxes of all bodies that took part in the last detect().
    std::vector<BodyBox> body_boxes() const;

    /// Why `vertex` of `body` has, or has not, a contact with `other`, which may be the same one if
    /// it is a sheet, after the last detect(). Throws InputError if the vertex is out of range, or
    /// if bodies were added, removed, moved or changed since.
    Explanation explain(BodyId body, BodyId other, std::uint32_t vertex);

    /// The first body along each line of sight from `origin`, bodies standing as in the last
    /// detect(). Directions need not be unit; zero ones meet nothing. Throws InputError for one
    /// that is not finite, or if bodies were added, removed, moved or changed since.
    std::vector<std::optional<RayHit>> cast_rays(Vec3d origin, std::span<const Vec3d> directions);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce
