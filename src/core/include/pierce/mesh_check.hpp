#pragma once

#include <cstdint>
#include <vector>

#include "pierce/box.hpp"
#include "pierce/mesh.hpp"
#include "pierce/mesh_defect.hpp"

namespace pierce {

struct MeshCheckOptions {
    bool self_intersections = false;  ///< look for them, too: the one question that takes longer
                                      ///< than reading the mesh
};

/// All defects of one kind.
struct MeshFinding {
    MeshDefect kind{};
    std::uint32_t count = 0;            ///< of all of them
    std::vector<std::uint32_t> places;  ///< of the first constants::finding_places, see element();
                                        ///< in the caller's numbering
};

/// What check_mesh found. Everything but the first three findings is said of the triangles that
/// have three finite vertices.
struct MeshReport {
    std::vector<MeshFinding> findings;  ///< one per kind that there is, in the order of MeshDefect
    std::uint32_t vertices = 0;         ///< all there are, as `triangles`
    std::uint32_t triangles = 0;
    std::uint32_t components = 0;  ///< of triangles connected by vertices
    MeshTraits traits;
    Box box;              ///< of all finite vertices
    bool closed = false;  ///< has triangles and, by traits, an inside

    /// The finding of a kind, or null.
    const MeshFinding* find(MeshDefect kind) const;
    /// True if nothing was found that changes detection.
    bool sound() const;
};

/// Looks for everything in a mesh that changes what detection finds. Throws for no content, however
/// bad.
MeshReport check_mesh(const MeshData& mesh, MeshCheckOptions options = {});

}  // namespace pierce
