#include "pierce/bullet/install.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <LinearMath/btIDebugDraw.h>

#include <chrono>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include "bullet/coupling.hpp"
#include "bullet/followed_objects.hpp"
#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/contact_reduction.hpp"
#include "pierce/error.hpp"

namespace pierce::bullet {

/// Bullet's configuration as it was, and the installation: a near callback has no user pointer, but
/// gets the dispatcher, which has the configuration.
class InstalledConfiguration final : public btCollisionConfiguration {
public:
    InstalledConfiguration(btCollisionConfiguration& before, Installation& installation)
        : before_(before), installation_(installation) {}

    Installation& installation() const { return installation_; }
    btCollisionConfiguration& before() const { return before_; }

    btPoolAllocator* getPersistentManifoldPool() override {
        return before_.getPersistentManifoldPool();
    }
    btPoolAllocator* getCollisionAlgorithmPool() override {
        return before_.getCollisionAlgorithmPool();
    }
    btCollisionAlgorithmCreateFunc* getCollisionAlgorithmCreateFunc(int type_a,
                                                                    int type_b) override {
        return before_.getCollisionAlgorithmCreateFunc(type_a, type_b);
    }
    btCollisionAlgorithmCreateFunc* getClosestPointsAlgorithmCreateFunc(int type_a,
                                                                        int type_b) override {
        return before_.getClosestPointsAlgorithmCreateFunc(type_a, type_b);
    }

private:
    btCollisionConfiguration& before_;
    Installation& installation_;
};

namespace {

InstalledConfiguration* installed_in(btCollisionDispatcher& dispatcher) {
    return dynamic_cast<InstalledConfiguration*>(dispatcher.getCollisionConfiguration());
}

btCollisionObject& object_of(const btBroadphaseProxy& proxy) {
    return *static_cast<btCollisionObject*>(proxy.m_clientObject);
}

/// True if an anchor holds the soft body to the other one, and is to keep them from colliding.
/// Bullet asks only where it looks for contacts itself.
bool is_anchored(const btSoftBody* soft, const btCollisionObject* other) {
    if (soft == nullptr) return false;
    const auto& disabled = soft->m_collisionDisabledObjects;
    return disabled.findLinearSearch(other) < disabled.size();
}

/// True if Bullet's filters let the two meet. Bullet does not ask about two bodies that sleep, but
/// the arrays of soft ones are emptied in every step, and a program may have put one elsewhere.
bool may_meet(btCollisionDispatcher& dispatcher, const Coupling& coupling, const Binding& a,
              const Binding& b) {
    if (is_anchored(a.soft, b.object) || is_anchored(b.soft, a.object)) return false;
    if (dispatcher.needsCollision(a.object, b.object)) return true;
    const bool sleep = !a.object->isActive() && !b.object->isActive();
    const bool asked = a.soft != nullptr || b.soft != nullptr || coupling.has_moved_lately(a) ||
                       coupling.has_moved_lately(b);
    return sleep && asked && a.object->checkCollideWith(b.object) &&
           b.object->checkCollideWith(a.object);
}

}  // namespace

struct Installation::State final : public btActionInterface {
    State(btDiscreteDynamicsWorld& bullet_world, btCollisionDispatcher& bullet_dispatcher,
          World& contacts, const InstallOptions& settings)
        : bullet(bullet_world),
          dispatcher(bullet_dispatcher),
          options(settings),
          coupling(contacts, settings.most_per_pair),
          followed(bullet_world, coupling) {}

    static void near_callback(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                              const btDispatcherInfo& info);
    void meet(btBroadphasePair& pair, Binding& a, Binding& b);
    PairAlgorithm& algorithm_of(btBroadphasePair& pair);
    void follow();
    bool is_own(const btBroadphasePair& pair) const;
    void note_look_at(const btBroadphasePair& pair);
    void begin_pass();
    void detect();
    void bind(btCollisionObject& object, btSoftBody* soft, BodyId body);
    void forget_pairs_of(const btCollisionObject* object);

    /// Bullet calls this when rigid bodies have moved, and before soft bodies are solved.
    void updateAction(btCollisionWorld* world, btScalar dt) override;
    void debugDraw(btIDebugDraw* drawer) override;

