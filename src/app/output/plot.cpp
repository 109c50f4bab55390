#include "app/output/plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "app/output/gnuplot.hpp"
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
    std::ofstream out(file);
    if (!made_with_now.empty()) out << "# " << made_with_now << '\n';
    if (!labels.empty()) out << label_name << ',';
    for (std::size_t c = 0; c < names.size(); ++c) out << (c > 0 ? "," : "") << as_cell(names[c]);
    out << '\n';
    for (std::size_t r = 0; r < rows.size(); ++r) {
        if (!labels.empty()) out << as_cell(labels[r]) << ',';
        for (std::size_t c = 0; c < rows[r].size(); ++c)
            out << (c > 0 ? "," : "") << fmt::format("{:.6g}", rows[r][c]);
        out << '\n';
    }
    if (!out.flush()) throw InputError("cannot write '" + file.string() + "'");
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

namespace {

std::string head(const std::string& title, const std::string& x, const std::string& y,
                 const fs::path& svg) {
    return svg_output(svg, 720, 440, 13) + "set datafile separator ','\nset title " +
           quoted(title) + " noenhanced\nset xlabel " + quoted(x) + " noenhanced\nset ylabel " +
           quoted(y) + " noenhanced\n";
}

std::string look_of(const Curves::Line& line) {
    return fmt::format("lc rgb '{}' dt {} ", line.colour, line.dashed ? 2 : 1);
}

}  // namespace

bool write_plot(const Curves& curves, const fs::path& folder, const std::string& name,
                const std::string& made_with) {
    const fs::path csv = folder / (name + ".csv");
    curves.table.write_csv(csv, made_with);
    std::string script = head(curves.title, curves.x, curves.y, folder / (name + ".svg")) +
                         "set key outside bottom center horizontal noenhanced\nset grid\n";
    if (curves.log_x) script += "set logscale x 2\nset format x '%g'\n";
    double bottom = 0;
    if (curves.log_y) {
        double least = 1;
        for (const auto& row : curves.table.rows)
            for (std::size_t c = 1; c < row.size(); ++c)
                if (row[c] > 0) least = std::min(least, row[c]);
        bottom = least / 10;
        script += "set logscale y\nset format y '%g'\n";
    }
    script += fmt::format("set yrange [{:g}:*]\nplot ", bottom);
    for (std::size_t c = 1; c < curves.table.names.size(); ++c)
        script += fmt::format(
            "{0}{1} using 1:(${2} > {3:g} ? ${2} : {3:g}) with lines lw 2 {4}title {5}",
            c > 1 ? ", " : "", quoted(csv.string()), c + 1, bottom,
            c <= curves.lines.size() ? look_of(curves.lines[c - 1]) : "",
            quoted(curves.table.names[c]));
    return run_gnuplot(script + "\n");
}

bool write_plot(const HeatMap& map, const fs::path& folder, const std::string& name,
                const std::string& made_with) {
    const fs::path csv = folder / (name + ".csv");
    map.table.write_csv(csv, made_with);
    // Places, not values, along the axes: the values are powers of two and zero.
    std::vector<double> xs, ys;
    for (const auto& row : map.table.rows) {
        if (xs.empty() || row[1] == map.table.rows[0][1]) xs.push_back(row[0]);
        if (row[0] == map.table.rows[0][0]) ys.push_back(row[1]);
    }
    std::string script = head(map.title, map.x, map.y, folder / (name + ".svg")) + "set cblabel " +
                         quoted(map.value) +
                         " noenhanced\nset palette defined (0 'white', 1 'orange', 2 "
                         "'dark-red')\nset cbrange [0:*]\nunset key\n";
    const auto ticks = [&](const char* axis, const std::vector<double>& values) {
        script += fmt::format("set {}tics (", axis);
        for (std::size_t i = 0; i < values.size(); ++i)
            script += fmt::format("{}'{:g}' {}", i > 0 ? ", " : "", values[i], i);
        script += ")\n";
    };
    ticks("x", xs);
    ticks("y", ys);
    script += "$map << EOD\n";
    for (std::size_t i = 0; i < map.table.rows.size(); ++i)
        script += fmt::format("{},{},{:.6g}\n", i % xs.size(), i / xs.size(), map.table.rows[i][2]);
    script +=
        "EOD\nplot $map using 1:2:3 with image pixels, $map using 1:2:(sprintf('%.3g', $3)) with "
        "labels\n";
    return run_gnuplot(script);
}

}  // namespace pierce::app
