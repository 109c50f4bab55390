#include "fuzz/mesh_pool.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

namespace pierce::fuzz {
namespace {

/// Bit for bit: two zeros of different sign, too, are two.
bool are_same(const Mesh& a, const MeshData& b) {
    const auto bits = [](Vec3f p) {
        return std::array{std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                          std::bit_cast<std::uint32_t>(p.z)};
    };
    return std::ranges::equal(a.positions(), b.positions, {}, bits, bits) &&
           std::ranges::equal(a.triangles(), b.triangles);
}

}  // namespace

std::shared_ptr<const Mesh> MeshPool::made_of(const MeshData& data) {
    const auto known = std::ranges::find_if(
        meshes_, [&](const auto& mesh) { return are_same(*mesh, data); });
    if (known != meshes_.end()) return *known;
    return meshes_.emplace_back(
        std::make_shared<const Mesh>("mesh " + std::to_string(meshes_.size()), data));
}

}  // namespace pierce::fuzz
