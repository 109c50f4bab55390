#pragma once

#include <cstdint>
#include <vector>

#include "pierce/box.hpp"
#include "pierce/inside.hpp"
#include "pierce/mesh.hpp"
#include "pierce/mesh_defect.hpp"

namespace pierce {

struct MeshCheckOptions {
    bool self_intersections = false;  ///< true: look for self-intersections, too; this is the one
                                      ///< check that takes longer than reading the mesh
    Inside inside = Inside::automatic;
};

/// All defects of one kind.
struct MeshFinding {
    MeshDefect kind{};
    std::uint32_t count = 0;            ///< of all defects of the kind
    std::vector<std::uint32_t> places;  ///< of the first constants::finding_places defects, in the
                                        ///< caller's numbering; element() says what a place is
};

/// What check_mesh found. All findings but the first three are about the triangles that have three
/// finite vertices.
struct MeshReport {
    std::vector<MeshFinding> findings;  ///< one per kind that was found, in the order of MeshDefect
    std::uint32_t vertices = 0;         ///< all of the mesh, like `triangles`
    std::uint32_t triangles = 0;
    std::uint32_t components = 0;  ///< of triangles connected by vertices
    MeshTraits traits;
    Box box;              ///< of all finite vertices
    bool closed = false;  ///< has triangles and is closed by its MeshTraits
    MeshInside inside;    ///< of a Mesh with the options' rule

    /// The finding of a kind, or null.
    const MeshFinding* find(MeshDefect kind) const;
    /// True if nothing was found that changes detection.
    bool sound() const;
};

/// Looks for everything in a mesh that changes what detection finds. Never throws because of the
/// mesh's content, however bad it is.
MeshReport check_mesh(const MeshData& mesh, MeshCheckOptions options = {});

}  // namespace pierce
