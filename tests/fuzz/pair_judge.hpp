#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fuzz/failure.hpp"
#include "fuzz/model.hpp"
#include "pierce/contact.hpp"

namespace pierce::fuzz {

/// How a contact of two solids came to its end.
enum class Ending : std::uint8_t {
    reprojected,  ///< at the closest point of the target
    touching,     ///< where it starts
    unmoved,      ///< where its inward ray leaves the target
    separation,   ///< along the direction in which the pair separates soonest
    count
};

const char* name_of(Ending ending);

/// How far contacts are from the truth. An ulp is float32's, of the pair's extent: that of the
/// larger body's mesh.
struct EndingErrors {
    std::uint64_t contacts = 0;
    std::uint64_t beyond = 0;    ///< of these, by more than the touch tolerance: eight ulp
    std::uint64_t in_plane = 0;  ///< of these, which count nowhere else, but whose ray runs in the
                                 ///< plane of one of the target's faces
    double most = 0;             ///< [ulp] of depth, of the end, and of where depth and normal lead
    double most_depth = 0;       ///< [ulp] of the depth alone
    double most_angle = 0;       ///< [rad] between the normal and the way to the closest point, of
                                 ///< vertices that are deeper than the touch tolerance

    EndingErrors& operator+=(const EndingErrors& o);
};

/// What was found out about pairs of solids. The touch tolerance of a pair is that of the larger
/// body.
struct PairCounts {
    std::uint64_t pairs = 0;
    std::uint64_t overlapping = 0;     ///< that share a point
    std::uint64_t deep = 0;            ///< of these, certainly deeper than the touch tolerance
    std::uint64_t found = 0;           ///< with a contact of some depth
    std::uint64_t without_vertex = 0;  ///< overlapping pairs with a contact of some depth, but none
                                       ///< of a vertex
    // Of pairs that overlap, but have no contact of some depth:
    std::uint64_t missed = 0;       ///< certainly deeper than the touch tolerance
    std::uint64_t missed_thin = 0;  ///< likewise, but no point is found that is deeper than that
                                    ///< in both: the overlap is a sliver
    std::uint64_t undecided = 0;    ///< perhaps: there is no proof, and no way out that is as short
    std::uint64_t missed_skin = 0;  ///< perhaps, but no deeper than sixteen touch tolerances, and
                                    ///< no edge is inside by more than one
    std::uint64_t unseen = 0;       ///< of the four above, those without any contact
    std::uint64_t shallow = 0;      ///< within the touch tolerance
    double most_allowed = 0;        ///< [ulp] how deep the deepest of the shallow and those in the
                                    ///< skin certainly is
    std::uint64_t invented = 0;     ///< with such a contact, but further apart than the touch
                                    ///< tolerance
    std::uint64_t near = 0;         ///< likewise, but apart by no more than that
    double most_apart = 0;          ///< [ulp] of these
    std::uint64_t ridges = 0;  ///< contacts of edges on the shortest way to an edge of the other
                               ///< body, exact to 8 ulp; not counted in `errors`
    std::uint64_t vertices_inside = 0;  ///< vertices deeper in the other body than the touch
                                        ///< tolerance, but for those whose ray runs in a plane
    std::uint64_t vertices_missed = 0;  ///< of these, those without a contact
    std::array<std::array<EndingErrors, static_cast<std::size_t>(Ending::count)>, 2> errors;
    ///< of vertices, and of edges

    PairCounts& operator+=(const PairCounts& o);
};

/// What of the vertices' contacts has to be exact.
enum class Exact : std::uint8_t {
    all,
    documented,  ///< all but contacts by separation and of vertices within the touch tolerance,
                 ///< which docs/step.md leaves as they are, and those whose ray runs in the plane
                 ///< of a face (docs/trust.md)
};

/// Compares the contacts of a world of two solids with what is true of them by exact predicates
/// (truth/exact_mesh.hpp); all that is against the claim.
std::vector<Failure> judge_pair(const Model& model, std::span<const Contact> contacts, Exact exact,
                                PairCounts& counts);

}  // namespace pierce::fuzz
