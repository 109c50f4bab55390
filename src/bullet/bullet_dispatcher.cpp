#include "pierce/bullet/bullet_dispatcher.hpp"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBody.h>

#include <chrono>
#include <deque>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bullet/soft_response.hpp"
#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/error.hpp"

namespace pierce::bullet {
namespace {

/// A Bullet object bound to a body.
struct Binding {
    btCollisionObject* object = nullptr;
    btSoftBody* soft = nullptr;  ///< the object, if it is soft
    BodyId body;
};

/// The manifolds of one pair of rigid bodies, and the points in them by feature.
struct PairManifolds {
    std::vector<btPersistentManifold*> manifolds;
    std::map<std::uint64_t, btManifoldPoint> last_points;
    bool touched = false;  ///< in this step
};

using Pairs = std::map<std::pair<BodyId, BodyId>, PairManifolds>;

btManifoldPoint make_point(const FramedContact& contact, const btCollisionObject& a,
                           const btCollisionObject& b) {
    const btVector3 on_a = to_bullet(contact.point_a), on_b = to_bullet(contact.point_b);
    btManifoldPoint point(a.getWorldTransform().invXform(on_a),
                          b.getWorldTransform().invXform(on_b), to_bullet(contact.normal_on_b),
                          static_cast<btScalar>(contact.distance));
    point.m_positionWorldOnA = on_a;
    point.m_positionWorldOnB = on_b;
    point.m_combinedFriction = btManifoldResult::calculateCombinedFriction(&a, &b);
    point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(&a, &b);
    point.m_combinedRollingFriction = btManifoldResult::calculateCombinedRollingFriction(&a, &b);
    point.m_combinedSpinningFriction = btManifoldResult::calculateCombinedSpinningFriction(&a, &b);
    return point;
}

}  // namespace

struct Dispatcher::State {
    World& world;
    ReductionSettings reduction;
    std::unordered_map<const btCollisionObject*, std::size_t> by_object;
    std::unordered_map<BodyId, std::size_t> by_body;
    std::vector<Binding> bindings;
    Pairs pairs;
    std::vector<Vec3f> positions;            ///< scratch
    std::deque<btSoftBody::Face> hit_faces;  ///< of the last step's contacts; Bullet has their
                                             ///< addresses
    double response_milliseconds = 0;
    std::uint32_t reduced_contacts = 0;

