#pragma once

#include <BulletSoftBody/btSoftBody.h>

#include <cstdint>
#include <set>
#include <vector>

#include "pierce/mesh.hpp"
#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// Tears a soft body of Bullet's along links that are stretched too far: a node is split in two,
/// and each of them keeps the triangles on its side of the plane across the link. So every tear is
/// a change of the mesh.
class Tearing {
public:
    /// `mesh`: the rest shape, with a node per vertex and a face per triangle of the soft body,
    /// which must outlive this object.
    Tearing(btSoftBody& soft, MeshData mesh, const TearSettings& settings);

    /// Splits nodes where it must, and returns how many. To be called between steps. New nodes and
    /// vertices come after all others.
    std::uint32_t tear();

    /// The rest shape as it is torn now.
    const MeshData& mesh() const { return mesh_; }

private:
    using Triangles = std::vector<std::uint32_t>;
    using Vertices = std::set<std::uint32_t>;

    void find_triangles();
    bool is_edge(std::uint32_t a, std::uint32_t b) const;
    bool share_neighbor(std::uint32_t a, std::uint32_t b) const;
    bool hangs_together(std::uint32_t node, const Triangles& part) const;
    bool split(std::uint32_t node, btVector3 across);
    std::uint32_t add_node(std::uint32_t node, double share);
    std::uint32_t crossings() const;
    void draw_back(std::uint32_t node);
    void divide_links(std::uint32_t node, std::uint32_t other, const Vertices& nearby,
                      btVector3 across);
    Vertices around(std::uint32_t vertex) const;

    btSoftBody& soft_;
    MeshData mesh_;
    TearSettings settings_;
    std::vector<Triangles> triangles_of_;  ///< per vertex
};

}  // namespace pierce::scenes
