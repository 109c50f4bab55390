#include "scenes/detect/detector.hpp"

#include <algorithm>
#include <chrono>

#include "pierce/bullet/baseline_shapes.hpp"
#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "scenes/detect/bullet_result.hpp"
#include "scenes/detect/fcl_detector.hpp"
#include "scenes/detect/soft_sheet.hpp"
#include "scenes/named/pair_rules.hpp"

namespace pierce::scenes {
namespace {

std::vector<Vec3f> start_positions(const SceneBody& body, const MeshData& mesh) {
    const Frame frame = frame_of(body.pose);
    std::vector<Vec3f> positions;
    positions.reserve(mesh.positions.size());
    for (Vec3f p : mesh.positions) positions.push_back(to_float(frame.to_parent(to_double(p))));
    return positions;
}

Box box_of(std::span<const Vec3f> positions) {
    Box box;
    for (Vec3f p : positions) box.extend(to_double(p));
    return box;
}

/// Stretched to a cube around the origin that has room for twice the body, however it turns:
/// GImpact's tree keeps boxes in steps of the box that it was built in, and a body that deforms
/// must fit in there later.
std::vector<Vec3f> with_room(std::vector<Vec3f> positions) {
    const Box box = box_of(positions);
    const Vec3d center = box.center(), half = box.half_size();
    const double room = 2 * length(half);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        Vec3d p = to_double(positions[i]) - center;
        for (int k = 0; k < 3; ++k)
            p[k] = half[k] > 0 ? room * p[k] / half[k] : (i % 2 == 0 ? room : -room);
        positions[i] = to_float(p);
    }
    return positions;
}

/// Stages that keep boxes, pairs and trees up to date; all others are the narrow phase.
bool is_update(StageId stage) {
    return stage == StageId::bounds || stage == StageId::pairs || stage == StageId::update;
}

class RayDetector : public Detector {
public:
    RayDetector(const SceneSetup& scene, std::unique_ptr<Backend> backend, const Settings& settings,
                const MeshOptions& options)
        : scene_(scene, std::move(backend), settings, options) {
        for (const SceneBody& body : scene.bodies) meshes_.push_back(body.mesh);
        is_placed_.assign(scene.bodies.size(), false);
    }

    // A body that is put somewhere for the first time has not moved there.
    void set_pose(std::uint32_t body, const Pose& pose) override {
        if (is_placed_[body]) return scene_.world.set_pose(scene_.bodies[body], pose);
        is_placed_[body] = true;
        scene_.world.set_motion(scene_.bodies[body], pose, pose);
    }
    void set_positions(std::uint32_t body, std::span<const Vec3f> positions) override {
        if (is_placed_[body]) return scene_.world.set_positions(scene_.bodies[body], positions);
        is_placed_[body] = true;
        scene_.world.set_motion(scene_.bodies[body], positions, positions);
    }
    void set_mesh(std::uint32_t body, const Recording& recording, std::uint32_t mesh,
                  std::span<const Vec3f> positions) override {
        if (meshes_[body] == mesh) return;
        meshes_[body] = mesh;
        scene_.set_mesh(body, recording.meshes[mesh], positions);
    }
    FrameResult detect() override {
        scene_.world.detect();
        return scene_.result();
    }
    World* world() override { return &scene_.world; }

    std::vector<MethodContact> contacts() const override {
        std::vector<MethodContact> list;
        for (const Contact& c : scene_.world.contacts()) {
            MethodContact m{.a = scene_.index_of(c.a),
                            .b = scene_.index_of(c.b),
                            .source = 0,
                            .vertex = no_vertex,
                            .depth = c.penetration_depth(),
                            .normal = c.normal};
            m.source = c.source == Side::a ? m.a : m.b;
            if (!c.is_edge()) m.vertex = c.vertex;
            list.push_back(m);
        }
        return list;
    }

private:
    SceneWorld scene_;
    std::vector<std::uint32_t> meshes_;  ///< by body, like the next one
    std::vector<bool> is_placed_;
};

/// Tells Bullet's broadphase which bodies meet. Objects' user indices are places of bodies.
class OverlapFilter : public btOverlapFilterCallback {
public:
    explicit OverlapFilter(const SceneSetup& scene) : rules_(scene) {}

