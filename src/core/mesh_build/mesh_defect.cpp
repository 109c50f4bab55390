#include "pierce/mesh_defect.hpp"

namespace pierce {
namespace {

struct Description {
    MeshDefect defect;
    std::string_view name;
    MeshElement element;
    bool changes_detection;
    std::string_view meaning;
};

constexpr Description descriptions[mesh_defect_count] = {
    {MeshDefect::no_triangles, "no triangles", MeshElement::none, true,
     "the mesh is refused: there is nothing to hit"},
    {MeshDefect::not_finite, "vertices not finite", MeshElement::vertex, true,
     "the mesh is refused; all else is said of what is left without them"},
    {MeshDefect::bad_index, "triangles with a bad index", MeshElement::triangle, true,
     "the mesh is refused; all else is said of what is left without them"},
    {MeshDefect::border_edge, "border edges", MeshElement::edge, true,
     "the mesh is not closed: its inside, if it has one, is decided by the winding number; without "
     "one, nothing is found to penetrate it, its own rays are limited in length, and rules R2 and "
     "R3 do not apply"},
    {MeshDefect::flipped_edge, "flipped edges", MeshElement::edge, true,
     "the triangles disagree about the outside, so the mesh is not closed; unless it gets an "
     "inside "
     "by the winding number, rays leave its vertices there in a direction that means nothing"},
    {MeshDefect::non_manifold_edge, "non-manifold edges", MeshElement::edge, true,
     "walks end there, and the mesh is not closed unless as many of the triangles run through the "
     "edge one way as the other"},
    {MeshDefect::inside_out, "components inside out", MeshElement::triangle, true,
     "inside and outside are exchanged: its rays start in the wrong direction, what is in it is "
     "not found, and what is in "
     "front of it may be"},
    {MeshDefect::degenerate_triangle, "degenerate triangles", MeshElement::triangle, true,
     "they are never hit, and as their normals are rounding, rays of their vertices may lean the "
     "wrong way, which counts without re-projection"},
    {MeshDefect::duplicate_triangle, "duplicate triangles", MeshElement::triangle, true,
     "the surface lies there twice: its edges have more than two triangles, so that walks end "
     "there and the mesh mostly "
     "counts as open"},
    {MeshDefect::opposite_triangle, "opposite triangles", MeshElement::triangle, true,
     "the two bound nothing between them: what decides on the inside leaves one or both of them "
     "out"},
    {MeshDefect::bowtie_vertex, "bowtie vertices", MeshElement::vertex, true,
     "surfaces meet in one vertex that sends one ray, along the mean of their normals or, where "
     "these cancel, in any direction; without re-projection it sends none there"},
    {MeshDefect::no_inward_direction, "vertices without an inward direction", MeshElement::vertex,
     true,
     "without re-projection they are not found inside other bodies: they send no ray, or one that "
     "starts outside of their own"},
    {MeshDefect::self_intersection, "self-intersections", MeshElement::triangle_pair, true,
     "where one closed part runs through itself, a ray's first crossing may lead into the second "
     "layer or out of the first only: contacts there are missed or too shallow; parts that overlap "
     "each other count as one solid"},
    {MeshDefect::unused_vertex, "unused vertices", MeshElement::vertex, false,
     "they are no part of a body"},
    {MeshDefect::duplicate_vertex, "duplicate vertices", MeshElement::vertex, false,
     "a seam sends a ray per vertex; triangles that meet in it by position alone are not joined, "
     "and their edges count as "
     "borders"},
    {MeshDefect::out_of_range, "vertices out of range", MeshElement::vertex, true,
     "the mesh is refused: a coordinate is beyond 2^60, or the whole mesh is smaller than 2^-60"},
};

constexpr bool in_order() {
    for (std::uint32_t i = 0; i < mesh_defect_count; ++i)
        if (static_cast<std::uint32_t>(descriptions[i].defect) != i) return false;
    return true;
}
static_assert(in_order());

const Description& description(MeshDefect defect) {
    return descriptions[static_cast<std::size_t>(defect)];
}

}  // namespace

std::string_view name(MeshDefect defect) { return description(defect).name; }
MeshElement element(MeshDefect defect) { return description(defect).element; }
bool changes_detection(MeshDefect defect) { return description(defect).changes_detection; }
std::string_view meaning(MeshDefect defect) { return description(defect).meaning; }

}  // namespace pierce
