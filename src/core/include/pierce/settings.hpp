#pragma once

#include <cstdint>

#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"

namespace pierce {

/// How the last step's results are used.
enum class Temporal : std::uint8_t {
    off,        ///< not at all
    paper,      ///< walks start from the last step's hits while displacement is small, and vertices
                ///< without a hit wait for the next full pass
    certified,  ///< the same contacts as with `off`, but without the rays that are proved to be
                ///< needless
};

/// Which parts of a body are looked for inside other bodies.
enum class Coverage : std::uint8_t {
    vertices,  ///< its vertices (the paper): takes half to three quarters of the time of overlaps,
               ///< and misses overlaps that hold no vertex or are thinner than one ray, up to 21 %
               ///< of the pairs in piles (docs/accuracy.md)
    complete,  ///< all its edges, too: takes 1.4 to 2.5 times as long as overlaps, and adds the
               ///< places where edges alone cross in pairs that have contacts of vertices elsewhere
    overlaps,  ///< its vertices, the edges of pairs in which these show no way out, or are few
               ///< (docs/step.md), and bodies inside one another: of the piles it misses no pair
               ///< that is deeper than the touch tolerance; docs/trust.md lists the rare random
               ///< pairs that it misses
};

/// How a world detects contacts. Every field has a default that suits any scale.
struct Settings {
    /// Rays of bodies without an inside reach this far [mean edge length of the body's mesh],
    /// unless every vertex inside is in contact. Where one of two bodies is a sheet, a vertex that
    /// has gone through the other's surface is remembered up to this depth beyond the thickness.
    double open_body_range = constants::open_body_range;

    Coverage coverage = Coverage::overlaps;
    /// Every vertex inside another body is in contact with the closest point of its surface, and an
    /// edge over a ridge with that ridge. Leaving this out saves up to 3 % of the time of complete
    /// coverage; depths are then 4 to 8 % too large and normals 16 to 22 degrees off the shortest
    /// way out in the median, and vertices whose ray leaves their own body first have no contact
    /// (docs/accuracy.md). Temporal::paper keeps that last rule.
    bool reproject = true;

    /// [length] Solids that do not overlap and are nearer than this are in contact, too, with a
    /// positive distance (docs/contacts.md); Collision::margin is for single bodies. 0 costs
    /// nothing.
    double margin = 0;

    /// Remembering nothing (Temporal::off) changes no contact; with vertices alone, it takes 1.1 to
    /// 1.4 times as long over the motion of a pile, and three to five times once the pile rests.
    Temporal temporal = Temporal::certified;
    /// Temporal::certified remembers nothing for a while where that would cost more than it spares.
    bool may_rest = true;
    /// Temporal::paper looks ahead along outward rays for vertices that are about to enter.
    bool predict = true;
    /// How far predictions look [length]; negative: as far as the bodies move until the next full
    /// pass, two edges at most.
    double prediction_distance = -1.0;
    /// Temporal::paper looks at all vertices of a pair at least every so many steps.
    std::uint32_t full_every = constants::full_every;
    /// Temporal::paper walks while the displacement since the last full ray is below this [mean
    /// edge length].
    double walk_threshold = constants::walk_threshold;

    /// True if every vertex inside another body is in contact with it; otherwise its inward ray
    /// must leave the other body before its own, too (rules R2 and R3).
    PIERCE_HD bool inside_is_contact() const { return reproject && temporal != Temporal::paper; }
    /// True if a vertex is looked at from the last step's closest triangle before a ray is made.
    PIERCE_HD bool looks() const { return reproject && temporal == Temporal::certified; }
    /// True if contacts of pairs in which nothing moves are kept without another look.
    PIERCE_HD bool keeps_contacts() const { return temporal == Temporal::certified; }

    friend bool operator==(const Settings&, const Settings&) = default;
};

/// The paper's method: rays of vertices alone, and contacts that end where the rays do.
inline constexpr Settings vertex_rays{.coverage = Coverage::vertices, .reproject = false};

}  // namespace pierce
