#include "scenes/detect/soft_sheet.hpp"

#include <BulletSoftBody/btSoftBodyInternals.h>

#include <algorithm>
#include <map>
#include <random>
#include <utility>

#include "pierce/bullet/bullet_convert.hpp"

namespace pierce::scenes {
namespace {

/// Nodes of one of Bullet's clusters: fewer find more and cost more.
constexpr int nodes_per_cluster = 4;
constexpr btScalar steps_per_second = 60;

struct SheetLinks {
    std::vector<std::pair<int, int>> along;   ///< edges
    std::vector<std::pair<int, int>> across;  ///< the corners opposite an edge
};

/// Bullet's own helpers need memory for the square of the vertex count.
SheetLinks links_of(const MeshData& mesh) {
    SheetLinks links;
    std::map<std::pair<int, int>, int> opposite;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const auto a = static_cast<int>(t.vertex[k]),
                       b = static_cast<int>(t.vertex[(k + 1) % 3]);
            const auto corner = static_cast<int>(t.vertex[(k + 2) % 3]);
            const auto [edge, is_new] = opposite.try_emplace(std::minmax(a, b), corner);
            if (is_new)
                links.along.push_back(edge->first);
            else
                links.across.emplace_back(edge->second, corner);
        }
    // Bullet solves links one after another. In the order of a grid, corrections would all run one
    // way.
    std::mt19937 random(1);
    for (auto* list : {&links.along, &links.across})
        for (std::size_t i = list->size(); i > 1; --i)
            std::swap((*list)[i - 1], (*list)[random() % i]);
    return links;
}

}  // namespace

SoftSheet::SoftSheet(btSoftBodyWorldInfo& info, const SceneBody& body, const MeshData& mesh)
    : thickness_(body.collision.thickness) {
    const Frame frame = frame_of(body.pose);
    std::vector<btVector3> nodes;
    std::vector<Vec3d> start;
    for (Vec3f p : mesh.positions) {
        start.push_back(to_double(to_float(frame.to_parent(to_double(p)))));
        nodes.push_back(bullet::to_bullet(start.back()));
    }
    const SheetMaterial& material = body.material;
    std::vector<double> node_mass(nodes.size(), 0);
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = start[t.vertex[0]], b = start[t.vertex[1]], c = start[t.vertex[2]];
        const double share = material.area_density * 0.5 * length(cross(b - a, c - a)) / 3;
        for (std::uint32_t v : t.vertex) node_mass[v] += share;
        mass_ += 3 * share;
    }
    std::vector<btScalar> masses(node_mass.begin(), node_mass.end());
    soft_ = std::make_unique<btSoftBody>(&info, static_cast<int>(nodes.size()), nodes.data(),
                                         masses.data());
    btSoftBody::Material* stretch = soft_->m_materials[0];
    stretch->m_kLST = static_cast<btScalar>(material.stretch);
    btSoftBody::Material* bend = soft_->appendMaterial();
    bend->m_kLST = static_cast<btScalar>(material.bend);
    const SheetLinks links = links_of(mesh);
    for (const auto& [a, b] : links.across) soft_->appendLink(a, b, bend);
    for (const auto& [a, b] : links.along) soft_->appendLink(a, b, stretch);
    for (const Triangle& t : mesh.triangles)
        soft_->appendFace(static_cast<int>(t.vertex[0]), static_cast<int>(t.vertex[1]),
                          static_cast<int>(t.vertex[2]), stretch);
    soft_->m_cfg.piterations = material.iterations;
    soft_->m_cfg.kDP = static_cast<btScalar>(material.damping);
    soft_->m_cfg.collisions = 0;
}

void SoftSheet::collide_by_bullet() {
    soft_->generateClusters(soft_->m_nodes.size() / nodes_per_cluster);
    soft_->m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    // Bullet's own margin is a quarter of a metre, whatever the size of the body.
    soft_->getCollisionShape()->setMargin(static_cast<btScalar>(thickness_));
}

// With CL_SS and CL_SELF, Bullet 3.24 finds no contact: it masks its flags with both bits, and
// compares the result with a case that has one bit. This function does what that case does.
void SoftSheet::meet_itself() {
    btSoftColliders::CollideCL_SS clusters;
    clusters.ProcessSoftSoft(soft_.get(), soft_.get());
}

std::uint32_t SoftSheet::meetings_at(std::span<const Vec3f> positions) {
    // This prepares what Bullet's step would prepare, as there is no step here.
    btSoftBody::SolverState& step = soft_->m_sst;
    step.sdt = btScalar(1) / steps_per_second;
    step.isdt = steps_per_second;
    step.radmrg = soft_->getCollisionShape()->getMargin();
    step.updmrg = step.radmrg * btScalar(0.25);
    for (int i = 0; i < soft_->m_nodes.size(); ++i) {
        btSoftBody::Node& node = soft_->m_nodes[i];
        node.m_q = node.m_x;
        node.m_x = bullet::to_bullet(positions[static_cast<std::size_t>(i)]);
        node.m_v = step.isdt * (node.m_x - node.m_q);
    }
    soft_->updateClusters();
    meet_itself();
    const int found = soft_->m_joints.size();
    for (int i = 0; i < found; ++i) btAlignedFree(soft_->m_joints[i]);
    soft_->m_joints.clear();
    return static_cast<std::uint32_t>(found);
}

}  // namespace pierce::scenes
