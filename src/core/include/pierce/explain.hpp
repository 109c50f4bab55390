#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "pierce/contact.hpp"

namespace pierce {

/// Why a vertex has a contact with another body, or none; the body may be the vertex's own if that
/// is a sheet.
enum class Reason : std::uint8_t {
    contact,      ///< the vertex has a contact
    excluded,     ///< one of the bodies was left out of the step: it is not finite, or its world
                  ///< is not active
    filtered,     ///< the bodies do not meet: World::set_filter() or exclude()
    both_fixed,   ///< two fixed bodies are no pair
    boxes_apart,  ///< the bodies' boxes do not overlap: `distance` is between their world boxes, or
                  ///< 0 if only the boxes in their fits are apart
    open_target,  ///< the other body has no inside
    outside_box,  ///< the vertex is `distance` outside of the other body's box
    outside_solid,   ///< the vertex is at least `distance` outside, by the other body's clearance
                     ///< grid
    no_direction,    ///< the triangles around the vertex cancel: there is no inward direction
    entry_first,     ///< the ray enters the other body, at `t`: the vertex is outside
    nothing_ahead,   ///< the ray meets the other body nowhere: the vertex is outside
    not_inside_own,  ///< R2: the ray does not start inside its own body
    own_exit_first,  ///< R3: the ray leaves its own body at `own_exit`, before the other one at `t`
    beyond_range,    ///< the ray leaves the other body at `t`, beyond its range `own_exit`: an open
                     ///< body's rays are short
    not_looked_at,  ///< Temporal::paper does not look at the vertex until the pair's next full pass
    // Reasons where one of the two is a sheet:
    not_looked_for,  ///< contacts of the sheet with itself are not found by continuous tests
    apart,  ///< they have not met in this step, and the other surface is `distance` away, more than
            ///< the thickness
    close_at_rest,  ///< the sheet's own surface is `distance` away, which is at least half of the
                    ///< distance at rest
    beside,  ///< the other surface is `distance` away, but there an edge or a corner is closest:
             ///< the vertex is over no triangle
    // Of any body:
    no_triangle_names_it,  ///< the vertex is a corner of no triangle, so it is no part of its body
    unexplained,  ///< by all that is known here the vertex is inside, but the step has no contact
};

/// A proof that a vertex stays outside, and needs no ray, until the two bodies have moved relative
/// to each other by `left`.
struct Certificate {
    enum Kind : std::uint8_t { none, patch, patch_rest, vertex };
    Kind kind = none;  ///< what was proved to be outside: the vertex's whole patch, those vertices
                       ///< of the patch that were not near, or the vertex itself
    double left = 0;   ///< [length] how far the bodies may still move
};

/// The answer to one question. Lengths in the caller's unit.
struct Explanation {
    Reason reason = Reason::contact;
    double distance = 0;                   ///< from the other body, as far as it is known
    double t = 0;                          ///< where the ray first crosses the other body's surface
    double own_exit = 0;                   ///< where the ray leaves its own body
    std::uint32_t triangle = no_triangle;  ///< of the other body, at `t`
    Certificate certificate;               ///< if the step remembers
    std::optional<Contact> contact;

    /// One or two sentences for people.
    std::string text() const;
};

}  // namespace pierce
