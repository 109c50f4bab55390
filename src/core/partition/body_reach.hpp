#pragma once

#include "core/body/body_view.hpp"
#include "core/body/placed_box.hpp"
#include "pierce/box.hpp"
#include "pierce/settings.hpp"

namespace pierce {

/// Where a body is whose place the host knows.
PlacedBox placed_box(const BodyView& body);

/// [length] How much further than around its points a body may have to do with others in a step,
/// but for tolerances and the way that it moves.
double reach_beyond_box(const BodyView& body, const Settings& settings);

/// A box in the world that holds all that a body may have to do with in a step: no body whose box
/// is apart from it is a pair with this one. It is found without a step; empty for a body that is
/// nowhere. `more`: what reach_beyond_box() has found.
Box box_of_reach(const PlacedBox& place, double more);

}  // namespace pierce