    bool needBroadphaseCollision(btBroadphaseProxy* first,
                                 btBroadphaseProxy* second) const override {
        return rules_.allow(body_of(first), body_of(second));
    }

private:
    static std::uint32_t body_of(const btBroadphaseProxy* proxy) {
        return static_cast<std::uint32_t>(
            static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex());
    }

    PairRules rules_;
};

/// Bullet's collision world without dynamics.
class BulletDetector : public Detector {
public:
    BulletDetector(const SceneSetup& scene, bullet::Baseline method)
        : filter_(scene),
          dispatcher_(&configuration_),
          world_(&dispatcher_, &broadphase_, &configuration_) {
        register_baseline(dispatcher_);
        broadphase_.getOverlappingPairCache()->setOverlapFilterCallback(&filter_);
        shapes_.reserve(scene.bodies.size());
        for (const SceneBody& body : scene.bodies) {
            const SceneMesh& mesh = scene.meshes[body.mesh];
            const bool deforms = body.motion == Motion::deforming;
            if (deforms && method != bullet::Baseline::gimpact)
                throw InputError("its shapes cannot follow deforming bodies");
            MeshData data = mesh.data;
            if (deforms) data.positions = with_room(start_positions(body, mesh.data));
            shapes_.push_back(body.ground ? bullet::BaselineShape::ground(data)
                                          : bullet::BaselineShape(method, mesh.name, data,
                                                                  mesh.convex_pieces,
                                                                  scene.baseline_margin));
            auto object = std::make_unique<btCollisionObject>();
            object->setCollisionShape(&shapes_.back().shape());
            if (!deforms) object->setWorldTransform(bullet::to_bullet(body.pose));
            object->setUserIndex(static_cast<int>(objects_.size()));
            if (body.motion == Motion::fixed)
                object->setCollisionFlags(object->getCollisionFlags() |
                                          btCollisionObject::CF_STATIC_OBJECT);
            world_.addCollisionObject(object.get());
            objects_.push_back(std::move(object));
        }
    }

    ~BulletDetector() override {
        for (const auto& object : objects_) world_.removeCollisionObject(object.get());
    }

    void set_pose(std::uint32_t body, const Pose& pose) override {
        objects_[body]->setWorldTransform(bullet::to_bullet(pose));
    }

    void set_positions(std::uint32_t body, std::span<const Vec3f> positions) override {
        const auto begin = std::chrono::steady_clock::now();
        const Vec3d center = box_of(positions).center();
        std::vector<Vec3f> around;
        for (Vec3f p : positions) around.push_back(to_float(to_double(p) - center));
        shapes_[body].set_positions(around);
        objects_[body]->setWorldTransform(bullet::to_bullet(Pose{center, {}}));
        refit_ms_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                               begin)
                         .count();
    }

    FrameResult detect() override {
        configuration_.take_epa_milliseconds();
        const auto begin = std::chrono::steady_clock::now();
        world_.performDiscreteCollisionDetection();
        const double all = std::chrono::duration<double, std::milli>(
                               std::chrono::steady_clock::now() - begin)
                               .count();
        return bullet_result(dispatcher_, shapes_, Margin::left_out, all,
                             std::exchange(refit_ms_, 0.0), configuration_.take_epa_milliseconds());
    }

    std::vector<MethodContact> contacts() const override {
        return bullet_contacts(dispatcher_, shapes_, Margin::left_out);
    }

private:
    OverlapFilter filter_;
    bullet::TimedConfiguration configuration_;
    TimedDispatcher dispatcher_;
    btDbvtBroadphase broadphase_;
    btCollisionWorld world_;
    std::vector<bullet::BaselineShape> shapes_;
    std::vector<std::unique_ptr<btCollisionObject>> objects_;
    double refit_ms_ = 0;
};

