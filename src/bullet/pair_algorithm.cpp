#include "bullet/pair_algorithm.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/bullet/contact_frame.hpp"
#include "pierce/contact_reduction.hpp"

namespace pierce::bullet {

static_assert(sizeof(PairAlgorithm) <= sizeof(btConvexConvexAlgorithm),
              "Bullet's pool has no room for it");

namespace {

using Points = std::vector<std::pair<std::uint64_t, btManifoldPoint>>;  ///< by Contact::feature()
using PointMap = std::multimap<std::uint64_t, btManifoldPoint>;

constexpr std::uint64_t no_feature = ~std::uint64_t{0};  ///< of points that no later one goes on in

/// What tells a point from others, and which contact it was made from.
struct WrittenPoint {
    btVector3 on_a, on_b;  ///< in the bodies' frames
    std::uint64_t feature;
};

void tell_destroyed(const btManifoldPoint& point) {
    if (point.m_userPersistentData != nullptr && gContactDestroyedCallback != nullptr)
        (*gContactDestroyedCallback)(point.m_userPersistentData);
}

}  // namespace

struct PairAlgorithm::Manifolds {
    std::vector<btPersistentManifold*> manifolds;
    std::vector<bool> has_begun;  ///< per manifold: Bullet was told so, and not yet that it has
                                  ///< ended; a program that empties one tells that it has
    std::vector<WrittenPoint> points;  ///< theirs; a program may have removed some, or added others
    std::uint32_t written = 0;
    BodyId of_a, of_b;  ///< whose contacts these are, in the manifolds' order

