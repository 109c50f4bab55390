#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace pierce {

/// What decides whether a point is inside a mesh (docs/meshes.md).
enum class Inside : std::uint8_t {
    automatic,  ///< `closed` where the mesh is closed, `winding` where it nearly is, else `none`
    closed,     ///< the surface as it is given, if that is closed, and parts of it that overlap
                ///< are not united; otherwise there is no inside
    winding,    ///< the winding number of the surface with its holes closed
    none,       ///< nothing: the mesh is a surface without an inside
};

/// The rule's name as it stands in the enumeration.
std::string_view name(Inside inside);

/// The rule of that name.
std::optional<Inside> inside_named(std::string_view name);

/// How a mesh got its inside, and what that took.
struct MeshInside {
    Inside rule = Inside::none;           ///< never `automatic`
    std::uint32_t covered_triangles = 0;  ///< in other parts of the mesh, as a whole or partly
    // The rest is zero with `closed`. With `none` it says what `winding` would have taken, if the
    // mesh was looked at.
    std::uint32_t joined_vertices = 0;     ///< vertices at the position of an earlier one
    std::uint32_t turned_triangles = 0;    ///< they faced the other way than most around them
    std::uint32_t left_out_triangles = 0;  ///< doubled, without three vertices, or within the solid
    std::uint32_t holes = 0;               ///< that are closed
    std::uint32_t cap_triangles = 0;       ///< that close them
    double cap_share = 0;                  ///< area of the caps / area of the rest

    bool exists() const { return rule != Inside::none; }
};

/// The rule by which a mesh of the same data gets the same inside.
inline Inside rule_that_made(const MeshInside& inside) {
    const bool unites_parts = inside.rule == Inside::closed && inside.covered_triangles > 0;
    return unites_parts ? Inside::automatic : inside.rule;
}

/// What was done to give the mesh an inside, in a sentence.
std::string describe(const MeshInside& inside);

}  // namespace pierce
