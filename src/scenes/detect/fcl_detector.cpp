#include "scenes/detect/fcl_detector.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "pierce/error.hpp"

#if defined(PIERCE_HAS_FCL)

// FCL's headers do not pass this project's warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#pragma GCC diagnostic pop

#include "scenes/named/pair_rules.hpp"

namespace pierce::scenes {
namespace {

using Clock = std::chrono::steady_clock;
using Model = fcl::BVHModel<fcl::OBBRSSd>;

fcl::Vector3d to_fcl(Vec3d v) { return {v.x, v.y, v.z}; }
Vec3d from_fcl(const fcl::Vector3d& v) { return {v[0], v[1], v[2]}; }

fcl::Transform3d to_fcl(const Pose& pose) {
    fcl::Transform3d transform = fcl::Transform3d::Identity();
    const Quaternion& q = pose.rotation;
    transform.translation() = to_fcl(pose.position);
    transform.linear() = fcl::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
    return transform;
}

std::vector<fcl::Vector3d> points_of(std::span<const Vec3f> positions) {
    std::vector<fcl::Vector3d> points;
    points.reserve(positions.size());
    for (Vec3f p : positions) points.push_back(to_fcl(to_double(p)));
    return points;
}

std::shared_ptr<Model> model_of(std::span<const Vec3f> positions,
                                std::span<const Triangle> triangles) {
    std::vector<fcl::Triangle> list;
    list.reserve(triangles.size());
    for (const Triangle& t : triangles) list.emplace_back(t.vertex[0], t.vertex[1], t.vertex[2]);
    auto model = std::make_shared<Model>();
    model->beginModel();
    model->addSubModel(points_of(positions), list);
    model->endModel();
    return model;
}

std::uint32_t index_of(const fcl::CollisionObjectd& object) {
    return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(object.getUserData()));
}

double milliseconds_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

class FclDetector : public Detector {
public:
    explicit FclDetector(const SceneSetup& scene) : found_{.rules = PairRules(scene)} {
        std::vector<std::shared_ptr<Model>> models(scene.meshes.size());
        for (const SceneBody& body : scene.bodies) {
            const MeshData& mesh = scene.meshes[body.mesh].data;
            const bool deforms = body.motion == Motion::deforming;
            std::shared_ptr<Model>& shared = models[body.mesh];
            if (!shared) shared = model_of(mesh.positions, mesh.triangles);
            models_.push_back(deforms ? model_of(mesh.positions, mesh.triangles) : shared);
            objects_.push_back(std::make_unique<fcl::CollisionObjectd>(models_.back()));
            fcl::CollisionObjectd& object = *objects_.back();
            if (!deforms) object.setTransform(to_fcl(body.pose));
            object.computeAABB();
            object.setUserData(reinterpret_cast<void*>(objects_.size() - 1));
            manager_.registerObject(&object);
        }
        manager_.setup();
    }

    void set_pose(std::uint32_t body, const Pose& pose) override {
        objects_[body]->setTransform(to_fcl(pose));
    }

    void set_positions(std::uint32_t body, std::span<const Vec3f> positions) override {
        const std::vector<fcl::Vector3d> points = points_of(positions);
        const Clock::time_point begin = Clock::now();
        Model& model = *models_[body];
        model.beginReplaceModel();
        model.replaceSubModel(points);
        model.endReplaceModel(true, true);
        model.computeLocalAABB();
        refit_ms_ += milliseconds_since(begin);
    }

    FrameResult detect() override {
        const Clock::time_point begin = Clock::now();
        for (const auto& object : objects_) object->computeAABB();
        manager_.update();
        const double update = std::exchange(refit_ms_, 0.0) + milliseconds_since(begin);
        found_.contacts.clear();
        found_.pairs = 0;
        const Clock::time_point searched = Clock::now();
        manager_.collide(&found_, add_contacts);
        FrameResult result;
        result.update_ms = update;
        result.narrow_ms = milliseconds_since(searched);
        result.total_ms = result.update_ms + result.narrow_ms;
        result.times = {{"update", result.update_ms}, {"collide", result.narrow_ms}};
        result.pairs = found_.pairs;
        result.contacts = static_cast<std::uint32_t>(found_.contacts.size());
        for (const MethodContact& c : found_.contacts) result.touching.emplace_back(c.a, c.b);
        std::ranges::sort(result.touching);
        const auto repeated = std::ranges::unique(result.touching);
        result.touching.erase(repeated.begin(), repeated.end());
        // Triangles that cross overlap, whatever depth is given to them.
        result.penetrating = result.touching;
        return result;
    }

    std::vector<MethodContact> contacts() const override { return found_.contacts; }

private:
    struct Found {
        PairRules rules;
        std::vector<MethodContact> contacts = {};
        std::uint32_t pairs = 0;
    };

    /// FCL's callback for two objects with overlapping boxes; false: go on.
    static bool add_contacts(fcl::CollisionObjectd* first, fcl::CollisionObjectd* second,
                             void* data) {
        Found& found = *static_cast<Found*>(data);
        if (!found.rules.allow(index_of(*first), index_of(*second))) return false;
        ++found.pairs;
        const bool swap = index_of(*second) < index_of(*first);
        if (swap) std::swap(first, second);
        const fcl::CollisionRequestd request(std::numeric_limits<int>::max(), true);
        fcl::CollisionResultd result;
        fcl::collide(first, second, request, result);
        for (std::size_t i = 0; i < result.numContacts(); ++i) {
            const fcl::Contactd& c = result.getContact(i);
            found.contacts.push_back({.a = index_of(*first),
                                      .b = index_of(*second),
                                      .source = index_of(*first),
                                      .vertex = no_vertex,
                                      .depth = c.penetration_depth,
                                      .normal = from_fcl(c.normal)});
        }
        return false;
    }

    std::vector<std::shared_ptr<Model>> models_;  ///< by body
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
    fcl::DynamicAABBTreeCollisionManagerd manager_;
    Found found_;
    double refit_ms_ = 0;
};

}  // namespace

std::unique_ptr<Detector> make_fcl_detector(const SceneSetup& scene) {
    return std::make_unique<FclDetector>(scene);
}

}  // namespace pierce::scenes

#else

namespace pierce::scenes {

std::unique_ptr<Detector> make_fcl_detector(const SceneSetup&) {
    throw InputError("this build has no FCL (libfcl-dev)");
}

}  // namespace pierce::scenes

#endif
