#pragma once

#include <string>
#include <vector>

#include "app/measure/motion.hpp"
#include "app/reports/paper/curves.hpp"

namespace pierce::app {

/// What a method or the truth sees of a motion, in every frame whose truth is known.
struct Sight {
    std::string name;
    Line line;                       ///< its look in plots
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

/// Milliseconds of a step, means over the frames whose truth is known, on one thread.
struct StepTimes {
    double update = 0, narrow = 0, response = 0, total = 0;
};

/// Rays and Bullet's own method on one scene.
struct Quality {
    std::string scene;     ///< for people: "100 soft tori"
    std::string opponent;  ///< Bullet's method that can follow the scene
    std::string file;      ///< end of file names: "tori_soft"
    bool soft = false;
    std::vector<double> time;    ///< [s] of the frames whose truth is known
    std::vector<Judged> open;    ///< all on the motion that rays brought about; rays first
    std::vector<Judged> closed;  ///< each on the motion it brought about itself; rays first
    StepTimes rays, against;     ///< on the motion that rays brought about
};

/// `loop`: the motion that rays bring about, and what they find in it. With soft bodies Bullet has
/// no method that could close the loop.
Quality measure_quality(const scenes::SceneSetup& scene, bool soft, const ClosedLoop& loop,
                        Timing timing, std::uint32_t truth_every);

/// What all of them see, and each truth once.
std::vector<TimeColumn> columns_of(const std::vector<Judged>& judged,
                                   std::vector<double> Sight::*number);

}  // namespace pierce::app
