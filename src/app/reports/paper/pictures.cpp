#include "app/output/picture.hpp"
#include "app/output/progress.hpp"
#include "app/reports/paper/sections.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::app {
namespace {

/// Writes a frame of a recording; the camera looks at where the bodies are in it.
void frame_picture(const scenes::Recording& recording, std::uint32_t frame, const std::string& name,
                   const std::string& caption, Page& page) {
    const scenes::SceneSetup scene = scenes::scene_of(recording);
    const auto detector = scenes::make_detector(scene, scenes::Method::rays);
    scenes::put_frame(*detector, recording, frame);
    detector->detect();
    World& world = *detector->world();
    const std::vector<BodyId> ground = ground_of(scene);
    write_picture(world, ground, {.around = box_of_bodies(world, ground), .contacts = true},
                  page.folder() / name);
    page.picture(name, caption);
}

void falling_pictures(const Pile& pile, int figure, Page& page) {
    const std::string& name = pile.name;
    const scenes::Recording& recording = pile.loop.recording;
    page.line("\n## Figure {}: {} {} fall\n", figure, recording.bodies.size() - 1, name);
    page.line("Dots are contacts; bodies go from yellow to red with their depth.");
    const std::uint32_t last = recording.frame_count - 1, early = last / 10;
    frame_picture(recording, early, fmt::format("figure_{}_falling.png", figure),
                  fmt::format("{} after {:.1f} s", name, early * recording.dt), page);
    frame_picture(recording, last, fmt::format("figure_{}_at_rest.png", figure),
                  fmt::format("{} after {:.1f} s", name, last * recording.dt), page);
}

}  // namespace

void pictures_of_piles(const Pile& tori, const Pile& bunnies, Page& page) {
    falling_pictures(tori, 7, page);
    falling_pictures(bunnies, 8, page);
}

void figure_15(const PaperReportOptions& options, Page& page) {
    page.line("\n## Figure 15: cloth falls on a capsule\n");
    const scenes::SceneSetup scene = scenes::make_scene("cloth-capsule", {.seed = options.seed});
    scenes::Simulation simulation(scene, scenes::Method::rays, {.world = vertex_rays});
    const std::vector<BodyId> ground = ground_of(scene);
    const auto steps = Timing{options.cloth_seconds, scene.dt}.steps();
    Progress progress("figure 15", steps);
    for (std::uint32_t i = 1; i <= steps; ++i) {
        simulation.step(scene.dt);
        progress.show(i);
        if (i != steps / 3 && i != steps) continue;
        const std::string name = i == steps ? "figure_15_folded.png" : "figure_15_falling.png";
        World& world = *simulation.world();
        write_picture(world, ground, {.around = box_of_bodies(world, ground)},
                      page.folder() / name);
        page.picture(name, fmt::format("cloth after {:.1f} s", i * scene.dt));
    }
}

}  // namespace pierce::app