    bool is_bound(const btCollisionObject* object) const { return by_object.contains(object); }
    void bind(Dispatcher& dispatcher, btCollisionObject& object, btSoftBody* soft, BodyId body);
    void unbind(Dispatcher& dispatcher, std::size_t binding);
    btSoftBody::Face& face_of(const Binding& target, const Contact& contact);
    void read_bodies();
    void write_contacts(Dispatcher& dispatcher);
    void write_manifolds(Dispatcher& dispatcher, const Binding& a, const Binding& b,
                         std::span<const Contact> contacts);
    void release_untouched(Dispatcher& dispatcher);
};

void Dispatcher::State::bind(Dispatcher& dispatcher, btCollisionObject& object, btSoftBody* soft,
                             BodyId body) {
    if (const auto last = by_object.find(&object); last != by_object.end())
        unbind(dispatcher, last->second);
    if (const auto last = by_body.find(body); last != by_body.end())
        unbind(dispatcher, last->second);
    by_object[&object] = bindings.size();
    by_body[body] = bindings.size();
    bindings.push_back({&object, soft, body});
}

/// Leaves nothing that points to the object.
void Dispatcher::State::unbind(Dispatcher& dispatcher, std::size_t binding) {
    const Binding gone = bindings[binding];
    std::erase_if(pairs, [&](const auto& entry) {
        const auto& [bodies, pair] = entry;
        if (bodies.first != gone.body && bodies.second != gone.body) return false;
        for (btPersistentManifold* manifold : pair.manifolds) dispatcher.releaseManifold(manifold);
        return true;
    });
    for (const Binding& other : bindings) {
        if (other.soft == nullptr) continue;
        other.soft->m_rcontacts.resizeNoInitialize(0);
        other.soft->m_scontacts.resizeNoInitialize(0);
    }
    by_object.erase(gone.object);
    by_body.erase(gone.body);
    bindings[binding] = bindings.back();
    bindings.pop_back();
    if (binding == bindings.size()) return;
    by_object[bindings[binding].object] = binding;
    by_body[bindings[binding].body] = binding;
}

/// The triangle that was hit, as Bullet's solver wants it. The soft body's own faces need not be
/// those of the mesh's surface.
btSoftBody::Face& Dispatcher::State::face_of(const Binding& target, const Contact& contact) {
    const Mesh& mesh = world.mesh(world.mesh_of(target.body));
    btSoftBody::Face& face = hit_faces.emplace_back();
    for (int k = 0; k < 3; ++k)
        face.m_n[k] = &target.soft->m_nodes[static_cast<int>(
            mesh.triangles()[contact.triangle].vertex[k])];
    return face;
}

/// Copies poses and positions from Bullet.
void Dispatcher::State::read_bodies() {
    for (const Binding& binding : bindings) {
        if (binding.soft == nullptr) {
            world.set_pose(binding.body, from_bullet(binding.object->getWorldTransform()));
            continue;
        }
        positions.clear();
        for (int i = 0; i < binding.soft->m_nodes.size(); ++i)
            positions.push_back(from_bullet_float(binding.soft->m_nodes[i].m_x));
        world.set_positions(binding.body, positions);
    }
}

/// Fills one pair's manifolds anew; points of a vertex that was in contact before keep their
/// impulses.
void Dispatcher::State::write_manifolds(Dispatcher& dispatcher, const Binding& a, const Binding& b,
                                        std::span<const Contact> contacts) {
    std::vector<FramedContact> framed;
    for (const Contact& c : contacts) framed.push_back(face_frame(c));
    const std::vector<FramedContact> reduced = reduce(framed, reduction);
    reduced_contacts += static_cast<std::uint32_t>(reduced.size());

    PairManifolds& pair = pairs[{a.body, b.body}];
    pair.touched = true;
    const std::size_t needed = (reduced.size() + MANIFOLD_CACHE_SIZE - 1) / MANIFOLD_CACHE_SIZE;
    while (pair.manifolds.size() > needed) {
        dispatcher.releaseManifold(pair.manifolds.back());
        pair.manifolds.pop_back();
    }
    while (pair.manifolds.size() < needed)
        pair.manifolds.push_back(dispatcher.getNewManifold(a.object, b.object));

    pair.last_points.clear();
    for (btPersistentManifold* manifold : pair.manifolds) {
        for (int i = 0; i < manifold->getNumContacts(); ++i) {
            const btManifoldPoint& point = manifold->getContactPoint(i);
            const auto feature = static_cast<std::uint64_t>(
                                     static_cast<std::uint32_t>(point.m_index0))
                                     << 32 |
                                 static_cast<std::uint32_t>(point.m_index1);
            pair.last_points.emplace(feature, point);
        }
        manifold->setNumContacts(0);
    }
    for (std::size_t i = 0; i < reduced.size(); ++i) {
        btManifoldPoint point = make_point(reduced[i], *a.object, *b.object);
        point.m_index0 = static_cast<int>(reduced[i].feature >> 32);
        point.m_index1 = static_cast<int>(reduced[i].feature & 0xffffffffu);
        if (const auto last = pair.last_points.find(reduced[i].feature);
            last != pair.last_points.end()) {
            point.m_appliedImpulse = last->second.m_appliedImpulse;
            point.m_appliedImpulseLateral1 = last->second.m_appliedImpulseLateral1;
            point.m_appliedImpulseLateral2 = last->second.m_appliedImpulseLateral2;
            point.m_lifeTime = last->second.m_lifeTime + 1;
        }
        pair.manifolds[i / MANIFOLD_CACHE_SIZE]->addManifoldPoint(point);
    }
}

void Dispatcher::State::release_untouched(Dispatcher& dispatcher) {
    for (auto it = pairs.begin(); it != pairs.end();) {
        if (std::exchange(it->second.touched, false)) {
            ++it;
            continue;
        }
        for (btPersistentManifold* manifold : it->second.manifolds)
            dispatcher.releaseManifold(manifold);
        it = pairs.erase(it);
    }
}

void Dispatcher::State::write_contacts(Dispatcher& dispatcher) {
    reduced_contacts = 0;
    hit_faces.clear();
    const std::span<const Contact> contacts = world.contacts();
    for (std::size_t begin = 0, end = 0; begin < contacts.size(); begin = end) {
        while (end < contacts.size() && contacts[end].a == contacts[begin].a &&
               contacts[end].b == contacts[begin].b)
            ++end;
        const auto a = by_body.find(contacts[begin].a), b = by_body.find(contacts[begin].b);
        if (a == by_body.end() || b == by_body.end())
            continue;  // one of the bodies is not bound to a Bullet object
        const Binding& binding_a = bindings[a->second];
        const Binding& binding_b = bindings[b->second];
        const std::span<const Contact> of_pair = contacts.subspan(begin, end - begin);
        if (binding_a.soft == nullptr && binding_b.soft == nullptr) {
            write_manifolds(dispatcher, binding_a, binding_b, of_pair);
            continue;
        }
        for (const Contact& c : of_pair) {
            if (c.distance > 0) continue;  // Bullet's soft contacts know no gap
            const Binding& source = c.source == Side::a ? binding_a : binding_b;
            const Binding& target = c.source == Side::a ? binding_b : binding_a;
            if (source.soft != nullptr && target.soft != nullptr)
                add_soft_soft(*source.soft, face_of(target, c), *target.soft, c);
            else if (source.soft != nullptr)
                add_soft_rigid(*source.soft, *target.object, c);
            else
                add_rigid_soft(*source.object, face_of(target, c), *target.soft, c);
            ++reduced_contacts;
        }
    }
    release_untouched(dispatcher);
}

Dispatcher::Dispatcher(btCollisionConfiguration* configuration, World& world,
                       ReductionSettings reduction)
    : btCollisionDispatcher(configuration),
      state_(new State{.world = world,
                       .reduction = reduction,
                       .by_object = {},
                       .by_body = {},
                       .bindings = {},
                       .pairs = {},
                       .positions = {},
                       .hit_faces = {}}) {
    // Pierce handles pairs of bound objects. The callback has no user pointer, but it gets this
    // dispatcher as an argument.
    setNearCallback([](btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                       const btDispatcherInfo& info) {
        const State& state = *static_cast<Dispatcher&>(dispatcher).state_;
        if (state.is_bound(static_cast<const btCollisionObject*>(pair.m_pProxy0->m_clientObject)) &&
            state.is_bound(static_cast<const btCollisionObject*>(pair.m_pProxy1->m_clientObject))) {
            // Contacts that Bullet found before both were bound go with their algorithm.
            if (pair.m_algorithm != nullptr) {
                pair.m_algorithm->~btCollisionAlgorithm();
                dispatcher.freeCollisionAlgorithm(pair.m_algorithm);
                pair.m_algorithm = nullptr;
            }
            return;
        }
        defaultNearCallback(pair, dispatcher, info);
    });
}

Dispatcher::~Dispatcher() {
    for (auto& [bodies, pair] : state_->pairs)
        for (btPersistentManifold* manifold : pair.manifolds) releaseManifold(manifold);
}

void Dispatcher::bind(btRigidBody& rigid, BodyId body) {
    state_->bind(*this, rigid, nullptr, body);
}

void Dispatcher::bind(btSoftBody& soft, BodyId body) {
    const Mesh& mesh = state_->world.mesh(state_->world.mesh_of(body));
    if (soft.m_nodes.size() != static_cast<int>(mesh.positions().size()))
        throw InputError("soft body has " + std::to_string(soft.m_nodes.size()) + " nodes, mesh '" +
                         mesh.name() + "' has " + std::to_string(mesh.positions().size()) +
                         " vertices");
    state_->bind(*this, soft, &soft, body);
}

void Dispatcher::unbind(const btCollisionObject& object) {
    if (const auto bound = state_->by_object.find(&object); bound != state_->by_object.end())
        state_->unbind(*this, bound->second);
}

void Dispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pairs,
                                           const btDispatcherInfo& info, btDispatcher* dispatcher) {
    btCollisionDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
    state_->read_bodies();
    state_->world.detect();
    const auto begin = std::chrono::steady_clock::now();
    state_->write_contacts(*this);
    state_->response_milliseconds = std::chrono::duration<double, std::milli>(
                                        std::chrono::steady_clock::now() - begin)
                                        .count();
}

double Dispatcher::response_milliseconds() const { return state_->response_milliseconds; }
std::uint32_t Dispatcher::reduced_contacts() const { return state_->reduced_contacts; }

}  // namespace pierce::bullet
