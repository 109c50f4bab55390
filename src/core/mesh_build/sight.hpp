#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh_build/box_tree.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Tells what of a surface can be seen from far away.
class Sight {
public:
    /// The arrays must outlive it. Takes n log n.
    Sight(std::span<const Vec3f> positions, std::span<const Triangle> triangles);

    /// Of constants::sight_lines lines in all directions, those that lead out.
    struct Lines {
        std::uint32_t front = 0, back = 0;

        bool any() const { return front + back > 0; }
    };
    /// From the middle of a triangle.
    Lines from(std::uint32_t triangle) const;

private:
    bool is_free(Vec3d from, Vec3d way, std::uint32_t own) const;

    std::span<const Vec3f> positions_;
    std::span<const Triangle> triangles_;
    BoxTree tree_;
    std::vector<Vec3d> directions_;
};

}  // namespace pierce
