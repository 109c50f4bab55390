#include "bullet/pair_algorithm.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <map>
#include <vector>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/bullet/contact_frame.hpp"
#include "pierce/contact_reduction.hpp"

namespace pierce::bullet {

static_assert(sizeof(PairAlgorithm) <= sizeof(btConvexConvexAlgorithm),
              "Bullet's pool has no room for it");

struct PairAlgorithm::Manifolds {
    std::vector<btPersistentManifold*> manifolds;
    std::vector<std::uint64_t> features;  ///< of their points, one manifold after the other
    std::uint32_t written = 0;
};

namespace {

/// Where a point lies in Bullet's mesh, if it lies on a triangle.
int bullet_index(const ContactSide& side, const Contact& contact, bool is_target) {
    if (!is_target) return -1;
    return static_cast<int>(side.mesh->given_triangle(contact.triangle));
}

btManifoldPoint make_point(const FramedContact& contact, const btCollisionObject& a,
                           const btCollisionObject& b) {
    const btVector3 on_a = to_bullet(contact.point_a), on_b = to_bullet(contact.point_b);
    btManifoldPoint point(a.getWorldTransform().invXform(on_a),
                          b.getWorldTransform().invXform(on_b), to_bullet(contact.normal_on_b),
                          static_cast<btScalar>(contact.distance));
    point.m_positionWorldOnA = on_a;
    point.m_positionWorldOnB = on_b;
    point.m_partId0 = point.m_partId1 = 0;
    point.m_combinedFriction = btManifoldResult::calculateCombinedFriction(&a, &b);
    point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(&a, &b);
    point.m_combinedRollingFriction = btManifoldResult::calculateCombinedRollingFriction(&a, &b);
    point.m_combinedSpinningFriction = btManifoldResult::calculateCombinedSpinningFriction(&a, &b);
    if ((a.getCollisionFlags() | b.getCollisionFlags()) &
        btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING) {
        point.m_combinedContactDamping1 = btManifoldResult::calculateCombinedContactDamping(&a, &b);
        point.m_combinedContactStiffness1 = btManifoldResult::calculateCombinedContactStiffness(&a,
                                                                                                &b);
        point.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
    }
    return point;
}

/// Lets the program change the point, if it has asked for that.
void call_back(btManifoldPoint& point, const btCollisionObject& a, const btCollisionObject& b) {
    if (gContactAddedCallback == nullptr || ((a.getCollisionFlags() | b.getCollisionFlags()) &
                                             btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK) == 0)
        return;
    const btCollisionObjectWrapper of_a(nullptr, a.getCollisionShape(), &a, a.getWorldTransform(),
                                        point.m_partId0, point.m_index0);
    const btCollisionObjectWrapper of_b(nullptr, b.getCollisionShape(), &b, b.getWorldTransform(),
                                        point.m_partId1, point.m_index1);
    (*gContactAddedCallback)(point, &of_a, point.m_partId0, point.m_index0, &of_b, point.m_partId1,
                             point.m_index1);
}

btCollisionAlgorithmConstructionInfo construction(btDispatcher& dispatcher) {
    return {&dispatcher, 0};
}

}  // namespace

PairAlgorithm::PairAlgorithm(btDispatcher& dispatcher, std::uint32_t& written)
    : btCollisionAlgorithm(construction(dispatcher)),
      total_written_(written),
      manifolds_(std::make_unique<Manifolds>()) {}

PairAlgorithm::~PairAlgorithm() {
    for (btPersistentManifold* manifold : manifolds_->manifolds)
        m_dispatcher->releaseManifold(manifold);
    set_written(0);
}

void PairAlgorithm::set_written(std::uint32_t count) {
    total_written_ += count - manifolds_->written;
    manifolds_->written = count;
}

void PairAlgorithm::write_manifolds(const ContactSide& a, const ContactSide& b,
                                    std::span<const Contact> contacts, std::uint32_t most) {
    std::vector<btPersistentManifold*>& manifolds = manifolds_->manifolds;
    const std::vector<ReducedContact> reduced = reduce(contacts, most);
    std::map<std::uint64_t, btManifoldPoint> last_points;
    for (std::size_t m = 0, f = 0; m < manifolds.size(); ++m) {
        for (int i = 0; i < manifolds[m]->getNumContacts(); ++i)
            last_points.emplace(manifolds_->features[f++], manifolds[m]->getContactPoint(i));
        manifolds[m]->setNumContacts(0);
    }
    const std::size_t needed = (reduced.size() + MANIFOLD_CACHE_SIZE - 1) / MANIFOLD_CACHE_SIZE;
    while (manifolds.size() > needed) {
        m_dispatcher->releaseManifold(manifolds.back());
        manifolds.pop_back();
    }
    while (manifolds.size() < needed)
        manifolds.push_back(m_dispatcher->getNewManifold(a.object, b.object));

    manifolds_->features.clear();
    for (std::size_t i = 0; i < reduced.size(); ++i) {
        const Contact& contact = contacts[reduced[i].contact];
        btManifoldPoint point = make_point(face_frame(contact), *a.object, *b.object);
        point.m_index0 = bullet_index(a, contact, contact.source == Side::b);
        point.m_index1 = bullet_index(b, contact, contact.source == Side::a);
        if (const auto last = last_points.find(contact.feature()); last != last_points.end()) {
            point.m_appliedImpulse = last->second.m_appliedImpulse;
            point.m_appliedImpulseLateral1 = last->second.m_appliedImpulseLateral1;
            point.m_appliedImpulseLateral2 = last->second.m_appliedImpulseLateral2;
            point.m_lifeTime = last->second.m_lifeTime + 1;
            point.m_userPersistentData = last->second.m_userPersistentData;
            last_points.erase(last);
        }
        call_back(point, *a.object, *b.object);
        manifolds[i / MANIFOLD_CACHE_SIZE]->addManifoldPoint(point);
        manifolds_->features.push_back(contact.feature());
    }
    for (const auto& [feature, point] : last_points)
        if (point.m_userPersistentData != nullptr && gContactDestroyedCallback != nullptr)
            (*gContactDestroyedCallback)(point.m_userPersistentData);
    set_written(static_cast<std::uint32_t>(reduced.size()));
}

void PairAlgorithm::note_soft(std::uint32_t count) { set_written(count); }

void PairAlgorithm::processCollision(const btCollisionObjectWrapper* /*a*/,
                                     const btCollisionObjectWrapper* /*b*/,
                                     const btDispatcherInfo& /*info*/,
                                     btManifoldResult* /*result*/) {}

btScalar PairAlgorithm::calculateTimeOfImpact(btCollisionObject* /*a*/, btCollisionObject* /*b*/,
                                              const btDispatcherInfo& /*info*/,
                                              btManifoldResult* /*result*/) {
    return 1;
}

void PairAlgorithm::getAllContactManifolds(btManifoldArray& manifolds) {
    for (btPersistentManifold* manifold : manifolds_->manifolds) manifolds.push_back(manifold);
}

}  // namespace pierce::bullet
