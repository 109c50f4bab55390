#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace pierce::app {

/// What labels of rows are called in a file: those of tables, and those of plotted points.
inline constexpr const char *rows_label = "row", *points_label = "name";

/// Columns of numbers under their names.
struct Table {
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;
    std::vector<std::string> labels = {};  ///< of the rows; none, or one for each
    std::string label_name = rows_label;   ///< of the labels
    std::string made_with = {};            ///< of a table that was read

    /// The number in a row under a name. Throws InputError if there is no such name.
    double number(std::size_t row, const std::string& name) const;

    /// Commas between values, a line of names, and before it, after a "#", `made_with`: what the
    /// table depends on; no such line if that is empty. Commas in names become semicolons. Throws
    /// InputError if the file cannot be written.
    void write_csv(const std::filesystem::path& file, const std::string& made_with) const;
    /// A table that write_csv() has written. Throws InputError, naming the file, if it is not.
    static Table read_csv(const std::filesystem::path& file);
};

}  // namespace pierce::app
