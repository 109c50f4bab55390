#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "pierce/contact.hpp"

namespace pierce {

/// Why a vertex has, or has not, a contact with another body, or with its own if that is a sheet.
enum class Reason : std::uint8_t {
    contact,      ///< it has
    excluded,     ///< one of the bodies was left out of the step: it is not finite
    both_fixed,   ///< two fixed bodies are no pair
    boxes_apart,  ///< the bodies' boxes do not overlap: `distance` is between their world boxes, or
                  ///< 0 if the turned ones part them
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
    not_looked_at,   ///< Temporal::paper leaves the vertex alone until the pair's next full pass
    // Where one of the two is a sheet:
    not_looked_for,  ///< the sheet is not looked for in itself by continuous tests
    apart,  ///< they have not met in this step, and the other surface is `distance` away: not
            ///< within the thickness
    close_at_rest,  ///< the sheet's own surface is `distance` away, but no less than half of what
                    ///< it is at rest
    beside,  ///< the other surface is `distance` away, but the vertex is over no triangle: an edge
             ///< or a corner is close
};

/// A proof that the vertex stays outside, and needs no ray, until the two bodies have moved on,
/// relative to each other.
struct Certificate {
    enum Kind : std::uint8_t { none, patch, patch_rest, vertex };
    Kind kind = none;  ///< of the vertex's whole patch, of those of the patch that were not near,
                       ///< or of the vertex itself
    double left = 0;   ///< [length] by how much they may still move
};

/// The answer to one question. Lengths in the caller's unit.
struct Explanation {
    Reason reason = Reason::contact;
    double distance = 0;                   ///< from the other body, as far as it is known
    double t = 0;                          ///< where the ray first crosses the other body's surface
    double own_exit = 0;                   ///< where the ray leaves its own body
    std::uint32_t triangle = no_triangle;  ///< the other body's, there
    Certificate certificate;               ///< if the step remembers
    std::optional<Contact> contact;

    /// One or two sentences for people.
    std::string text() const;
};

}  // namespace pierce
