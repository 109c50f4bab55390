#include "pierce/inside.hpp"

#include <cmath>

namespace pierce {

std::string_view name(Inside inside) {
    switch (inside) {
        case Inside::automatic:
            return "automatic";
        case Inside::closed:
            return "closed";
        case Inside::winding:
            return "winding";
        case Inside::none:
            return "none";
    }
    return "?";
}

std::optional<Inside> inside_named(std::string_view text) {
    for (const Inside rule : {Inside::automatic, Inside::closed, Inside::winding, Inside::none})
        if (text == name(rule)) return rule;
    return std::nullopt;
}

namespace {

std::string counted(std::uint32_t count, const char* one, const char* many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// The triangles that close holes, and their share of the area in tenths of a per cent.
std::string caps_of(const MeshInside& inside) {
    const auto tenths = std::llround(1000 * inside.cap_share);
    return counted(inside.cap_triangles, "triangle", "triangles") + " (" +
           std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " % of the area)";
}

std::string covered_in(const MeshInside& inside) {
    if (inside.covered_triangles == 0) return "";
    return "; parts of the mesh overlap and count as one solid: " +
           counted(inside.covered_triangles, "triangle is", "triangles are") +
           " covered by other parts, or partly";
}

}  // namespace

std::string describe(const MeshInside& inside) {
    if (inside.rule == Inside::closed)
        return "closed: the surface as it was given decides what is inside" + covered_in(inside);
    if (inside.rule != Inside::winding)
        return inside.holes == 0 ? "no inside"
                                 : "no inside: to close " + counted(inside.holes, "hole", "holes") +
                                       " would take " + caps_of(inside);
    std::string text = "the winding number decides what is inside";
    if (inside.holes > 0)
        text += ", " + counted(inside.holes, "hole", "holes") + " closed by " + caps_of(inside);
    if (inside.turned_triangles > 0)
        text += ", " + counted(inside.turned_triangles, "triangle", "triangles") + " turned";
    if (inside.left_out_triangles > 0)
        text += ", " + counted(inside.left_out_triangles, "triangle", "triangles") + " left out";
    if (inside.joined_vertices > 0)
        text += ", " + counted(inside.joined_vertices, "vertex", "vertices") +
                " joined to an earlier one at the same position";
    return text + covered_in(inside);
}

}  // namespace pierce
