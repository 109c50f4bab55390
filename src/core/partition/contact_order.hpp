#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "pierce/contact.hpp"

namespace pierce {

/// True for a contact of the first list of a step, which rays have found, also those of sheets that
/// look for themselves along velocities. Both lists are sorted by pair.
inline bool is_by_ray(const Contact& c, View<const BodyView> bodies) {
    return !c.of_sheet || (c.a == c.b && bodies[c.a.index].sends_velocity_rays());
}

}  // namespace pierce
