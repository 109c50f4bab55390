#include "scenes/simulate/soft_solid.hpp"

#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <vector>

#include "pierce/bullet/bullet_convert.hpp"
#include "scenes/named/mass_properties.hpp"

namespace pierce::scenes {
namespace {

/// How soft bodies keep their shape, in Bullet's terms.
constexpr btScalar link_stiffness = btScalar(1.0);
constexpr btScalar soft_damping = btScalar(0.01);
constexpr btScalar soft_friction = btScalar(1.0);
constexpr btScalar contact_hardness = btScalar(1.0);
constexpr int bending_distance = 2;

}  // namespace

std::unique_ptr<btSoftBody> soft_solid(btSoftBodyWorldInfo& info, const SceneBody& body,
                                       const MeshData& mesh) {
    const Frame start = frame_of(body.pose);
    std::vector<btScalar> coordinates;
    for (Vec3f p : mesh.positions) {
        const btVector3 x = bullet::to_bullet(start.to_parent(to_double(p)));
        coordinates.insert(coordinates.end(), {x.x(), x.y(), x.z()});
    }
    std::vector<int> indices;
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t.vertex) indices.push_back(static_cast<int>(v));
    // The body is not randomised, so that node and face numbers are vertex and triangle numbers.
    std::unique_ptr<btSoftBody> soft(btSoftBodyHelpers::CreateFromTriMesh(
        info, coordinates.data(), indices.data(), static_cast<int>(mesh.triangles.size()), false));
    btSoftBody& made = *soft;
    made.m_materials[0]->m_kLST = link_stiffness;
    made.generateBendingConstraints(bending_distance);
    for (const auto& [a, b] : body.struts)
        made.appendLink(static_cast<int>(a), static_cast<int>(b), made.m_materials[0]);
    made.m_cfg.piterations = body.solid_iterations;
    made.m_cfg.kDP = soft_damping;
    made.m_cfg.kDF = soft_friction;
    made.m_cfg.kMT = static_cast<btScalar>(body.shape_matching);
    made.m_cfg.kKHR = made.m_cfg.kCHR = made.m_cfg.kSHR = contact_hardness;
    made.m_cfg.collisions = 0;  // Bullet's own soft collisions stay off; the contacts are Pierce's
    made.setTotalMass(static_cast<btScalar>(mass_properties(mesh).mass));
    made.setPose(false, true);
    return soft;
}

}  // namespace pierce::scenes