/// Bullet's clusters of nodes. It finds contacts of every sheet with itself, and nothing else.
class ClusterDetector : public Detector {
public:
    explicit ClusterDetector(const SceneSetup& scene)
        : sheets_(scene.bodies.size()), positions_(scene.bodies.size()) {
        bool any = false;
        for (std::size_t b = 0; b < sheets_.size(); ++b) {
            if (!scene.bodies[b].collision.sheet) continue;
            sheets_[b] = std::make_unique<SoftSheet>(info_, scene.bodies[b],
                                                     scene.meshes[scene.bodies[b].mesh].data);
            sheets_[b]->collide_by_bullet();
            any = true;
        }
        if (!any) throw InputError("bullet-clusters follows sheets only");
    }

    void set_pose(std::uint32_t, const Pose&) override {}
    void set_positions(std::uint32_t body, std::span<const Vec3f> positions) override {
        positions_[body].assign(positions.begin(), positions.end());
    }

    FrameResult detect() override {
        const auto begin = std::chrono::steady_clock::now();
        FrameResult result;
        for (std::uint32_t b = 0; b < sheets_.size(); ++b) {
            if (!sheets_[b] || positions_[b].empty()) continue;
            const std::uint32_t found = sheets_[b]->meetings_at(positions_[b]);
            result.contacts += found;
            ++result.pairs;
            if (found > 0) result.touching.emplace_back(b, b);
        }
        result.total_ms = result.narrow_ms = std::chrono::duration<double, std::milli>(
                                                 std::chrono::steady_clock::now() - begin)
                                                 .count();
        result.times.push_back({"clusters", result.total_ms});
        return result;
    }

    /// Clusters in contact name no vertex and no place of the mesh.
    std::vector<MethodContact> contacts() const override { return {}; }

private:
    btSoftBodyWorldInfo info_;
    std::vector<std::unique_ptr<SoftSheet>> sheets_;  ///< by body, null if it is no sheet
    std::vector<std::vector<Vec3f>> positions_;
};

}  // namespace

SceneWorld::SceneWorld(const SceneSetup& scene, const RaySettings& settings)
    : SceneWorld(scene, make_backend(settings), settings.world, settings.mesh_options()) {}

void Detector::set_mesh(std::uint32_t, const Recording&, std::uint32_t, std::span<const Vec3f>) {
    throw InputError("only rays follow bodies whose mesh changes");
}

namespace {

MeshOptions options_for(const SceneMesh& mesh, bool is_sheet, MeshOptions options) {
    if (mesh.inside != Inside::automatic)
        options.inside = mesh.inside;
    else if (is_sheet)
        options.inside = Inside::none;
    return options;
}

}  // namespace

SceneWorld::SceneWorld(const SceneSetup& scene, std::unique_ptr<Backend> backend,
                       const Settings& settings, const MeshOptions& options)
    : world(std::move(backend), settings), options_(options) {
    // Meshes that bodies get later are added then.
    std::vector<MeshId> meshes(scene.meshes.size());
    for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
        const SceneMesh& mesh = scene.meshes[m];
        const auto has_it = [&](const SceneBody& b) { return b.mesh == m; };
        if (std::ranges::none_of(scene.bodies, has_it)) continue;
        const bool is_sheet = std::ranges::any_of(
            scene.bodies, [&](const SceneBody& b) { return has_it(b) && b.collision.sheet; });
        meshes[m] = world.add_mesh(mesh.name, mesh.data, options_for(mesh, is_sheet, options_));
    }
    for (const SceneBody& body : scene.bodies) {
        const MeshId mesh = meshes[body.mesh];
        switch (body.motion) {
            case Motion::fixed:
                bodies.push_back(world.add_fixed_body(mesh, body.pose));
                break;
            case Motion::rigid:
                bodies.push_back(world.add_rigid_body(mesh, body.pose));
                break;
            case Motion::deforming:
                bodies.push_back(world.add_deforming_body(
                    mesh, start_positions(body, scene.meshes[body.mesh].data)));
                break;
        }
        world.set_collision(bodies.back(), body.collision);
        world.set_filter(bodies.back(), body.filter);
    }
    for (const auto& [a, b] : scene.excluded) world.exclude(bodies[a], bodies[b]);
}

