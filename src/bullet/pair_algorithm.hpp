#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "pierce/contact.hpp"
#include "pierce/ids.hpp"
#include "pierce/impact_contact.hpp"
#include "pierce/mesh.hpp"
#include "pierce/parting.hpp"

class btCollisionObject;

namespace pierce::bullet {

/// A bound object as a contact's side: what Bullet and Pierce call it, and its mesh.
struct ContactSide {
    const btCollisionObject* object = nullptr;
    BodyId body;
    const Mesh* mesh = nullptr;
};

/// What Bullet keeps for a pair of bound objects: the manifolds of two rigid ones. Bullet deletes
/// it when their boxes part, and with it the manifolds.
class PairAlgorithm final : public btCollisionAlgorithm {
public:
    /// `written` is the number of contacts of all pairs that reached the solver; it must live as
    /// long as this.
    PairAlgorithm(btDispatcher& dispatcher, std::uint32_t& written);
    ~PairAlgorithm() override;

    /// Fills the manifolds anew with at most `most` of the contacts, which are all of this pair.
    /// Points of a vertex that was in contact before keep their impulses, unless an object has been
    /// bound anew since. If contacts by separation
    /// are deeper than Bullet's breaking threshold, points of the last step that still hold stay
    /// instead. What the pair meets in this step adds a point each, with a distance. A way apart
    /// acts at all points instead of what the contacts say.
    void write_manifolds(const ContactSide& a, const ContactSide& b,
                         std::span<const Contact> contacts, std::uint32_t most,
                         std::span<const ImpactContact> impacts,
                         const std::optional<Parting>& way_apart);
    /// True if the pair has no manifold.
    bool has_no_points() const;
    /// Notes that so many contacts of the pair went to soft bodies, which need no manifold.
    void note_soft(std::uint32_t count);

    /// The near callback of an Installation writes contacts; these do nothing.
    void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                          const btDispatcherInfo& info, btManifoldResult* result) override;
    btScalar calculateTimeOfImpact(btCollisionObject* a, btCollisionObject* b,
                                   const btDispatcherInfo& info, btManifoldResult* result) override;
    void getAllContactManifolds(btManifoldArray& manifolds) override;

private:
    struct Manifolds;
    void set_written(std::uint32_t count);

    std::uint32_t& total_written_;
    // Bullet's pool for algorithms has places for its own ones, so the rest lies elsewhere.
    std::unique_ptr<Manifolds> manifolds_;
};

}  // namespace pierce::bullet
