#pragma once

#include <cstdint>

#include "app/output/frame_log.hpp"
#include "scenes/named/scene.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::app {

/// For how long, and how finely, a scene is simulated.
struct Timing {
    double seconds = 12;
    double dt = 1.0 / 60;

    /// One at least.
    std::uint32_t steps() const;
};

/// The closed loop: a motion that a method's own contacts brought about, and what the method found
/// in it.
struct ClosedLoop {
    scenes::Recording recording;
    FrameLog log;
};

/// `threads`: of rays; 0: all there are.
ClosedLoop simulate(const scenes::SceneSetup& scene, scenes::Method method, const Settings& rays,
                    Timing timing, int threads = 0);

/// The open loop: what a method finds along a motion of the same scene, wherever that came from.
FrameLog watch(const scenes::SceneSetup& scene, const scenes::Recording& recording,
               scenes::Method method, const Settings& rays, int threads = 0);

}  // namespace pierce::app
