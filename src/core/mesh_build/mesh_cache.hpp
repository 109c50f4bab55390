#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/mesh/mesh_view.hpp"

namespace pierce {

template <class T>
using MeshVector = std::vector<T>;

/// What was measured of meshes, in files of a folder. A file's name is a hash of the surface that
/// was measured.
///
/// A file that is damaged, cut short, of another version or of another mesh is left aside. Whatever
/// a file holds, no index in it leads out of an array. Whoever can write into the folder can make
/// contacts go missing, though: what a file says of distances is believed.
class MeshCache {
public:
    /// Makes the folder if there is none. Throws InputError if that fails.
    explicit MeshCache(std::filesystem::path folder);

    /// Fills arrays of a mesh from its file and says which.
    MeshNeeds load(const MeshView& mesh, MeshArrays<MeshVector>& arrays, MeshShape& shape) const;
    /// Writes the file of a mesh. The cache stays without it if the file cannot be written.
    void store(const MeshView& mesh, const MeshNeeds& made) const;

    /// The file of a mesh.
    std::filesystem::path file_of(const MeshView& mesh) const;

private:
    std::filesystem::path folder_;
};

}  // namespace pierce