    void release(btDispatcher& dispatcher);
    PointMap take_points();
    void put_points(btDispatcher& dispatcher, const ContactSide& a, const ContactSide& b,
                    Points& added);
};

/// Bullet tells the program what has ended.
void PairAlgorithm::Manifolds::release(btDispatcher& dispatcher) {
    for (btPersistentManifold* manifold : manifolds) dispatcher.releaseManifold(manifold);
    manifolds.clear();
    has_begun.clear();
    points.clear();
}

/// Leaves the manifolds empty.
PointMap PairAlgorithm::Manifolds::take_points() {
    PointMap found;
    for (std::size_t m = 0; m < manifolds.size(); ++m) {
        btPersistentManifold* const manifold = manifolds[m];
        has_begun[m] = manifold->getNumContacts() > 0;
        for (int i = 0; i < manifold->getNumContacts(); ++i) {
            const btManifoldPoint& point = manifold->getContactPoint(i);
            const auto known = std::ranges::find_if(points, [&](const WrittenPoint& w) {
                return w.on_a == point.m_localPointA && w.on_b == point.m_localPointB;
            });
            if (known == points.end()) continue;
            found.emplace(known->feature, point);
            points.erase(known);
        }
        manifold->setNumContacts(0);
    }
    points.clear();
    return found;
}

/// Fills as many empty manifolds as the points need. If the dispatcher has no room for all, the
/// deepest points stay.
void PairAlgorithm::Manifolds::put_points(btDispatcher& dispatcher, const ContactSide& a,
                                          const ContactSide& b, Points& added) {
    const std::size_t needed = (added.size() + MANIFOLD_CACHE_SIZE - 1) / MANIFOLD_CACHE_SIZE;
    while (manifolds.size() > needed) {
        if (gContactEndedCallback != nullptr && has_begun.back())
            (*gContactEndedCallback)(manifolds.back());
        dispatcher.releaseManifold(manifolds.back());
        manifolds.pop_back();
        has_begun.pop_back();
    }
    while (manifolds.size() < needed) {
        btPersistentManifold* const manifold = dispatcher.getNewManifold(a.object, b.object);
        if (manifold == nullptr) break;  // the dispatcher's pool is full and must not grow
        manifolds.push_back(manifold);
        has_begun.push_back(false);
    }
    const std::size_t room = manifolds.size() * MANIFOLD_CACHE_SIZE;
    if (added.size() > room) {
        std::ranges::stable_sort(added, {}, [](const auto& p) { return p.second.m_distance1; });
        for (std::size_t i = room; i < added.size(); ++i) tell_destroyed(added[i].second);
        added.resize(room);
    }
    for (std::size_t i = 0; i < added.size(); ++i) {
        const auto& [feature, point] = added[i];
        manifolds[i / MANIFOLD_CACHE_SIZE]->addManifoldPoint(point);
        points.push_back({point.m_localPointA, point.m_localPointB, feature});
    }
    for (std::size_t m = 0; m < manifolds.size() && gContactStartedCallback != nullptr; ++m)
        if (!has_begun[m]) (*gContactStartedCallback)(manifolds[m]);
}

namespace {

/// Where a point lies in Bullet's mesh, if it lies on a triangle.
int bullet_index(const ContactSide& side, std::uint32_t triangle, bool is_target) {
    return is_target ? static_cast<int>(side.mesh->given_triangle(triangle)) : -1;
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
    // As btManifoldResult does: a program's callback may go by these directions.
    btPlaneSpace1(point.m_normalWorldOnB, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
    // A program may have put its own functions there.
    point.m_combinedFriction = gCalculateCombinedFrictionCallback(&a, &b);
    point.m_combinedRestitution = gCalculateCombinedRestitutionCallback(&a, &b);
    point.m_combinedRollingFriction = gCalculateCombinedRollingFrictionCallback(&a, &b);
    point.m_combinedSpinningFriction = gCalculateCombinedSpinningFrictionCallback(&a, &b);
    const int flags = a.getCollisionFlags() | b.getCollisionFlags();
    if (flags & btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING) {
        point.m_combinedContactDamping1 = gCalculateCombinedContactDampingCallback(&a, &b);
        point.m_combinedContactStiffness1 = gCalculateCombinedContactStiffnessCallback(&a, &b);
        point.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
    }
    if (flags & btCollisionObject::CF_HAS_FRICTION_ANCHOR)
        point.m_contactPointFlags |= BT_CONTACT_FLAG_FRICTION_ANCHOR;
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

/// How far the two places of a point may be apart for it to hold in the next step: Bullet's rule.
btScalar breaking_threshold(const btCollisionObject& a, const btCollisionObject& b) {
    const auto of = [](const btCollisionObject& object) {
        return object.getCollisionShape()->getContactBreakingThreshold(gContactBreakingThreshold);
    };
    return std::min(of(a), of(b));
}

/// True if some contact's way out is that of the whole body, and long.
bool leads_far(std::span<const Contact> contacts, btScalar threshold) {
    return std::ranges::any_of(contacts, [threshold](const Contact& c) {
        return c.found == Found::separation && c.penetration_depth() > threshold;
    });
}

/// Puts a point of the last step where the two bodies have taken it; false if it does not hold any
/// more, by the rule of btPersistentManifold::refreshContactPoints().
bool follow(btManifoldPoint& point, const btCollisionObject& a, const btCollisionObject& b,
            btScalar threshold) {
    point.m_positionWorldOnA = a.getWorldTransform() * point.m_localPointA;
    point.m_positionWorldOnB = b.getWorldTransform() * point.m_localPointB;
    const btVector3 apart = point.m_positionWorldOnA - point.m_positionWorldOnB;
    point.m_distance1 = apart.dot(point.m_normalWorldOnB);
    ++point.m_lifeTime;
    const btVector3 aside = apart - point.m_distance1 * point.m_normalWorldOnB;
    return point.m_distance1 <= threshold && aside.length() <= threshold;
}

/// Moves those points over that still hold.
Points take_holding(PointMap& last, const btCollisionObject& a, const btCollisionObject& b,
                    btScalar threshold) {
    Points points;
    for (auto it = last.begin(); it != last.end();) {
        const bool holds = follow(it->second, a, b, threshold);
        if (holds) points.emplace_back(*it);
        it = holds ? last.erase(it) : std::next(it);
    }
    return points;
}

void take_impulses(btManifoldPoint& point, const btManifoldPoint& last) {
    point.m_appliedImpulse = last.m_appliedImpulse;
    point.m_appliedImpulseLateral1 = last.m_appliedImpulseLateral1;
    point.m_appliedImpulseLateral2 = last.m_appliedImpulseLateral2;
    point.m_lifeTime = last.m_lifeTime + 1;
    point.m_userPersistentData = last.m_userPersistentData;
}

/// The points of at most `most` of the contacts; those of the last step that go on in them are
/// taken from `last`.
Points make_points(const ContactSide& a, const ContactSide& b, std::span<const Contact> contacts,
                   std::uint32_t most, const std::optional<Parting>& way_apart, PointMap& last) {
    Points points;
    for (const ReducedContact& reduced : reduce(contacts, most)) {
        const Contact& contact = contacts[reduced.contact];
        btManifoldPoint point = make_point(
            way_apart ? parting_frame(contact, *way_apart) : face_frame(contact), *a.object,
            *b.object);
        point.m_index0 = bullet_index(a, contact.triangle, contact.source == Side::b);
        point.m_index1 = bullet_index(b, contact.triangle, contact.source == Side::a);
        if (const auto before = last.find(contact.feature()); before != last.end()) {
            take_impulses(point, before->second);
            last.erase(before);
        }
        call_back(point, *a.object, *b.object);
        points.emplace_back(contact.feature(), point);
    }
    return points;
}

/// Adds a point for every meeting, which lets the two come together but no further.
void add_meetings(const ContactSide& a, const ContactSide& b,
                  std::span<const ImpactContact> impacts, Points& points) {
    for (const ImpactContact& impact : impacts) {
        const FramedContact framed{.point_a = impact.start_a,
                                   .point_b = impact.start_b,
                                   .normal_on_b = -impact.normal,
                                   .distance = impact.gap,
                                   .feature = no_feature};
        btManifoldPoint point = make_point(framed, *a.object, *b.object);
        point.m_index0 = bullet_index(a, impact.triangle, impact.source == Side::b);
        point.m_index1 = bullet_index(b, impact.triangle, impact.source == Side::a);
        call_back(point, *a.object, *b.object);
        points.emplace_back(no_feature, point);
    }
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
    manifolds_->release(*m_dispatcher);
    set_written(0);
}

void PairAlgorithm::set_written(std::uint32_t count) {
    total_written_ += count - manifolds_->written;
    manifolds_->written = count;
}

void PairAlgorithm::write_manifolds(const ContactSide& a, const ContactSide& b,
                                    std::span<const Contact> contacts, std::uint32_t most,
                                    std::span<const ImpactContact> impacts,
                                    const std::optional<Parting>& way_apart) {
    // An object that is bound anew is another body, and may come after the other object now.
    if (manifolds_->of_a != a.body || manifolds_->of_b != b.body)
        manifolds_->release(*m_dispatcher);
    manifolds_->of_a = a.body;
    manifolds_->of_b = b.body;
    PointMap last = manifolds_->take_points();
    Points points;
    // The way out of a whole body says nothing about linked bodies that overlap by little: it would
    // push one through the other.
    if (!way_apart && !contacts.empty()) {
        const btScalar threshold = breaking_threshold(*a.object, *b.object);
        if (leads_far(contacts, threshold))
            points = take_holding(last, *a.object, *b.object, threshold);
    }
    if (points.empty()) points = make_points(a, b, contacts, most, way_apart, last);
    add_meetings(a, b, impacts, points);
    manifolds_->put_points(*m_dispatcher, a, b, points);
    for (const auto& [feature, point] : last) tell_destroyed(point);
    set_written(static_cast<std::uint32_t>(points.size()));
}

bool PairAlgorithm::has_no_points() const { return manifolds_->manifolds.empty(); }

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
