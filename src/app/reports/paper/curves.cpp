#include "app/reports/paper/curves.hpp"

#include <algorithm>
#include <cmath>

#include "app/output/statistics.hpp"

namespace pierce::app {

Table over_time(std::span<const double> time, std::span<const TimeColumn> columns, double window) {
    Table table{{"time"}, {}};
    for (const TimeColumn& c : columns) table.names.push_back(c.name);
    const double spacing = time.size() > 1 ? time[1] - time[0] : 0;
    const std::size_t rows = spacing > 0
                                 ? std::max<std::size_t>(
                                       1, static_cast<std::size_t>(std::lround(window / spacing)))
                                 : 1;
    for (std::size_t begin = 0; begin + rows <= time.size(); begin += rows) {
        std::vector<double>& row = table.rows.emplace_back();
        row.push_back(mean(time.subspan(begin, rows)));
        for (const TimeColumn& c : columns) row.push_back(mean(c.values.subspan(begin, rows)));
    }
    return table;
}

std::vector<Line> lines_of(std::span<const TimeColumn> columns) {
    std::vector<Line> lines;
    for (const TimeColumn& c : columns) {
        lines.push_back(c.line);
        if (lines.back().name.empty()) lines.back().name = c.name;
    }
    return lines;
}

}  // namespace pierce::app
