#include "app/output/scatter_plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "app/output/gnuplot.hpp"
#include "app/output/label_places.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

namespace {

// Lengths [pixels].
constexpr int width = 800, font_size = 13, title_size = 17;
constexpr double left = 66, right = 780;  // of all panels
constexpr double head = 44, foot = 56;    // above the first panel, and below the last
constexpr double caption = 28;            // of a panel, above it
constexpr double panel_height = 270;
constexpr double zero_height = 64;              // of the part of a panel that zeros have
constexpr double room_above = 14;               // between the last decade and the border
constexpr double radius = 5, large_radius = 9;  // of markers
constexpr double rim = 1.2;                     // around a marker
constexpr double line_height = 1.25 * font_size;

// Parts of the range of x that stay free beside the points: names need room.
constexpr double free_left = 0.14, free_right = 0.14;

constexpr const char* ink = "#222222";
constexpr const char* pale_ink = "#666666";
constexpr const char* grid_colour = "#e4e4e4";
constexpr const char* zero_colour = "#f3f3f3";
constexpr const char* line_colour = "#8a8a8a";

constexpr int shapes[] = {7, 5};                    // gnuplot's types: circle, square
constexpr double half_width = 3.0 / 8 * font_size;  // of a shape at gnuplot's size 1

int shape_of(std::size_t kind) { return shapes[kind % std::size(shapes)]; }

/// No text is wider in common sans-serif faces, of which DejaVu Sans and Verdana are the widest.
double text_width(const std::string& text, bool bold) {
    double sum = 0;
    for (const char c : text) {
        if ((c & 0xc0) == 0x80) continue;  // not the first byte of a letter
        const bool is_narrow = std::string_view("fijlrtI()[]-.,:;' ").find(c) != std::string::npos,
                   is_wide = (c & 0x80) != 0 ||
                             std::string_view("mwMW%@").find(c) != std::string::npos,
                   is_capital = c >= 'A' && c <= 'Z';
        sum += is_narrow ? 0.42 : is_wide ? 1 : is_capital ? 0.79 : 0.64;
    }
    return (bold ? 1.15 : 1) * font_size * sum;
}

/// How a text is set.
struct Face {
    const char* style = "";  ///< Bold or Italic
    int size = font_size;
    const char* colour = ink;
};
constexpr Face plain, bold{"Bold"}, title_face{"Bold", title_size},
    hint{.style = "Italic", .colour = pale_ink};

/// A logarithmic axis: of a part of the picture, and the powers of ten at its ends.
struct LogAxis {
    double low_at, high_at;
    double low, high;

    double at(double value) const {
        return low_at + (high_at - low_at) * (std::log10(value) - low) / (high - low);
    }
    double value(double pixels) const {
        return std::pow(10, low + (high - low) * (pixels - low_at) / (high_at - low_at));
    }
    std::string range() const {
        return fmt::format("[{:.9g}:{:.9g}]", std::pow(10, low), std::pow(10, high));
    }
};

LogAxis x_axis(const Scatter& scatter) {
    double low = 1e300, high = -1e300;
    for (const Scatter::Point& point : scatter.points) {
        low = std::min(low, std::log10(point.x));
        high = std::max(high, std::log10(point.x));
    }
    if (low > high) low = high = 0;
    const double span = std::max(high - low, 0.3) / (1 - free_left - free_right);
    return {.low_at = left,
            .high_at = right,
            .low = low - free_left * span,
            .high = high + free_right * span};
}

/// Powers of ten as people read them.
std::string power_of_ten(int exponent) {
    static const char* const raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    if (std::abs(exponent) <= 3) return fmt::format("{:g}", std::pow(10, exponent));
    std::string result = exponent < 0 ? "10⁻" : "10";
    for (char digit : std::to_string(std::abs(exponent))) result += raised[digit - '0'];
    return result;
}

/// One panel: where it is, and its axis over the place of the zeros.
struct Panel {
    double top, bottom, zeros;  // [pixels]
    LogAxis y;
    int lowest, highest;  // powers of ten that have a line

