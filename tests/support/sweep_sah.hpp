#pragma once

#include "core/body/body_view.hpp"
#include "pierce/body.hpp"

namespace pierce::test {

/// What bvh::sah_cost says of the tree that a full sweep finds: every node is split where the
/// surface area heuristic is least, of all places along all three axes. Slow, and as good as
/// top-down trees get.
double sweep_sah_cost(const BodyView& body);

}  // namespace pierce::test
