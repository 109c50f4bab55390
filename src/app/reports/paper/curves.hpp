#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/output/plot.hpp"

namespace pierce::app {

/// A number over time, under its name, and how it is drawn.
struct TimeColumn {
    std::string name;
    std::span<const double> values;
    Line line = {};
};

/// One row for each time; with a `window` [s], one for each such stretch of time, of its means.
/// What is left at the end of the last whole one is left out.
Table over_time(std::span<const double> time, std::span<const TimeColumn> columns,
                double window = 0);

/// How columns are drawn; where a line has no name, with the column's.
std::vector<Line> lines_of(std::span<const TimeColumn> columns);

/// What curves of depth are averaged over [s].
inline constexpr double depth_window = 0.2;

}  // namespace pierce::app
