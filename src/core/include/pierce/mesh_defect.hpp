#pragma once

#include <cstdint>
#include <string_view>

namespace pierce {

/// What a mesh check looks for; docs/mesh_check.md says what to do about each.
enum class MeshDefect : std::uint8_t {
    no_triangles,         ///< nothing to hit
    not_finite,           ///< vertices with a coordinate that is NaN or infinite
    bad_index,            ///< triangles that name a vertex that does not exist
    border_edge,          ///< edges with one triangle
    flipped_edge,         ///< edges with two triangles that run through them the same way
    non_manifold_edge,    ///< edges with more than two triangles
    inside_out,           ///< closed components with negative volume that are no cavities
    degenerate_triangle,  ///< triangles without area
    duplicate_triangle,   ///< triangles with the vertices of an earlier one, facing the same way
    opposite_triangle,    ///< triangles with the vertices of an earlier one, facing the other way
    bowtie_vertex,        ///< vertices in which more than one fan of triangles meets
    no_inward_direction,  ///< vertices whose triangles' normals cancel or, if the mesh is closed,
                          ///< have no opposite that leads inside
    self_intersection,    ///< pairs of triangles that cross, or lie on each other
    unused_vertex,        ///< vertices without triangles
    duplicate_vertex,     ///< vertices at the position of an earlier one
    out_of_range,  ///< vertices too far away, or all of a mesh that is too small, for a world
};

inline constexpr std::uint32_t mesh_defect_count = 16;

/// What the places of a finding name: one id each, or two.
enum class MeshElement : std::uint8_t {
    none,           ///< there are no places
    vertex,         ///< its id
    triangle,       ///< its id
    edge,           ///< the ids of its vertices, the smaller first
    triangle_pair,  ///< their ids, the smaller first
};

/// Ids per place.
constexpr std::uint32_t ids_per_place(MeshElement element) {
    return element == MeshElement::edge || element == MeshElement::triangle_pair ? 2 : 1;
}

/// The defect's name in the plural, for example "border edges".
std::string_view name(MeshDefect defect);
/// What the places of a finding of this defect name.
MeshElement element(MeshDefect defect);
/// False if contacts are the same with it as without it.
bool changes_detection(MeshDefect defect);
/// One sentence that says what the defect means for detection.
std::string_view meaning(MeshDefect defect);

}  // namespace pierce
