#include "app/output/plot.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/output/draw_plots.hpp"

namespace pierce::app {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// What all kinds of plots have.
json begin(const char* kind, const fs::path& svg, const std::string& title, const std::string& x) {
    return {{"kind", kind}, {"file", svg.string()}, {"title", title}, {"x", x}};
}

/// Letters that are no UTF-8, as names of files may have, become question marks.
std::string text_of(const json& plot) {
    return plot.dump(-1, ' ', false, json::error_handler_t::replace);
}

const char* name_of(Stroke stroke) {
    switch (stroke) {
        case Stroke::solid:
            return "solid";
        case Stroke::dashed:
            return "dashed";
        case Stroke::dotted:
            return "dotted";
        case Stroke::bare:
            return "bare";
        case Stroke::points:
            return "points";
    }
    return "solid";
}

template <class Plot>
bool write(const Plot& plot, const fs::path& folder, const std::string& name,
           const std::string& made_with) {
    plot.table.write_csv(folder / (name + ".csv"), made_with);
    const std::string description = description_of(plot, folder / (name + ".svg"));
    const std::string problem = draw_plots({&description, 1});
    if (!problem.empty()) fmt::print(stderr, "no picture of {}: {}\n", name, problem);
    return problem.empty();
}

}  // namespace

std::string description_of(const Curves& curves, const fs::path& svg) {
    json plot = begin("curves", svg, curves.title, curves.x);
    plot.update({{"y", curves.y},
                 {"log_x", curves.log_x},
                 {"log_y", curves.log_y},
                 {"columns", curves.table.names},
                 {"rows", curves.table.rows},
                 {"lines", json::array()}});
    for (const Line& line : curves.lines)
        plot["lines"].push_back({{"look", line.look},
                                 {"name", line.name},
                                 {"note", line.note},
                                 {"stroke", name_of(line.stroke)},
                                 {"panel", line.panel}});
    return text_of(plot);
}

std::string description_of(const HeatMap& map, const fs::path& svg) {
    json plot = begin("map", svg, map.title, map.x);
    plot.update({{"y", map.y}, {"value", map.value}, {"rows", map.table.rows}});
    return text_of(plot);
}

std::string description_of(const Scatter& scatter, const fs::path& svg) {
    json plot = begin("scatter", svg, scatter.title, scatter.x);
    plot.update({{"y", scatter.y}, {"corner", scatter.corner}, {"points", json::array()}});
    for (const Scatter::Point& point : scatter.points)
        plot["points"].push_back({{"look", point.look},
                                  {"x", point.x},
                                  {"y", point.y},
                                  {"stands_out", point.stands_out}});
    return text_of(plot);
}

bool write_plot(const Curves& curves, const fs::path& folder, const std::string& name,
                const std::string& made_with) {
    return write(curves, folder, name, made_with);
}

bool write_plot(const HeatMap& map, const fs::path& folder, const std::string& name,
                const std::string& made_with) {
    return write(map, folder, name, made_with);
}

bool write_plot(const Scatter& scatter, const fs::path& folder, const std::string& name,
                const std::string& made_with) {
    return write(scatter, folder, name, made_with);
}

}  // namespace pierce::app
