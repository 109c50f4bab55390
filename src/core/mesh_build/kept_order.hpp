#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace pierce {

/// What stands in a list of numbers for something that is gone.
inline constexpr std::uint32_t is_gone = 0xffffffff;

/// An order of `count` things that keeps to the order `before` where they are the same: `now_of`
/// says of each thing before which one it is now, or is_gone. What is new takes the places of what
/// is gone, those of the same number first. What is left then moves from the end into places that
/// are still free, or stands at the end.
std::vector<std::uint32_t> kept_order(std::span<const std::uint32_t> before,
                                      std::span<const std::uint32_t> now_of, std::uint32_t count);

}  // namespace pierce
