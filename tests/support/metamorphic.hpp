#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce::test {

/// A change of a scene that changes its answers in a known way: a point x becomes scale * (x with
/// its axes exchanged and turned around) + offset.
struct Change {
    std::string name;
    std::array<int, 3> axis = {0, 1, 2};  ///< coordinate k of the image is coordinate axis[k] of
                                          ///< the point ...
    Vec3d sign = {1, 1, 1};               ///< ... times sign[k]
    double scale = 1;                     ///< a power of two
    Vec3d offset;
    bool by_pose = false;  ///< bodies get the offset by their pose, in double, not by their
                           ///< vertices
    std::uint32_t shuffle_seed = 0;  ///< vertices and triangles in a random order; 0: as they are
    bool swapped = false;            ///< the second body first
    bool deforming = false;          ///< bodies deform

    Vec3d direction(Vec3d v) const;
    Vec3d point(Vec3d p) const { return scale * direction(p) + offset; }
    Vec3d direction_back(Vec3d v) const;
    Vec3d point_back(Vec3d p) const { return (1 / scale) * direction_back(p - offset); }

    /// The mesh, changed, triangles still facing outward; nothing if float32 would round a
    /// coordinate.
    std::optional<MeshData> mesh(const MeshData& mesh) const;
};

/// All 48 axis symmetries; scales 2^-20 to 2^20; translations 2^0 to 2^22 along one axis and along
/// all, by vertices and by poses; shuffles; swapped; deforming; and some of everything at once.
std::vector<Change> changes();

}  // namespace pierce::test
