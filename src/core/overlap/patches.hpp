#pragma once

#include <array>
#include <vector>

#include "core/overlap/face_parts.hpp"
#include "pierce/overlap.hpp"

namespace pierce {

/// Groups places of the parts of two surfaces inside each other by the way out, which is that to
/// the closest point of the other surface. A place joins the first group whose deepest place has a
/// normal with at least `same_direction` as cosine. Places are from the middle
/// of the grid, also the patches'.
std::vector<ContactPatch> find_patches(const Grid& grid, const std::array<GridSurface, 2>& surfaces,
                                       const FaceParts& parts, double same_direction);

}  // namespace pierce
