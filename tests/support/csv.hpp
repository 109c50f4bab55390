#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace pierce::test {

/// Rows by the names of their columns.
struct Csv {
    std::vector<std::map<std::string, std::string>> rows;
    std::string made_with;  ///< its first line, which a report writes

    /// Of the row whose `name` it is; NaN if there is none.
    double number(const std::string& name, const std::string& column) const {
        for (const auto& row : rows)
            if (row.at("name") == name) return std::stod(row.at(column));
        return NAN;
    }
    /// Numbers of all rows; throws if there is no such column.
    std::vector<double> column(const std::string& name) const {
        std::vector<double> values;
        for (const auto& row : rows) values.push_back(std::stod(row.at(name)));
        return values;
    }
    bool has_column(const std::string& name) const {
        return !rows.empty() && rows.front().contains(name);
    }
};

inline Csv read_csv(const std::filesystem::path& file) {
    std::ifstream in(file);
    const auto cells = [&](std::vector<std::string>& list) {
        std::string line, cell;
        if (!std::getline(in, line)) return false;
        list.clear();
        for (std::istringstream parts(line); std::getline(parts, cell, ',');) list.push_back(cell);
        return true;
    };
    std::vector<std::string> names, values;
    Csv csv;
    if (in.peek() == '#') std::getline(in, csv.made_with);
    cells(names);
    while (cells(values)) {
        auto& row = csv.rows.emplace_back();
        for (std::size_t i = 0; i < values.size(); ++i) row[names.at(i)] = values[i];
    }
    return csv;
}

}  // namespace pierce::test
