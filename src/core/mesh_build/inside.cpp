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

std::string describe(const MeshInside& inside) {
    switch (inside.rule) {
        case Inside::closed:
            return "closed: the surface as it was given decides what is inside";
        case Inside::automatic:
        case Inside::none:
            return "no inside";
        case Inside::winding:
            break;
    }
    const auto counted = [](std::uint32_t count, const char* one, const char* many) {
        return std::to_string(count) + " " + (count == 1 ? one : many);
    };
    const double per_mille = std::round(1000 * inside.cap_share);
    std::string text = "the winding number decides what is inside";
    if (inside.holes > 0)
        text += ", " + counted(inside.holes, "hole", "holes") + " closed by " +
                counted(inside.cap_triangles, "triangle", "triangles") + " (" +
                std::to_string(static_cast<int>(per_mille) / 10) + "." +
                std::to_string(static_cast<int>(per_mille) % 10) + " % of the area)";
    if (inside.turned_triangles > 0)
        text += ", " + counted(inside.turned_triangles, "triangle", "triangles") + " turned";
    if (inside.left_out_triangles > 0)
        text += ", " + counted(inside.left_out_triangles, "triangle", "triangles") + " left out";
    if (inside.joined_vertices > 0)
        text += ", " + counted(inside.joined_vertices, "vertex", "vertices") +
                " joined to an earlier one at the same position";
    return text;
}

}  // namespace pierce
