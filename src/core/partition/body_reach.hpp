#pragma once

#include "core/body/body_view.hpp"
#include "pierce/box.hpp"
#include "pierce/settings.hpp"

namespace pierce {

/// A box in the world that holds all that a body may have to do with in the next step: no body
/// whose box is apart from it is a pair with this one. It is found without a step, from the places
/// that the world has set; empty for a body that takes no part.
Box box_of_reach(const BodyView& body, const Settings& settings);

}  // namespace pierce
