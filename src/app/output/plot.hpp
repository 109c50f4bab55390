#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/output/table.hpp"

namespace pierce::app {

enum class Stroke {
    solid,
    dashed,
    dotted,
    bare,   ///< a line without markers
    points  ///< markers without a line
};

/// How one curve is drawn.
struct Line {
    std::string look = {};  ///< of plot_looks.py: the same thing looks the same in every plot;
                            ///< empty: that of a curve's place, and its column's name
    std::string name = {};  ///< in the legend; empty: the look's
    std::string note = {};  ///< after the name
    Stroke stroke = Stroke::solid;
    std::size_t panel = 0;
};

/// One curve per column after the first, over the first, in panels one above the other.
struct Curves {
    std::string title, x;
    std::vector<std::string> y;  ///< of the panels, from the top
    Table table;
    bool log_x = false;            ///< zeros stand in a band before the axis
    bool log_y = false;            ///< zeros stand in a band below the axis
    std::vector<Line> lines = {};  ///< of the curves; none: plain ones
};

/// Rows are (x, y, value).
struct HeatMap {
    std::string title, x, y, value;
    Table table;
};

/// Methods as points, in panels one above the other, which share a logarithmic x. The y of each
/// panel is logarithmic, too; zeros stand in a band below it.
struct Scatter {
    std::string title, x;
    std::vector<std::string> y;  ///< of the panels, from the top
    std::string corner;          ///< what it means to be at the lower left
    struct Point {
        std::string look;  ///< as of Line; a point has no other name
        double x = 0;
        std::vector<double> y = {};  ///< per panel
        bool stands_out = false;
    };
    std::vector<Point> points;
    Table table;  ///< all numbers of the points, of which x and y are some
};

/// A plot as draw_plots.py reads it, in JSON, with the file that it shall draw.
std::string description_of(const Curves& curves, const std::filesystem::path& svg);
std::string description_of(const HeatMap& map, const std::filesystem::path& svg);
std::string description_of(const Scatter& scatter, const std::filesystem::path& svg);

/// Writes NAME.csv, with what it was made with, and, if matplotlib is installed, NAME.svg into
/// `folder`. Returns true if there is a picture; else says why not on standard error.
bool write_plot(const Curves& curves, const std::filesystem::path& folder, const std::string& name,
                const std::string& made_with);
bool write_plot(const HeatMap& map, const std::filesystem::path& folder, const std::string& name,
                const std::string& made_with);
bool write_plot(const Scatter& scatter, const std::filesystem::path& folder,
                const std::string& name, const std::string& made_with);

}  // namespace pierce::app
