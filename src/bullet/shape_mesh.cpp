#include "bullet/shape_mesh.hpp"

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>
#include <BulletCollision/CollisionShapes/btTriangleMeshShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletSoftBody/btSoftBody.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <map>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "pierce/bullet/bullet_convert.hpp"

namespace pierce::bullet {
namespace {

struct Corners {
    int part = 0, index = 0;
    std::array<Vec3f, 3> at;
};

class CollectTriangles : public btTriangleCallback {
public:
    void processTriangle(btVector3* triangle, int part, int index) override {
        triangles.push_back({part,
                             index,
                             {from_bullet_float(triangle[0]), from_bullet_float(triangle[1]),
                              from_bullet_float(triangle[2])}});
    }
    std::vector<Corners> triangles;
};

const btStridingMeshInterface* arrays_of(const btCollisionShape& shape) {
    switch (shape.getShapeType()) {
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
            return static_cast<const btTriangleMeshShape&>(shape).getMeshInterface();
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
            return static_cast<const btScaledBvhTriangleMeshShape&>(shape)
                .getChildShape()
                ->getMeshInterface();
        case GIMPACT_SHAPE_PROXYTYPE: {
            const auto& moving = static_cast<const btGImpactShapeInterface&>(shape);
            return moving.getGImpactShapeType() == CONST_GIMPACT_TRIMESH_SHAPE
                       ? static_cast<const btGImpactMeshShape&>(moving).getMeshInterface()
                       : nullptr;
        }
        default:
            return nullptr;
    }
}

std::size_t size_of(PHY_ScalarType type) {
    switch (type) {
        case PHY_DOUBLE:
            return sizeof(double);
        case PHY_SHORT:
            return sizeof(short);
        case PHY_UCHAR:
            return sizeof(unsigned char);
        default:
            return sizeof(float);
    }
}

/// Adds up things, in their order.
class Hash {
public:
    void add(std::uint64_t value) { sum_ = (sum_ ^ value) * 0x100000001b3ull; }
    /// The first bytes of a few items of an array, evenly apart.
    void add_some(const unsigned char* items, int count, int stride, std::size_t bytes) {
        constexpr int most = 8;
        const int step = (count + most - 1) / most;
        for (int i = 0; i < count; i += step)
            for (std::size_t at = 0; at < bytes; at += sizeof(std::uint32_t)) {
                std::uint32_t word = 0;
                std::memcpy(&word, items + static_cast<std::ptrdiff_t>(i) * stride + at,
                            std::min(sizeof word, bytes - at));
                add(word);
            }
    }
    std::uint64_t sum() const { return sum_; }

private:
    std::uint64_t sum_ = 0xcbf29ce484222325ull;
};

/// [length^3] Of a closed surface, or with cones to the first vertex in its holes; negative if it
/// faces inward.
double volume_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
    double volume = 0;
    const Vec3d origin = to_double(positions[0]);
    for (const Triangle& t : triangles) {
        Vec3d corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = to_double(positions[t.vertex[k]]) - origin;
        volume += dot(corner[0], cross(corner[1], corner[2])) / 6;
    }
    return volume;
}

}  // namespace

bool is_triangle_mesh(const btCollisionShape& shape) {
    switch (shape.getShapeType()) {
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
        case GIMPACT_SHAPE_PROXYTYPE:
            return true;
        default:
            return false;
    }
}

std::uint64_t mark_of(const btCollisionShape& shape) {
    Hash hash;
    const btStridingMeshInterface* arrays = arrays_of(shape);
    for (int part = 0; arrays != nullptr && part < arrays->getNumSubParts(); ++part) {
        const unsigned char *vertices = nullptr, *triangles = nullptr;
        int vertex_count = 0, vertex_stride = 0, triangle_count = 0, triangle_stride = 0;
        PHY_ScalarType vertex_type = PHY_FLOAT, index_type = PHY_INTEGER;
        arrays->getLockedReadOnlyVertexIndexBase(&vertices, vertex_count, vertex_type,
                                                 vertex_stride, &triangles, triangle_stride,
                                                 triangle_count, index_type, part);
        hash.add(std::bit_cast<std::uintptr_t>(vertices));
        hash.add(std::bit_cast<std::uintptr_t>(triangles));
        hash.add(static_cast<std::uint64_t>(vertex_count));
        hash.add(static_cast<std::uint64_t>(triangle_count));
        hash.add_some(vertices, vertex_count, vertex_stride, 3 * size_of(vertex_type));
        hash.add_some(triangles, triangle_count, triangle_stride, 3 * size_of(index_type));
        arrays->unLockReadOnlyVertexBase(part);
    }
    return hash.sum();
}

double volume_of(const Mesh& mesh) { return volume_of(mesh.positions(), mesh.triangles()); }

std::optional<MeshData> mesh_of(const btCollisionShape& shape) {
    if (!is_triangle_mesh(shape)) return {};
    CollectTriangles found;
    const btVector3 all(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
    static_cast<const btConcaveShape&>(shape).processAllTriangles(&found, -all, all);
    if (found.triangles.empty()) return {};  // a compound of GImpact's
    // Bullet's trees give triangles in their own order.
    std::ranges::sort(found.triangles, {},
                      [](const Corners& c) { return std::pair(c.part, c.index); });
    MeshData mesh;
    std::map<std::tuple<float, float, float>, std::uint32_t> vertex_at;
    for (const Corners& corners : found.triangles) {
        Triangle triangle{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f p = corners.at[k];
            const auto [place, is_new] = vertex_at.try_emplace(
                {p.x, p.y, p.z}, static_cast<std::uint32_t>(mesh.positions.size()));
            if (is_new) mesh.positions.push_back(p);
            triangle.vertex[k] = place->second;
        }
        mesh.triangles.push_back(triangle);
    }
    // Bullet does not care which way triangles face, and scaling may mirror them.
    if (volume_of(mesh.positions, mesh.triangles) < 0)
        for (Triangle& t : mesh.triangles) std::swap(t.vertex[1], t.vertex[2]);
    return mesh;
}

MeshData mesh_of(const btSoftBody& soft) {
    MeshData mesh;
    for (int i = 0; i < soft.m_nodes.size(); ++i)
        mesh.positions.push_back(from_bullet_float(soft.m_nodes[i].m_x));
    for (int i = 0; i < soft.m_faces.size(); ++i) {
        Triangle triangle{};
        for (int k = 0; k < 3; ++k)
            triangle.vertex[k] = static_cast<std::uint32_t>(soft.m_faces[i].m_n[k] -
                                                            &soft.m_nodes[0]);
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

}  // namespace pierce::bullet