void SceneWorld::set_mesh(std::uint32_t body, const SceneMesh& mesh,
                          std::span<const Vec3f> positions) {
    const BodyId id = bodies[body];
    const MeshId before = world.mesh_of(id);
    const bool is_sheet = world.collision_of(id).sheet;
    world.set_mesh(
        id, world.add_mesh(mesh.name, mesh.data, before, options_for(mesh, is_sheet, options_)),
        positions);
    if (std::ranges::none_of(bodies, [&](BodyId b) { return world.mesh_of(b) == before; }))
        world.remove_mesh(before);
}

std::uint32_t SceneWorld::index_of(BodyId body) const { return body.index; }

FrameResult SceneWorld::result() const {
    FrameResult result;
    static_cast<StepStats&>(result) = world.stats();
    result.name_stages(result.stages);
    for (const StageTime& t : result.stages)
        (is_update(t.stage) ? result.update_ms : result.narrow_ms) += t.milliseconds;
    if (result.device_milliseconds > 0) {
        result.times.push_back({"device", result.device_milliseconds});
        result.narrow_ms += result.device_milliseconds;
    }
    result.total_ms = result.milliseconds;
    result.hash = contact_hash(world.contacts());
    BodyId last_a, last_b;
    for (const Contact& c : world.contacts()) {
        if (c.a != last_a || c.b != last_b)
            result.touching.emplace_back(index_of(c.a), index_of(c.b));
        last_a = c.a;
        last_b = c.b;
        const bool known = !result.penetrating.empty() &&
                           result.penetrating.back() == result.touching.back();
        if (c.penetration_depth() > 0 && !known)
            result.penetrating.push_back(result.touching.back());
    }
    std::ranges::sort(result.touching);
    std::ranges::sort(result.penetrating);
    return result;
}

std::unique_ptr<Detector> make_detector(const SceneSetup& scene, Method method,
                                        const RaySettings& rays) {
    switch (method) {
        case Method::rays:
            return std::make_unique<RayDetector>(scene, make_backend(rays), rays.world,
                                                 rays.mesh_options());
        case Method::gjk_epa:
            return std::make_unique<BulletDetector>(scene, bullet::Baseline::gjk_epa);
        case Method::gjk_hull:
            return std::make_unique<BulletDetector>(scene, bullet::Baseline::gjk_hull);
        case Method::gimpact:
            return std::make_unique<BulletDetector>(scene, bullet::Baseline::gimpact);
        case Method::fcl:
            return make_fcl_detector(scene);
        case Method::bullet_clusters:
            return std::make_unique<ClusterDetector>(scene);
    }
    throw InputError("unknown method");
}

std::unique_ptr<Detector> make_detector(const SceneSetup& scene, std::unique_ptr<Backend> backend,
                                        const Settings& settings) {
    return std::make_unique<RayDetector>(scene, std::move(backend), settings, MeshOptions{});
}

void put_frame(Detector& detector, const Recording& recording, std::uint32_t frame) {
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        const RecordedBody& body = recording.bodies[b];
        if (body.motion != Motion::deforming) {
            detector.set_pose(b, recording.pose(b, frame));
            continue;
        }
        const std::span<const Vec3f> positions = recording.positions(b, frame);
        if (!body.mesh_changes.empty())
            detector.set_mesh(b, recording, recording.mesh_of(b, frame), positions);
        detector.set_positions(b, positions);
    }
}

}  // namespace pierce::scenes
