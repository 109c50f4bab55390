#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/overlap/convex_parting.hpp"
#include "pierce/world.hpp"

namespace pierce {

/// A world of copies of two bodies, one of which can be moved to see whether they still overlap.
/// What is made of meshes is kept from one pair to the next.
class World::PairCopy {
public:
    /// What is copied. Deforming bodies have positions in world space, the others a pose.
    struct Body {
        std::shared_ptr<const Mesh> mesh;
        Motion motion = Motion::rigid;
        Pose pose;
        std::span<const Vec3f> positions;
    };

    PairCopy();

    /// Puts two bodies in place of the earlier ones; what they refer to must stay.
    void set(const Body& a, const Body& b);

    /// Moves body b by `way` from where it was set and returns the contacts.
    std::span<const Contact> contacts_after(Vec3d way);

    /// One of the two, 0 or 1, as it was set.
    PlacedSurface placed(int body) const;

    /// True if the contact's a and b are a and b as they were set.
    bool is_in_order(const Contact& contact) const { return contact.a == ids_[0]; }

    /// True if contacts_after() has not moved a body beyond what steps look at.
    bool are_within_reach() const;

    /// True if, where contacts_after() saw the bodies last, they share more than a skin of the
    /// touch tolerance. False where one has no inside.
    bool share_volume();

    /// [length] The touch tolerance of the pair as contacts_after() saw it last.
    double touch() const;

    /// From where contacts_after() saw the bodies last: the shortest translation of b along an axis
    /// of the bodies' boxes that puts a plane between the two.
    Vec3d way_apart() const;

private:
    struct Kept {
        std::shared_ptr<const Mesh> mesh;
        MeshId id;
    };
    MeshId keep(const std::shared_ptr<const Mesh>& mesh);
    void move(int body, Vec3d way);

    World world_;
    std::vector<Kept> meshes_;
    std::vector<BodyId> ids_;  ///< of a and of b, once they are set
    Body bodies_[2];
    std::vector<Vec3f> moved_;
};

}  // namespace pierce
