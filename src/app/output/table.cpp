#include "app/output/table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

namespace {

std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(cell);
    return cells;
}

/// Names may hold commas, which a cell may not.
std::string as_cell(std::string name) {
    std::ranges::replace(name, ',', ';');
    return name;
}

}  // namespace

void Table::write_csv(const fs::path& file, const std::string& made_with_now) const {
    write_whole_file(file, [&](std::ostream& out) {
        if (!made_with_now.empty()) out << "# " << made_with_now << '\n';
        if (!labels.empty()) out << label_name << ',';
        for (std::size_t c = 0; c < names.size(); ++c)
            out << (c > 0 ? "," : "") << as_cell(names[c]);
        out << '\n';
        for (std::size_t r = 0; r < rows.size(); ++r) {
            if (!labels.empty()) out << as_cell(labels[r]) << ',';
            for (std::size_t c = 0; c < rows[r].size(); ++c)
                out << (c > 0 ? "," : "") << fmt::format("{:.6g}", rows[r][c]);
            out << '\n';
        }
    });
}

double Table::number(std::size_t row, const std::string& name) const {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) throw InputError("a table has no column '" + name + "'");
    return rows.at(row).at(static_cast<std::size_t>(found - names.begin()));
}

Table Table::read_csv(const fs::path& file) {
    std::ifstream in(file);
    Table table;
    bool labelled = false;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("# ")) {
            table.made_with = line.substr(2);
            continue;
        }
        std::vector<std::string> cells = cells_of(line);
        if (table.names.empty()) {
            labelled = !cells.empty() && (cells[0] == rows_label || cells[0] == points_label);
            if (labelled) table.label_name = cells[0];
            table.names.assign(cells.begin() + (labelled ? 1 : 0), cells.end());
            continue;
        }
        if (cells.size() != table.names.size() + (labelled ? 1 : 0))
            throw InputError("'" + file.string() + "' has a line of another length: " + line);
        if (labelled) table.labels.push_back(cells[0]);
        std::vector<double>& row = table.rows.emplace_back();
        for (std::size_t c = labelled ? 1 : 0; c < cells.size(); ++c) {
            char* end = nullptr;
            row.push_back(std::strtod(cells[c].c_str(), &end));
            if (end == cells[c].c_str() || *end != 0)
                throw InputError("'" + file.string() + "' has no number in '" + cells[c] + "'");
        }
    }
    if (table.names.empty()) throw InputError("cannot read '" + file.string() + "'");
    return table;
}

}  // namespace pierce::app
