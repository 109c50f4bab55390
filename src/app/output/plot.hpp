#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace pierce::app {

/// Columns of numbers under their names.
struct Table {
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;
    std::vector<std::string> labels = {};  ///< of the rows; none, or one for each
    std::string made_with = {};            ///< of a table that was read

    /// Commas between values, a line of names, and before it, after a "#", `made_with`: what the
    /// table depends on; no such line if that is empty. Commas in names become semicolons. Throws
    /// InputError if the file cannot be written.
    void write_csv(const std::filesystem::path& file, const std::string& made_with) const;
    /// A table that write_csv() has written. Throws InputError, naming the file, if it is not.
    static Table read_csv(const std::filesystem::path& file);
};

/// One curve per column after the first, over the first.
struct Curves {
    std::string title, x, y;
    Table table;
    bool log_x = false;
    bool log_y = false;  ///< zeros stand at the bottom
};

/// Rows are (x, y, value), x changing fastest.
struct HeatMap {
    std::string title, x, y, value;
    Table table;
};

/// Named points; x is the first number of each, y the second, both on logarithmic axes. A y of zero
/// stands at the bottom.
struct Scatter {
    std::string title, x, y;
    std::vector<std::string> columns;
    struct Point {
        std::string name;
        std::vector<double> values;
    };
    std::vector<Point> points;
};

/// Writes NAME.csv, with what it was made with, and, if gnuplot is installed, NAME.svg into
/// `folder`. Returns true if there is a picture.
bool write_plot(const Curves& curves, const std::filesystem::path& folder, const std::string& name,
                const std::string& made_with);
bool write_plot(const HeatMap& map, const std::filesystem::path& folder, const std::string& name,
                const std::string& made_with);
bool write_plot(const Scatter& scatter, const std::filesystem::path& folder,
                const std::string& name, const std::string& made_with);

}  // namespace pierce::app
