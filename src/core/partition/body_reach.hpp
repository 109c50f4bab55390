#pragma once

#include "core/body/body_view.hpp"
#include "pierce/box.hpp"
#include "pierce/settings.hpp"

namespace pierce {

/// [length] How much further than around its points a body may have to do with others in a step,
/// but for tolerances and the way that it moves.
double reach_beyond_points(const BodyView& body, const Settings& settings);

/// What a body whose place the host knows reaches in a step (core/body/reach.hpp).
Box reach_on_host(const BodyView& body, const Settings& settings);

}  // namespace pierce
