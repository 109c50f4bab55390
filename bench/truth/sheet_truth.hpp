#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh_view.hpp"
#include "scenes/named/pair_rules.hpp"
#include "scenes/recording/recording.hpp"
#include "truth/meeting.hpp"

namespace pierce::truth {

/// Two features that share a point at some time of a step. Bodies by their index in the recording,
/// edges by that in the mesh.
struct SheetMeeting {
    Features features = Features::vertex_and_face;
    std::uint32_t a = 0, item = 0;   ///< a vertex of body a, or an edge of it
    std::uint32_t b = 0, other = 0;  ///< a triangle of body b, or an edge of it: then a < b, or a =
                                     ///< b and item < other

    friend auto operator<=>(const SheetMeeting&, const SheetMeeting&) = default;
};

/// An edge that runs through a triangle, from one side to the other; touching is not piercing.
struct Piercing {
    std::uint32_t a = 0, edge = 0;
    std::uint32_t b = 0, triangle = 0;
    double depth = 0;  ///< [length] the shortest way out: of the edge's two ends, the smaller
                       ///< distance to the triangle's plane
};

/// The truth about the sheets of a recording. Every sheet is looked at with all other bodies, and
/// with itself if it is to be looked for in itself; features of one body that share a vertex are
/// left out. A body that is not finite in a frame is left out of that frame, and of the steps to
/// and from it.
class SheetTruth {
public:
    /// The recording must stay.
    explicit SheetTruth(const scenes::Recording& recording);

    /// What meets in the step from frame - 1 to `frame`, during which all points move in straight
    /// lines; nothing for frame 0. Sorted.
    std::vector<SheetMeeting> meetings(std::uint32_t frame, MeetingCounts* counts = nullptr) const;
    /// Edges through triangles in a frame, sorted as they are declared.
    std::vector<Piercing> piercings(std::uint32_t frame) const;

private:
    struct Placed;

    bool are_looked_at(std::uint32_t a, std::uint32_t b) const;
    std::vector<Placed> placed(std::uint32_t from, std::uint32_t to) const;

    const scenes::Recording& recording_;
    scenes::PairRules rules_;
    std::vector<Mesh> meshes_;
    std::vector<MeshView> views_;                   ///< of these
    std::vector<std::vector<std::uint32_t>> used_;  ///< per mesh, vertices of triangles
};

}  // namespace pierce::truth
