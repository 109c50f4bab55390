#pragma once

#include <span>
#include <string>
#include <vector>

namespace pierce::app {

/// Python programs that may draw, by which is asked first: the one that the environment variable
/// PIERCE_PYTHON names, and no other; without it, `python3` and the system's own.
std::vector<std::string> drawing_pythons();

/// Why plots cannot be drawn here; empty if they can.
std::string drawing_problem();

/// Draws plots with matplotlib, all in one run of Python: draw_plots.py, which this program has
/// inside. `descriptions`: of description_of(). Returns why there are no pictures; empty if all
/// are drawn.
std::string draw_plots(std::span<const std::string> descriptions);

}  // namespace pierce::app
