#include "fuzz/mesh_pool.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

namespace pierce::fuzz {
namespace {

/// Bit for bit: two zeros of different sign, too, are two.
bool are_same(const MeshData& a, const MeshData& b) {
    const auto bits = [](Vec3f p) {
        return std::array{std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                          std::bit_cast<std::uint32_t>(p.z)};
    };
    return std::ranges::equal(a.positions, b.positions, {}, bits, bits) &&
           std::ranges::equal(a.triangles, b.triangles);
}

}  // namespace

std::shared_ptr<const Mesh> MeshPool::made_of(const MeshData& data, Inside inside,
                                              const Mesh* before) {
    const auto known = std::ranges::find_if(meshes_, [&](const Made& made) {
        return made.inside == inside && made.before == before && are_same(made.mesh->data(), data);
    });
    if (known != meshes_.end()) return known->mesh;
    const std::string name = "mesh " + std::to_string(meshes_.size());
    const MeshOptions options{.inside = inside};
    meshes_.push_back({before != nullptr
                           ? std::make_shared<const Mesh>(name, data, *before, options)
                           : std::make_shared<const Mesh>(name, data, options),
                       inside, before});
    return meshes_.back().mesh;
}

}  // namespace pierce::fuzz
