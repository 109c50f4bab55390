#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/motion_bound.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/records.hpp"
#include "pierce/body.hpp"
#include "pierce/min_max.hpp"
#include "pierce/settings.hpp"

/// displacement: how far the bodies of a pair have moved relative to each other, and what
/// follows from it.
namespace pierce::stages {

/// Per directed pair (pair * 2 + side): adds this step's motion to the odometer and decides the
/// pass. Reads fits and last step's memory.
struct MeasureDisplacement {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<const std::uint32_t> links;
    View<const PairMemory> last;  ///< empty if the last step did not remember
    Settings settings;
    View<PairMemory> memory;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Pair pair = pairs[i / 2];
        const BodyView& source = bodies[pair.source(i % 2)];
        const BodyView& target = bodies[pair.target(i % 2)];
        const bool predicts = settings.predict && settings.prediction_distance < 0;
        const bool is_blind = predicts && !(source.seen && target.seen);
        bool was_blind = false;
        PairMemory m;
        m.relative = relative_frame(source.fit, target.fit);
        if (links[i / 2] != no_pair && last.size > 0) {
            const PairMemory& before = last[2 * links[i / 2] + i % 2];
            const double rounding = constants::double_rounding *
                                    (source.world_box.max_coordinate() +
                                     target.world_box.max_coordinate());
            const bool still = source.still && target.still;
            m.step = still ? 0.0
                           : largest_motion(before.relative, m.relative, source.fit_box) +
                                 source.shape_motion + target.shape_motion + rounding;
            m.odometer = before.odometer + m.step;
            m.at_full = before.at_full;
            was_blind = before.at_full < 0;
            m.since_full = before.since_full + 1;
            // float32 records can tell odometers apart only up to a limit; all records have expired
            // before it.
            m.known = m.odometer < min_of(source.fit_box.extent(), target.fit_box.extent());
        }
        if (!m.known) {
            m.odometer = m.at_full = 0;
            // So pairs that begin in the same step do not make all their full passes in the same
            // steps.
            m.since_full = (pair.a + pair.b) % settings.full_every;
        }
        const double edge = min_of(source.mesh.mean_edge_length, target.mesh.mean_edge_length);
        const bool rigid = source.motion != Motion::deforming && target.motion != Motion::deforming;
        const bool far = rigid && m.odometer - m.at_full > settings.walk_threshold * edge;
        if (m.known && !far && !was_blind && m.since_full < settings.full_every) {
            m.pass = Pass::walk;
        } else {
            m.pass = Pass::full;
            m.at_full = is_blind ? -1.0 : m.odometer;
            if (m.known && !was_blind) m.since_full = 0;
        }
        memory[i] = m;
    }
};

}  // namespace pierce::stages
