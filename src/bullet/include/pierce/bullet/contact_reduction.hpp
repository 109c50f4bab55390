#pragma once

#include <vector>

#include "pierce/bullet/contact_frame.hpp"

namespace pierce::bullet {

/// How many contacts of a pair reach the solver.
struct ReductionSettings {
    double same_direction = 0.95;    ///< cosine above which two normals belong to one cluster
    std::uint32_t max_clusters = 6;  ///< the deepest ones are kept
    std::uint32_t points = 4;  ///< per cluster: the deepest, then those furthest from the ones
                               ///< taken
};

/// Picks few contacts that hold like many: grouped by normal, from every group the deepest and its
/// outermost neighbours. Deterministic; the result keeps the order of `contacts`.
std::vector<FramedContact> reduce(const std::vector<FramedContact>& contacts,
                                  const ReductionSettings& settings = {});

}  // namespace pierce::bullet
