#include "app/reports/cloth/cloth_report.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/measure/truth_program.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/page.hpp"
#include "app/reports/cloth/cloth_figures.hpp"
#include "app/reports/cloth/cloth_size_figure.hpp"

namespace pierce::app {

int report_cloth(const ClothReportOptions& options) {
    check_truth_program();
    const auto of_scene = [](std::uint32_t nodes) {
        return nodes > 0 ? nlohmann::json(nodes) : nlohmann::json("the scene's own");
    };
    Page page(options.out, "Cloth: time and error, measured here",
              {{"seed", options.seed},
               {"threads for detection", options.threads},
               {"seconds", options.timing.seconds},
               {"seconds on the capsule", options.falling.seconds},
               {"nodes", of_scene(options.nodes)},
               {"sizes", options.sizes},
               {"seconds of sizes", options.size_seconds},
               {"nodes of layers", of_scene(options.layers_nodes)}},
              options.html);
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t used = std::clock();
    const auto penetration = [&] {
        cloth_penetration_figure(options, page);
        cloth_variants_figure(options, page);
    };
    const auto times = [&] {
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
        page.line(
            "\nAll this took {:.0f} s, {:.0f} s of them this process' own; the rest waited for the "
            "truth and for other work, which makes frames longer.",
            wall.count(), static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC);
    };
    std::vector<Page::Part> parts{{"accuracy", [&] { cloth_accuracy_figure(options, page); }},
                                  {"penetration", penetration},
                                  {"size", [&] { cloth_size_figure(options, page); }}};
    std::erase_if(parts, [&](const Page::Part& part) {
        return std::ranges::find(options.parts, part.name) == options.parts.end();
    });
    parts.push_back({"time that all this took", times});
    page.write(parts);
    return 0;
}

}  // namespace pierce::app
