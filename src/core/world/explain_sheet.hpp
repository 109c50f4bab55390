#pragma once

#include <span>

#include "core/body/body_view.hpp"
#include "pierce/body.hpp"
#include "pierce/explain.hpp"

namespace pierce {

/// Says why a vertex of `source` has a contact with `target`, or none. One of the two bodies is a
/// sheet; they may be the same body. `thickness`: of the pair [length]; `contacts`: of the vertex
/// with the target in the last step.
Explanation explain_sheet(const BodyView& source, const BodyView& target, std::uint32_t vertex,
                          double thickness, std::span<const Contact> contacts);

}  // namespace pierce
