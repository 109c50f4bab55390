#include <algorithm>

#include "app/reports/paper/modes.hpp"
#include "app/reports/paper/sections.hpp"

namespace pierce::app {

using scenes::ContactError;

void threshold_map(const Pile& pile, Page& page) {
    const std::string& name = pile.name;
    const scenes::Recording& recording = pile.loop.recording;
    std::vector<Mode> modes;
    modes.push_back(mode("off", Temporal::off, false));
    const double thresholds[] = {0.1, 0.5, 1, 2, 4, 8};
    for (double threshold : thresholds) {
        modes.push_back(mode(fmt::format("{}", threshold), Temporal::paper, true));
        modes.back().settings.walk_threshold = threshold;
        modes.back().settings.full_every = 64;  // so that the threshold decides, not the period
    }
    measure(recording, modes, "threshold, " + name);
    Curves curves{.title = "What the walk threshold costs, " + name,
                  .x = "displacement allowed since the last full ray [edges]",
                  .y = {"share [%]", "steps per walk", "times as fast as without memory"},
                  .table = {{"threshold", "missed depth [%]", "wrong triangle [%]",
                             "lost walks [%]", "steps per walk", "off / this, narrow phase"},
                            {}},
                  .log_x = true,
                  .log_y = true,
                  .lines = {{.name = "depth that is missed"},
                            {.name = "contacts at a wrong triangle"},
                            {.name = "walks that are lost"},
                            {.name = "steps per walk", .panel = 1},
                            {.name = "narrow phase", .panel = 2}}};
    for (std::size_t m = 1; m < modes.size(); ++m) {
        const ContactError& e = modes[m].comparison.error();
        const auto walks = static_cast<double>(
            std::max<std::uint64_t>(modes[m].half(true).walks, 1));
        curves.table.rows.push_back(
            {thresholds[m - 1], 100 * e.missed_share(), 100 * e.wrong_share(),
             100 * static_cast<double>(modes[m].half(true).lost) / walks,
             static_cast<double>(modes[m].half(true).walk_steps) / walks,
             modes[0].half(true).median_ms() / modes[m].half(true).median_ms()});
    }
    page.plot(curves, "f4_threshold_" + name);
}

void period_map(const Pile& pile, Page& page) {
    const std::string& name = pile.name;
    const scenes::Recording& recording = pile.loop.recording;
    const double periods[] = {1, 2, 4, 8, 16, 32};
    const double reaches[] = {0, 0.125, 0.25, 0.5, 1};
    double edge = 0;  // of the falling bodies' mesh
    for (const scenes::SceneBody& body : pile.scene.bodies)
        if (!body.ground) {
            const scenes::SceneMesh& mesh = pile.scene.meshes[body.mesh];
            edge = Mesh(mesh.name, mesh.data).traits().mean_edge_length;
            break;
        }
    std::vector<Mode> modes;
    modes.push_back(mode("off", Temporal::off, false));
    for (double reach : reaches)
        for (double period : periods) {
            modes.push_back(mode(fmt::format("{} {}", period, reach), Temporal::paper, reach > 0));
            modes.back().settings.full_every = static_cast<std::uint32_t>(period);
            modes.back().settings.prediction_distance = reach * edge;
        }
    measure(recording, modes, "period, " + name);
    HeatMap missed{.title = "Contacts missed in their first frame, " + name,
                   .x = "full pass every K steps",
                   .y = "predictions look ahead [edges]",
                   .value = "missed [%]",
                   .table = {{"K", "reach", "missed_percent"}, {}}};
    HeatMap time{.title = "Narrow phase, " + name,
                 .x = "full pass every K steps",
                 .y = "predictions look ahead [edges]",
                 .value = "times as fast as without memory",
                 .table = {{"K", "reach", "off_over_this"}, {}}};
    std::size_t m = 1;
    for (double reach : reaches)
        for (double period : periods) {
            const ContactError& e = modes[m].comparison.error();
            missed.table.rows.push_back(
                {period, reach,
                 100 * static_cast<double>(e.first_missed) /
                     static_cast<double>(std::max<std::uint64_t>(e.first, 1))});
            time.table.rows.push_back(
                {period, reach, modes[0].half(true).median_ms() / modes[m].half(true).median_ms()});
            ++m;
        }
    page.plot(missed, "f12_missed_" + name);
    page.plot(time, "f12_time_" + name);
}

}  // namespace pierce::app
