#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/output/plot.hpp"

namespace pierce::app {

/// Named points in panels one above the other, which share a logarithmic x. The y of each panel is
/// logarithmic, too; zeros stand on a line of their own at the bottom.
struct Scatter {
    std::string title, x;
    std::vector<std::string> panels;  ///< what their y is, from the top
    std::string corner;               ///< what it means to be at the lower left
    std::vector<std::string> kinds;   ///< of points: circles, squares
    struct Point {
        std::string name;
        double x = 0;
        std::vector<double> y = {};  ///< per panel
        std::string colour;          ///< as #rrggbb
        std::size_t kind = 0;
        bool stands_out = false;
    };
    std::vector<Point> points;
    Table table;  ///< all numbers of the points, of which x and y are some
};

/// Writes NAME.csv, and, if gnuplot is installed, NAME.svg, as for the other plots. Every point has
/// its name beside it, and no name covers another one or a point.
bool write_plot(const Scatter& scatter, const std::filesystem::path& folder,
                const std::string& name, const std::string& made_with);

}  // namespace pierce::app
