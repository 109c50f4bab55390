#include "pierce/bullet/baseline_shapes.hpp"

#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/error.hpp"

namespace pierce::bullet {
namespace {

// GImpact needs a margin; this is the default margin of its parts.
constexpr btScalar gimpact_margin = btScalar(0.01);

std::unique_ptr<btCollisionShape> hull_of(std::span<const Vec3f> points,
                                          std::optional<double> margin) {
    auto hull = std::make_unique<btConvexHullShape>();
    if (margin) hull->setMargin(static_cast<btScalar>(*margin));
    for (Vec3f p : points) hull->addPoint(to_bullet(p), false);
    hull->recalcLocalAabb();
    return hull;
}

}  // namespace

/// Bullet reads triangle meshes in place.
struct BaselineShape::Triangles {
    std::vector<btVector3> positions;
    std::vector<int> indices;
    std::unique_ptr<btTriangleIndexVertexArray> array;
};

BaselineShape::BaselineShape(Baseline method, const std::string& name, const MeshData& mesh,
                             std::span<const std::vector<Vec3f>> convex_pieces,
                             std::optional<double> margin) {
    switch (method) {
        case Baseline::gjk_hull:
            shape_ = hull_of(mesh.positions, margin);
            margin_ = shape_->getMargin();
            break;
        case Baseline::gjk_epa: {
            if (convex_pieces.empty())
                throw InputError("mesh '" + name + "' has no convex pieces for gjk-epa");
            auto compound = std::make_unique<btCompoundShape>(
                true, static_cast<int>(convex_pieces.size()));
            for (const std::vector<Vec3f>& piece : convex_pieces) {
                parts_.push_back(hull_of(piece, margin));
                compound->addChildShape(btTransform::getIdentity(), parts_.back().get());
            }
            margin_ = parts_.front()->getMargin();
            shape_ = std::move(compound);
            break;
        }
        case Baseline::gimpact: {
            triangles_ = std::make_unique<Triangles>();
            for (Vec3f p : mesh.positions) triangles_->positions.push_back(to_bullet(p));
            for (const Triangle& t : mesh.triangles)
                for (std::uint32_t v : t.vertex) triangles_->indices.push_back(static_cast<int>(v));
            triangles_->array = std::make_unique<btTriangleIndexVertexArray>(
                static_cast<int>(mesh.triangles.size()), triangles_->indices.data(),
                static_cast<int>(3 * sizeof(int)), static_cast<int>(mesh.positions.size()),
                &triangles_->positions[0][0], static_cast<int>(sizeof(btVector3)));
            auto gimpact = std::make_unique<btGImpactMeshShape>(triangles_->array.get());
            gimpact->setMargin(gimpact_margin);
            gimpact->updateBound();
            margin_ = gimpact_margin;
            shape_ = std::move(gimpact);
            break;
        }
    }
}

BaselineShape BaselineShape::ground(const MeshData& mesh) {
    BaselineShape made;
    const auto top = std::ranges::max(mesh.positions, {}, &Vec3f::z).z;
    made.shape_ = std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), top);
    return made;
}

BaselineShape::BaselineShape() = default;
BaselineShape::~BaselineShape() = default;
BaselineShape::BaselineShape(BaselineShape&&) noexcept = default;

void BaselineShape::set_positions(std::span<const Vec3f> positions) {
    if (triangles_ == nullptr) throw InputError("only a gimpact shape can take new positions");
    std::ranges::transform(positions, triangles_->positions.begin(),
                           [](Vec3f p) { return to_bullet(p); });
    auto& gimpact = static_cast<btGImpactMeshShape&>(*shape_);
    gimpact.postUpdate();
    gimpact.updateBound();
}

namespace {

/// EPA that measures its time.
class TimedEpa : public btGjkEpaPenetrationDepthSolver {
public:
    bool calcPenDepth(btSimplexSolverInterface& simplex, const btConvexShape* a,
                      const btConvexShape* b, const btTransform& transform_a,
                      const btTransform& transform_b, btVector3& v, btVector3& on_a,
                      btVector3& on_b, btIDebugDraw* draw) override {
        const auto begin = std::chrono::steady_clock::now();
        const bool found = btGjkEpaPenetrationDepthSolver::calcPenDepth(
            simplex, a, b, transform_a, transform_b, v, on_a, on_b, draw);
        milliseconds += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                                  begin)
                            .count();
        return found;
    }

    double milliseconds = 0;
};

}  // namespace

struct TimedConfiguration::Clock {
    TimedEpa epa;
};

TimedConfiguration::TimedConfiguration() : clock_(std::make_unique<Clock>()) {
    static_cast<btConvexConvexAlgorithm::CreateFunc*>(m_convexConvexCreateFunc)
        ->m_pdSolver = &clock_->epa;
}

TimedConfiguration::~TimedConfiguration() = default;

double TimedConfiguration::take_epa_milliseconds() {
    return std::exchange(clock_->epa.milliseconds, 0.0);
}

}  // namespace pierce::bullet