    Spot at(const LogAxis& x, const Scatter::Point& point, std::size_t p) const {
        return {x.at(point.x), point.y[p] > 0 ? y.at(point.y[p]) : zeros};
    }
};

Panel panel_of(const Scatter& scatter, std::size_t p) {
    double least = 1e300, most = 0;
    for (const Scatter::Point& point : scatter.points) {
        if (point.y[p] > 0) least = std::min(least, point.y[p]);
        most = std::max(most, point.y[p]);
    }
    Panel panel{};
    panel.top = head + caption + static_cast<double>(p) * (panel_height + caption);
    panel.bottom = panel.top + panel_height;
    panel.zeros = panel.bottom - zero_height / 2;
    panel.lowest = most > 0 ? static_cast<int>(std::floor(std::log10(least))) : 0;
    panel.highest = most > 0 ? static_cast<int>(std::ceil(std::log10(most))) : 0;
    panel.highest = std::max(panel.highest, panel.lowest + 1);
    const double decade = (panel_height - zero_height - room_above) /
                          (panel.highest - panel.lowest);
    panel.y = {.low_at = panel.bottom,
               .high_at = panel.top,
               .low = panel.lowest - zero_height / decade,
               .high = panel.highest + room_above / decade};
    return panel;
}

class Script {
public:
    Script(const Scatter& scatter, const fs::path& svg)
        : scatter_(scatter), x_(x_axis(scatter)), height_(height_of(scatter)) {
        text_ = svg_output(svg, width, static_cast<int>(height_), font_size) +
                "set multiplot\nunset key\nset logscale xy\nset border lc rgb '" + line_colour +
                "' lw 1\nset grid lt 1 lc rgb '" + grid_colour +
                "' lw 1\nset tics nomirror scale 0 textcolor rgb '" + ink + "'\n";
        text_ += fmt::format(
            "set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}\nset xrange {}\n"
            "unset mxtics\nunset mytics\n",
            left / width, right / width, x_.range());
        // First who stands out: the best place is free, and what is nearby is drawn over it.
        for (std::size_t i = 0; i < scatter.points.size(); ++i) order_.push_back(i);
        std::ranges::stable_sort(order_,
                                 [&](auto a, auto b) { return stands_out(a) && !stands_out(b); });
        for (std::size_t p = 0; p < scatter.panels.size(); ++p) add_panel(p);
    }

    std::string text() const { return text_ + "unset multiplot\n"; }

private:
    static double height_of(const Scatter& scatter) {
        return head + foot + static_cast<double>(scatter.panels.size()) * (panel_height + caption);
    }
    bool stands_out(std::size_t i) const { return scatter_.points[i].stands_out; }

    std::string at(Spot spot) const {
        return fmt::format("screen {:.6f},{:.6f}", spot.x / width, 1 - spot.y / height_);
    }
    void add_text(const std::string& text, Spot spot, const char* align, const Face& face = plain) {
        text_ += fmt::format(
            "set label {} at {} {} enhanced front font 'sans-serif,{}' textcolor rgb '{}'\n",
            quoted(styled(text, face.style)), at(spot), align, face.size, face.colour);
    }
    void add_mark(std::size_t kind, Spot spot) {
        text_ += fmt::format("set label '' at {} point pt {} ps {:.4g} lc rgb '{}'\n", at(spot),
                             shape_of(kind), radius / half_width, pale_ink);
    }
    void add_line(Spot from, Spot to, const std::string& how) {
        text_ += fmt::format("set arrow from {} to {} nohead {}\n", at(from), at(to), how);
    }

    /// What stands once, above the panels and below them.
    void add_surroundings() {
        add_text(scatter_.title, {left, head / 2}, "left", title_face);
        double end = right;
        for (std::size_t k = scatter_.kinds.size(); k-- > 0;) {
            const std::string& kind = scatter_.kinds[k];
            end -= text_width(kind, false);
            add_text(kind, {end, head / 2}, "left");
            end -= 2.5 * radius;
            add_mark(k, {end, head / 2});
            end -= 3 * radius;
        }
        add_text(scatter_.x, {(left + right) / 2, height_ - foot / 4}, "center");
    }

    void add_panel(std::size_t p) {
        const Panel panel = panel_of(scatter_, p);
        const bool last = p + 1 == scatter_.panels.size();
        text_ += "unset label\nunset arrow\nunset object\n";
        if (p == 0) add_surroundings();
        add_text(scatter_.panels[p], {left, panel.top - caption / 2}, "left", bold);
        text_ += fmt::format("set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}\n",
                             1 - panel.top / height_, 1 - panel.bottom / height_);
        text_ += fmt::format(
            "set object rectangle from graph 0,0 to graph 1,{:.6f} fc rgb '{}' fs solid noborder "
            "behind\n",
            zero_height / panel_height, zero_colour);
        add_line({left, panel.zeros}, {right, panel.zeros},
                 fmt::format("back lw 1.5 lc rgb '{}'", line_colour));
        add_ticks(panel, last);
        std::vector<Area> taken{{{left, panel.zeros}, {right, panel.zeros}}};
        for (const Scatter::Point& point : scatter_.points)
            if (point.stands_out) {
                const double x = x_.at(point.x);
                add_line({x, panel.top}, {x, panel.bottom + (last ? 0 : caption)},
                         fmt::format("back lw 1.5 dt (4,4) lc rgb '{}'", point.colour));
                taken.push_back({{x, panel.top}, {x, panel.bottom}});
            }
        const double middle = (panel.zeros + panel.bottom) / 2;
        const Spot corner{left + radius, middle + 1};
        add_text(scatter_.corner, corner, "left", hint);
        taken.push_back(
            {{corner.x, middle - line_height / 2},
             {corner.x + text_width(scatter_.corner, false), middle + line_height / 2}});
        add_names(panel, p, taken);
        add_points(panel, p);
    }

