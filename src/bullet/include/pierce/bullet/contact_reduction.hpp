#pragma once

#include <vector>

#include "pierce/bullet/contact_frame.hpp"

namespace pierce::bullet {

/// How many contacts of a pair reach the solver.
struct ReductionSettings {
    double same_direction = 0.95;    ///< cosine above which two normals belong to one cluster
    std::uint32_t max_clusters = 6;  ///< clusters kept: the deepest ones
    std::uint32_t points = 4;  ///< contacts kept per cluster: the deepest, then those furthest from
                               ///< the ones already taken
};

/// Picks a few contacts that hold bodies as well as all of them. They are grouped by normal, and
/// each group keeps its deepest contact and the outermost others. Deterministic; the result keeps
/// the order of `contacts`.
std::vector<FramedContact> reduce(const std::vector<FramedContact>& contacts,
                                  const ReductionSettings& settings = {});

}  // namespace pierce::bullet
