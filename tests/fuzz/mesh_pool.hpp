#pragma once

#include <memory>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce::fuzz {

/// Meshes that the worlds of one program share: most of the time of a small world is spent on
/// measuring its meshes.
class MeshPool {
public:
    /// The mesh made of `data`, from `before` unless that is null. Throws what Mesh's constructor
    /// throws.
    std::shared_ptr<const Mesh> made_of(const MeshData& data, Inside inside, const Mesh* before);

private:
    struct Made {
        std::shared_ptr<const Mesh> mesh;
        Inside inside;  ///< that was asked for
        const Mesh* before;
    };

    std::vector<Made> meshes_;
};

}  // namespace pierce::fuzz
