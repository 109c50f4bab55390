#pragma once

#include <cstdint>

#include "pierce/host_device.hpp"
#include "pierce/ids.hpp"
#include "pierce/min_max.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// How a contact was found.
enum class Found : std::uint8_t {
    full,        ///< by a ray through the target's tree
    walk,        ///< by a walk from the last step's triangle
    prediction,  ///< by a walk to a triangle that the vertex was predicted to enter through
    self,        ///< by a ray from a vertex that is inside its own body
    near,        ///< of a solid: outside, and closer than the margin, or an edge that has passed
                 ///< another one by a few times the depth of the pair; of a sheet: closer than its
                 ///< thickness, and not known to have met
    crossing,    ///< of a sheet: the two meet during the step
    remembered,  ///< of a sheet: the two met in an earlier step and are still on the wrong side of
                 ///< each other
    tangled,  ///< of a sheet: an edge runs through a triangle, and the step in which that began is
              ///< unknown
    separation,  ///< measured along the direction in which the two separate soonest, as one is
                 ///< inside the other as a whole, or the pair has no other contact with a depth
};

/// Which of a contact's two bodies the ray started from.
enum class Side : std::uint8_t { a = 0, b = 1 };

/// A point of one body inside another, and the point where its inward ray leaves that other body.
/// The first point is a vertex, or the middle of the part of an edge that is inside. A contact of a
/// sheet is a vertex and a triangle, or two edges, that are close to each other or have met during
/// the step. A body in contact with itself is both a and b. Lengths are in the caller's unit, and
/// everything is in world space.
struct alignas(16) Contact {
    BodyId a, b;            ///< a <= b by index; equal: a body in contact with itself
    Side source = Side::a;  ///< the body the vertex belongs to; the other one is the target
    bool grazing = false;   ///< the ray meets the triangle so flatly that the depth is uncertain
    Found found = Found::full;
    bool reprojected = false;  ///< the contact ends at the closest point of the target's surface,
                               ///< or of an edge at the closest point of the ridge over it, not at
                               ///< the end of the inward ray
    bool of_sheet = false;  ///< between surfaces that keep their thickness, whatever is inside or
                            ///< outside
    bool unknown_side = false;  ///< of a sheet: the way out is unknown, so the normal says nothing
                                ///< about it
    std::uint16_t padding_a = 0;  // explicit, as a GPU writes a contact in whole words
    std::uint32_t vertex = 0;  ///< of the source; if an edge is in contact, the edge's first vertex
    std::uint32_t edge_end = no_vertex;  ///< second vertex of the source's edge; no_vertex if a
                                         ///< vertex is in contact
    std::uint32_t edge = 0;              ///< of the source's mesh, if an edge is in contact
    std::uint32_t chord = 0;  ///< which of the edge's parts inside the target, counted from its
                              ///< first vertex
    std::uint32_t other_edge = 0;  ///< of the target's mesh, if two edges are near or those of
                                   ///< sheets
    std::uint32_t triangle = 0;    ///< of the target
    std::uint32_t age = 0;  ///< steps in a row this vertex or edge has been in contact with this
                            ///< body or, between surfaces, this triangle or edge; 0: new
    std::uint32_t padding_b = 0;
    double along = 0;  ///< where on the edge: 0 at its first vertex, 1 at its second
    double time = 1;   ///< when in the step the two of a sheet's contact first meet [0: the step's
                       ///< begin]; 1 if they do not meet
    double distance = 0;  ///< signed, negative where the bodies overlap or a sheet is crossed, zero
                          ///< where they touch, positive where they are only near
    double barycentric[3] = {};  ///< of the target point in the triangle; sums to 1
    Vec3d point_a, point_b;      ///< on body a and on body b: the vertex and the target point
    Vec3d normal;  ///< unit, from a to b: the line of the ray, so (point_b - point_a) . normal =
                   ///< distance
    Vec3d face_normal;  ///< unit, outward, of the target triangle
    double padding_c = 0;

    PIERCE_HD double penetration_depth() const { return max_of(-distance, 0.0); }

    /// The body that the vertex or edge is of, and the one that the triangle is of.
    PIERCE_HD BodyId source_body() const { return source == Side::a ? a : b; }
    PIERCE_HD BodyId target_body() const { return source == Side::a ? b : a; }
    /// The point on the source, and the point on the target.
    PIERCE_HD Vec3d source_point() const { return source == Side::a ? point_a : point_b; }
    PIERCE_HD Vec3d target_point() const { return source == Side::a ? point_b : point_a; }

    PIERCE_HD bool is_edge() const { return edge_end != no_vertex; }
    /// The weight of the source's vertices in the source point: of `vertex` (k = 0) and `edge_end`
    /// (k = 1).
    PIERCE_HD double source_weight(int k) const { return k == 0 ? 1 - along : along; }

    /// A number that names the contact within its pair. It is the same in every step for the same
    /// vertex, or the same part of an edge; for a sheet's contact, for the same two features.
    PIERCE_HD std::uint64_t feature() const {
        const std::uint64_t kind = std::uint64_t{of_sheet} << 2 | std::uint64_t{is_edge()} << 1 |
                                   static_cast<std::uint64_t>(source);
        const std::uint64_t item = is_edge() ? edge : vertex;
        const bool near_edges = !of_sheet && is_edge() && found == Found::near;
        const std::uint64_t other = found == Found::tangled ? triangle
                                    : of_sheet              ? (is_edge() ? other_edge : triangle)
                                    : near_edges            ? other_edge
                                                            : chord;
        const bool apart = found == Found::tangled || near_edges;
        return item << 34 | other << 4 | std::uint64_t{apart} << 3 | kind;
    }
};

}  // namespace pierce
