#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/output/plot.hpp"

namespace pierce::app {

/// A number over time, under its name.
struct TimeColumn {
    std::string name;
    std::span<const double> values;
};

/// One row for each time; with a `window` [s], one for each such stretch of time, of its means.
/// What is left at the end of the last whole one is left out.
Table over_time(std::span<const double> time, std::span<const TimeColumn> columns,
                double window = 0);

/// What curves of depth are averaged over [s].
inline constexpr double depth_window = 0.2;

}  // namespace pierce::app
