#pragma once

#include <cstdint>
#include <vector>

#include "pierce/stage.hpp"

namespace pierce {

/// What a step could not do in full; 0 if it did everything.
enum StepStatus : std::uint32_t {
    step_ok = 0,
    body_excluded = 1u << 0,  ///< a body's pose or positions were not finite or too far away: it
                              ///< had no contacts
};

/// How long a stage took.
struct StageTime {
    StageId stage;
    double milliseconds;
};

/// Adds to the time of a stage, in a list in the order of stages.
void add_time(std::vector<StageTime>& times, StageId stage, double milliseconds);

/// How long one step took and what it found.
struct StepStats {
    std::vector<StageTime> stages;  ///< the stages that ran, in their order; empty for a step that
                                    ///< a GPU repeats as a whole, and for one at rest
    double milliseconds = 0;        ///< the whole step
    std::vector<double> part_milliseconds;  ///< of each part's own step, in the order of
                                            ///< Plan::parts
    double device_milliseconds = 0;  ///< of `milliseconds`, the part of a step that a GPU repeats
                                     ///< as a whole
    bool at_rest = false;            ///< nothing had changed: counts are those of the last step
    std::uint32_t status = step_ok;
    std::uint32_t excluded_bodies = 0;
    std::uint32_t pairs = 0;      ///< bodies whose boxes overlap
    std::uint32_t rays = 0;       ///< full rays
    std::uint32_t hits = 0;       ///< full rays, walks and looks that meet the other body, and
                                  ///< those taken over of pairs in which nothing has moved
    std::uint32_t certified = 0;  ///< vertices near a target that needed no ray: they are proved to
                                  ///< be outside, have no inward direction, or nothing has moved in
                                  ///< their pair
    std::uint32_t looks = 0;      ///< vertices found inside by a look from their last triangle
    std::uint32_t walks = 0;      ///< walks from the last triangle of a vertex
    std::uint32_t walk_steps = 0;   ///< from triangle to triangle, over all walks
    std::uint32_t lost_walks = 0;   ///< walks that found nothing and became full rays
    std::uint32_t full_passes = 0;  ///< pairs of which all vertices of one body, or of both, were
                                    ///< looked at
    std::uint32_t predictions = 0;  ///< vertices outside with a triangle they may enter through
    std::uint32_t predictions_true = 0;  ///< contacts found through such a triangle
    std::uint32_t proofs = 0;            ///< vertices newly proved to be outside
    std::uint32_t rested = 0;            ///< 1 if Temporal::certified ran as Temporal::off, because
                                         ///< remembering would not have paid
    std::uint32_t edges = 0;             ///< edges near the other body of a pair
    std::uint32_t chords = 0;            ///< parts of edges inside the other body; those at an end
                                         ///< only of pairs that have no contact with a depth
    std::uint32_t edge_contacts = 0;     ///< contacts from chords
    std::uint32_t inside_tests = 0;      ///< rays that looked for parts of a body inside another
    std::uint32_t separated_pairs = 0;   ///< pairs that overlap without a contact along an inward
                                         ///< ray
    std::uint32_t reprojected = 0;       ///< contacts moved to a closer point
    std::uint32_t self_contacts = 0;     ///< contacts of bodies with themselves
    std::uint32_t triangle_pairs = 0;    ///< pairs of a sheet's triangle and another triangle that
                                         ///< may meet or come close during the step
    std::uint32_t feature_pairs = 0;  ///< pairs of a vertex and a triangle, or of two edges, that
                                      ///< were tested among those
    std::uint32_t crossings = 0;      ///< contacts of sheets whose two features met during the step
    std::uint32_t remembered = 0;  ///< contacts of sheets on the wrong side since an earlier step
    std::uint32_t tangled = 0;     ///< contacts of sheets whose side is unknown
    std::uint32_t own_rays = 0;    ///< rays that looked for the own exit
    std::uint32_t contacts = 0;
    std::uint32_t touching_pairs = 0;  ///< pairs with a contact
    std::uint32_t refits = 0, rebuilds = 0;
    std::uint64_t triangle_tests = 0;  ///< of rays, as far as a backend counts them: own trees
                                       ///< count those with deforming bodies
    double penetration_mean = 0, penetration_max = 0;  ///< [length] over the contacts
};

}  // namespace pierce
