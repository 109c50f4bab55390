#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/contact.hpp"

namespace pierce {

/// A contact that stands for others of its pair.
struct ReducedContact {
    std::uint32_t contact = 0;  ///< its place in the list that was reduced
    double weight = 1;          ///< how many times its force counts; positive
};

/// At least so many contacts of a pair are kept: a force and a torque have six numbers.
inline constexpr std::uint32_t least_reduced = 6;

/// Picks at most `most_per_pair` contacts of each pair, with weights. If every contact pushes along
/// its normal, in proportion to its depth, at the middle between its two points, then the weighted
/// ones have the resultant force and torque of all of them, to rounding (Caratheodory's theorem for
/// cones). Preferably the deepest contact is kept, and those far from each other in place
/// and normal. Contacts without a depth have no force: they are kept, with weight 1, as long as
/// there is room. Deterministic; the result is in the order of `contacts`. Throws InputError if
/// `most_per_pair` is less than least_reduced.
std::vector<ReducedContact> reduce(std::span<const Contact> contacts, std::uint32_t most_per_pair);

}  // namespace pierce