    btDiscreteDynamicsWorld& bullet;
    btCollisionDispatcher& dispatcher;
    InstallOptions options;
    Coupling coupling;
    FollowedObjects followed;
    std::unique_ptr<InstalledConfiguration> configuration;
    btNearCallback before = nullptr;
    std::mutex one_at_a_time;     ///< Bullet's dispatchers with threads call back from any of them
    std::vector<PoseAhead> fast;  ///< where fast bodies go in this step
    bool pass_begins = true;
    bool has_changed = false;  ///< bodies have come or gone since contacts were looked for
    bool has_detected = false, had_detected = false;  ///< in this step; in the one before
    std::uint64_t pass = 0;
    std::vector<std::uint64_t> seen_in;  ///< per pair of the world's cache, the last pass with it
    double response = 0, last_response = 0;  ///< [ms]
};

/// A program may have deleted objects at any time: they are looked for before bodies are looked at.
void Installation::State::follow() {
    if (options.automatic && followed.follow()) has_changed = true;
}

/// True if the pair is in the world's cache. Ghosts have caches of their own, and worlds may share
/// a dispatcher; what looks at such pairs says nothing about the step.
bool Installation::State::is_own(const btBroadphasePair& pair) const {
    const btBroadphasePairArray& all = bullet.getPairCache()->getOverlappingPairArray();
    return all.size() > 0 && !std::less<>()(&pair, &all[0]) &&
           std::less<>()(&pair, &all[0] + all.size());
}

/// Bullet looks at each pair once in a pass.
void Installation::State::note_look_at(const btBroadphasePair& pair) {
    const btBroadphasePairArray& all = bullet.getPairCache()->getOverlappingPairArray();
    const auto number = static_cast<std::size_t>(&pair - &all[0]);
    if (number >= seen_in.size()) seen_in.resize(static_cast<std::size_t>(all.size()), 0);
    if (pass_begins || seen_in[number] == pass) begin_pass();
    seen_in[number] = pass;
}

/// A pass is one look of Bullet's at all pairs whose boxes overlap. A program may look several
/// times in a step, or between steps.
void Installation::State::begin_pass() {
    const bool in_step = !std::exchange(pass_begins, false);
    ++pass;
    follow();
    // Since a look outside of a step, anything may have moved.
    if (in_step && coupling.any_has_moved()) has_detected = false;
    coupling.begin_step();
    fast = options.continuous && bullet.getDispatchInfo().m_useContinuous
               ? coupling.going_fast()
               : std::vector<PoseAhead>{};
    // What is fast may meet others before any of them has moved.
    if (!fast.empty()) detect();
}

void Installation::State::detect() {
    follow();
    coupling.detect();
    coupling.look_ahead(fast);
    has_detected = true;
    has_changed = false;
}

/// Bullet's own algorithm of a pair goes when Pierce takes over, and with it its contacts.
PairAlgorithm& Installation::State::algorithm_of(btBroadphasePair& pair) {
    if (auto* ours = dynamic_cast<PairAlgorithm*>(pair.m_algorithm)) return *ours;
    bullet.getPairCache()->cleanOverlappingPair(pair, &dispatcher);
    void* place = dispatcher.allocateCollisionAlgorithm(sizeof(PairAlgorithm));
    auto* made = new (place) PairAlgorithm(dispatcher, coupling.written());
    pair.m_algorithm = made;
    return *made;
}

void Installation::State::meet(btBroadphasePair& pair, Binding& a, Binding& b) {
    const auto begin = std::chrono::steady_clock::now();
    PairAlgorithm& algorithm = algorithm_of(pair);
    coupling.write(algorithm, a, b);
    response += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                    .count();
}

void Installation::State::near_callback(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
                                        const btDispatcherInfo& info) {
    State& state = *installed_in(dispatcher)->installation().state_;
    if (state.is_own(pair)) {
        const std::scoped_lock lock(state.one_at_a_time);
        state.note_look_at(pair);
        const auto bound = [&](const btBroadphaseProxy& proxy) {
            return state.coupling.find(&object_of(proxy));
        };
        Binding *a = bound(*pair.m_pProxy0), *b = bound(*pair.m_pProxy1);
        if (a != nullptr && b != nullptr) {
            if (!may_meet(dispatcher, state.coupling, *a, *b)) return;
            if (Coupling::has_moved(*a) || Coupling::has_moved(*b)) state.detect();
            // What has become of the two is known now.
            a = bound(*pair.m_pProxy0);
            b = bound(*pair.m_pProxy1);
        }
        if (a != nullptr && b != nullptr) {
            state.meet(pair, *a, *b);
            return;
        }
        if (dynamic_cast<const PairAlgorithm*>(pair.m_algorithm) != nullptr)
            state.bullet.getPairCache()->cleanOverlappingPair(pair, &dispatcher);
    }
    state.before(pair, dispatcher, info);
}

/// Deletes what is kept of the pairs of an object; null: of all objects.
void Installation::State::forget_pairs_of(const btCollisionObject* object) {
    btOverlappingPairCache& pairs = *bullet.getPairCache();
    for (int i = 0; i < pairs.getNumOverlappingPairs(); ++i) {
        btBroadphasePair& pair = pairs.getOverlappingPairArray()[i];
        const bool is_of_object = object == nullptr || pair.m_pProxy0->m_clientObject == object ||
                                  pair.m_pProxy1->m_clientObject == object;
        if (is_of_object && dynamic_cast<PairAlgorithm*>(pair.m_algorithm) != nullptr)
            pairs.cleanOverlappingPair(pair, &dispatcher);
    }
}

void Installation::State::updateAction(btCollisionWorld* /*world*/, btScalar /*dt*/) {
    const std::scoped_lock lock(one_at_a_time);
    if (pass_begins)
        begin_pass();
    else
        follow();
    // What has moved away from all others is in no pair.
    if (!has_detected && (has_changed || coupling.any_has_moved())) detect();
    coupling.write_self();
    had_detected = std::exchange(has_detected, false);
    last_response = std::exchange(response, 0.0);
    pass_begins = true;
}

/// Bullet draws the points of manifolds; these are the others. It asks for them only if it draws
/// wireframes, boxes or normals, too.
void Installation::State::debugDraw(btIDebugDraw* drawer) {
    if ((drawer->getDebugMode() & btIDebugDraw::DBG_DrawContactPoints) == 0) return;
    for (const Contact& c : coupling.soft_contacts())
        drawer->drawContactPoint(to_bullet(c.point_b), to_bullet(-c.normal),
                                 static_cast<btScalar>(c.distance), static_cast<int>(c.age),
                                 drawer->getDefaultColors().m_contactPoint);
}

void Installation::State::bind(btCollisionObject& object, btSoftBody* soft, BodyId body) {
    if ((coupling.world().motion_of(body) == Motion::deforming) != (soft != nullptr))
        throw InputError("body " + std::to_string(body.index) +
                         (soft != nullptr ? " does not deform: it cannot follow a soft body"
                                          : " deforms: it can follow a soft body only"));
    if (followed.has_made(body))
        throw InputError("body " + std::to_string(body.index) +
                         " was made for an object that is followed, and goes with it");
    // Those of the last binding point to its faces.
    coupling.forget_soft_contacts();
    followed.leave(object);
    coupling.bind(object, soft, body);
}

Installation::Installation(std::unique_ptr<State> state) : state_(std::move(state)) {}
Installation::~Installation() = default;

void Installation::bind(btCollisionObject& object, BodyId body) {
    state_->bind(object, nullptr, body);
}

void Installation::bind(btSoftBody& soft, BodyId body) {
    const World& world = state_->coupling.world();
    const Mesh& mesh = world.mesh(world.mesh_of(body));
    if (soft.m_nodes.size() != static_cast<int>(mesh.positions().size()))
        throw InputError("soft body has " + std::to_string(soft.m_nodes.size()) + " nodes, mesh '" +
                         mesh.name() + "' has " + std::to_string(mesh.positions().size()) +
                         " vertices");
    state_->bind(soft, &soft, body);
}

void Installation::unbind(const btCollisionObject& object) {
    state_->follow();
    if (state_->coupling.find(&object) == nullptr && !state_->followed.knows(object)) return;
    state_->forget_pairs_of(&object);
    state_->followed.leave(object);
    state_->coupling.unbind(&object);
    state_->coupling.forget_soft_contacts();
}

BodyId Installation::body_of(const btCollisionObject& object) const {
    const Binding* found = state_->coupling.find(&object);
    return found != nullptr ? found->body : BodyId{};
}

const std::vector<LeftToBullet>& Installation::left_to_bullet() const {
    return state_->followed.left_to_bullet();
}

bool Installation::has_detected() const { return state_->had_detected; }
double Installation::response_milliseconds() const { return state_->last_response; }
std::uint32_t Installation::reduced_contacts() const {
    return state_->coupling.written() + state_->coupling.written_self();
}

Installation& install(btDiscreteDynamicsWorld& bullet, World& contacts,
                      const InstallOptions& options) {
    auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(bullet.getDispatcher());
    if (dispatcher == nullptr)
        throw InputError("the Bullet world has a dispatcher of another kind");
    if (installed_in(*dispatcher) != nullptr)
        throw InputError("Pierce is installed in this dispatcher already");
    if (options.most_per_pair < least_reduced)
        throw InputError("at least " + std::to_string(least_reduced) +
                         " contacts of a pair must reach the solver");
    auto* installation = new Installation(
        std::make_unique<Installation::State>(bullet, *dispatcher, contacts, options));
    Installation::State& state = *installation->state_;
    state.configuration = std::make_unique<InstalledConfiguration>(
        *dispatcher->getCollisionConfiguration(), *installation);
    state.before = dispatcher->getNearCallback();
    dispatcher->setCollisionConfiguration(state.configuration.get());
    dispatcher->setNearCallback(&Installation::State::near_callback);
    bullet.addAction(&state);
    return *installation;
}

void uninstall(btDiscreteDynamicsWorld& bullet) {
    auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(bullet.getDispatcher());
    InstalledConfiguration* configuration = dispatcher != nullptr ? installed_in(*dispatcher)
                                                                  : nullptr;
    if (configuration == nullptr) return;
    Installation* installation = &configuration->installation();
    Installation::State& state = *installation->state_;
    if (&state.bullet != &bullet) return;  // worlds may share a dispatcher
    state.follow();
    state.forget_pairs_of(nullptr);
    // What is not in the world may be deleted.
    const btCollisionObjectArray& objects = bullet.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
        if (const Binding* found = state.coupling.find(objects[i]))
            Coupling::forget_soft_contacts_of({found, 1});
    state.followed.remove_all();
    bullet.removeAction(&state);
    dispatcher->setNearCallback(state.before);
    dispatcher->setCollisionConfiguration(&configuration->before());
    delete installation;
}

}  // namespace pierce::bullet
