#pragma once

#include <string>
#include <vector>

#include "app/motion.hpp"
#include "app/paper_curves.hpp"

namespace pierce::app {

/// What a method or the truth sees of a motion, in every frame whose truth is known.
struct Sight {
    std::string name;
    std::vector<double> pairs;       ///< that collide
    std::vector<double> deep_pairs;  ///< of these, by some depth
    std::vector<double> depth;       ///< [length] mean over the contacts, or of the vertices truly
                                     ///< inside
    std::uint64_t missed = 0;        ///< pairs that overlap and do not collide, over all frames
    std::uint64_t added = 0;         ///< pairs that collide by some depth and do not overlap

    /// Part of the pairs there are that is not seen, and part of those seen that is not there [1].
    double missed_share(const Sight& truth) const;
    double added_share() const;
};

/// What a method sees, and the truth about the same motion.
struct Judged {
    Sight found, truth;
};

/// Rays and GJK/EPA on one scene.
struct Quality {
    std::string scene;
    std::uint32_t count = 0;     ///< falling bodies
    std::vector<double> time;    ///< [s] of the frames whose truth is known
    std::vector<Judged> open;    ///< all on the motion that rays brought about
    std::vector<Judged> closed;  ///< each on the motion it brought about itself
};

Quality measure_quality(const scenes::SceneSetup& scene, Timing timing, std::uint32_t truth_every);

/// What all of them see, and each truth once.
std::vector<TimeColumn> columns_of(const std::vector<Judged>& judged,
                                   std::vector<double> Sight::*number);

}  // namespace pierce::app
