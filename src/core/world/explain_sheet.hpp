#pragma once

#include <span>

#include "core/body/body_view.hpp"
#include "pierce/body.hpp"
#include "pierce/explain.hpp"

namespace pierce {

/// Why a vertex of `source` has, or has not, a contact with `target`, one of which is a sheet; they
/// may be the same body. `thickness` is the pair's [length]; `contacts`: those of the vertex with
/// the target in the last step.
Explanation explain_sheet(const BodyView& source, const BodyView& target, std::uint32_t vertex,
                          double thickness, std::span<const Contact> contacts);

}  // namespace pierce