    void add_ticks(const Panel& panel, bool last) {
        text_ += fmt::format("set yrange {}\nset ytics ('none' {:.6g}", panel.y.range(),
                             panel.y.value(panel.zeros));
        const double decade = panel.y.at(10) - panel.y.at(100);
        const int step = std::max(1, static_cast<int>(std::ceil(1.2 * font_size / decade)));
        for (int e = panel.lowest; e <= panel.highest; ++e)
            text_ += fmt::format(", '{}' 1e{}", (e - panel.highest) % step ? "" : power_of_ten(e),
                                 e);
        text_ += ")\nset xtics (";
        std::string ticks;
        for (int e = static_cast<int>(std::floor(x_.low)); e <= x_.high; ++e)
            for (int digit : {1, 2, 5}) {
                const double value = digit * std::pow(10, e);
                if (std::log10(value) < x_.low || std::log10(value) > x_.high) continue;
                ticks += fmt::format("{}'{}' {:.6g}", ticks.empty() ? "" : ", ",
                                     last ? fmt::format("{:g}", value) : "", value);
            }
        text_ += ticks + ")\n";
    }

    void add_names(const Panel& panel, std::size_t p, const std::vector<Area>& taken) {
        std::vector<Marker> markers;
        for (std::size_t i : order_) {
            const Scatter::Point& point = scatter_.points[i];
            markers.push_back({.at = panel.at(x_, point, p),
                               .radius = (point.stands_out ? large_radius : radius) + rim,
                               .width = text_width(point.name, point.stands_out),
                               .height = line_height});
        }
        const Area frame{{left + radius, panel.top + 1}, {right - radius, panel.bottom - 1}};
        const std::vector<LabelPlace> places = label_places(markers, frame, taken);
        for (std::size_t k = 0; k < places.size(); ++k) {
            const Scatter::Point& point = scatter_.points[order_[k]];
            const LabelPlace& place = places[k];
            const double y = (place.box.low.y + place.box.high.y) / 2,
                         x = (place.box.low.x + place.box.high.x) / 2;
            // Where a face is narrower than estimated, the name stays beside its marker.
            const double at_x = markers[k].at.x;
            const Face& face = point.stands_out ? bold : plain;
            if (at_x < place.box.low.x)
                add_text(point.name, {place.box.low.x, y}, "left", face);
            else if (at_x > place.box.high.x)
                add_text(point.name, {place.box.high.x, y}, "right", face);
            else
                add_text(point.name, {x, y}, "center", face);
            if (place.led)
                add_line(place.from, place.to, fmt::format("front lw 1 lc rgb '{}'", pale_ink));
        }
    }

    /// Points over others are smaller, so that these are seen around them.
    void add_points(const Panel& panel, std::size_t p) {
        std::vector<Marker> drawn;
        text_ += fmt::format("$panel{} << EOD\n", p);
        for (std::size_t i : order_) {
            const Scatter::Point& point = scatter_.points[i];
            Marker marker{.at = panel.at(x_, point, p),
                          .radius = point.stands_out ? large_radius : radius};
            for (const Marker& other : drawn)
                if (std::hypot(other.at.x - marker.at.x, other.at.y - marker.at.y) < radius)
                    marker.radius = std::min(marker.radius, other.radius / 2);
            drawn.push_back(marker);
            const auto add = [&](double r, const std::string& colour) {
                text_ += fmt::format("{:.6g} {:.6g} {:.4g} {} 0x{}\n", point.x,
                                     panel.y.value(marker.at.y), r / half_width,
                                     shape_of(point.kind), colour.substr(1));
            };
            add(marker.radius + rim, ink);
            add(marker.radius, point.colour);
        }
        text_ += fmt::format(
            "EOD\nplot $panel{} using 1:2:3:4:5 with points pt variable ps variable lc rgb "
            "variable title {}\n",
            p, quoted(scatter_.panels[p]));
    }

    const Scatter& scatter_;
    LogAxis x_;
    double height_;
    std::vector<std::size_t> order_;
    std::string text_;
};

}  // namespace

bool write_plot(const Scatter& scatter, const fs::path& folder, const std::string& name,
                const std::string& made_with) {
    scatter.table.write_csv(folder / (name + ".csv"), made_with);
    return run_gnuplot(Script(scatter, folder / (name + ".svg")).text());
}

}  // namespace pierce::app
