#include "app/commands/detection_page.hpp"

#include <fmt/core.h>

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/output/detection_json.hpp"
#include "app/output/json_file.hpp"
#include "app/output/progress.hpp"
#include "app/output/provenance.hpp"
#include "page/step_figures.hpp"
#include "pierce/error.hpp"
#include "scenes/detect/detector.hpp"

namespace pierce::app {

using nlohmann::json;

namespace {

/// For a shell.
std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

/// A value as an option of a command takes it.
std::string option_value(const json& value) {
    if (value.is_boolean()) return value.get<bool>() ? "on" : "off";
    return value.is_string() ? value.get<std::string>() : value.dump();
}

/// The beginning of a command that explains a frame of a recording as `settings`, by rays_json(),
/// have found it.
std::string explain_command(const std::filesystem::path& recording, const json& settings) {
    std::string command = "pierce explain " + quoted(recording.string());
    const json standard = rays_json({});
    for (const auto& [key, option] :
         {std::pair{"coverage", "--coverage"}, std::pair{"reproject", "--reproject"},
          std::pair{"margin", "--margin"}, std::pair{"temporal", "--temporal"},
          std::pair{"predict", "--predict"}, std::pair{"may_rest", "--rest"},
          std::pair{"full_every", "--full-every"}, std::pair{"inside", "--inside"}}) {
        const json& value = settings.at(key);
        if (value != standard.at(key))
            command += fmt::format(" {} {}", option, option_value(value));
    }
    return command;
}

}  // namespace

DetectionPage::DetectionPage(PageOptions options, World* world, const std::string& title,
                             const std::vector<std::string>& body_names, double dt)
    : options_(std::move(options)), world_(world) {
    if (options_.file.empty()) return;
    if (world == nullptr) throw InputError("--html needs --method rays: it shows their contacts");
    check_writable(options_.file);
    std::map<BodyId, std::string> names;  // a scene removes no body
    for (const std::string& name : body_names)
        names.emplace(BodyId{static_cast<std::uint32_t>(names.size()), 1}, name);
    page_.emplace(page::ScenePage::Options{
        .title = title, .body_names = std::move(names), .dt = dt, .reasons = options_.reasons});
}

void DetectionPage::add(const json& figures) {
    if (page_) page_->add(*world_, figures);
}

void DetectionPage::write(const json& settings, const std::filesystem::path& recording,
                          const json& tables) const {
    if (!page_) return;
    const Plan& plan = world_->plan();
    json made_with{{"settings", settings},
                   {"plan", page::plan_figures(plan)},
                   {"machine", machine_json()},
                   {"versions", versions_json()},
                   {"backend", {{"name", world_->backend()}}},
                   {"notes", plan.notes},
                   {"tables", tables}};
    if (!recording.empty()) {
        json rays = rays_json({.world = plan.settings});
        for (auto& [key, value] : rays.items())
            if (settings.contains(key)) value = settings[key];
        made_with["explain"] = explain_command(recording, rays);
    }
    page_->write(options_.file, made_with, show_share("writing " + options_.file.string()));
    fmt::print("page: {}\n", std::filesystem::absolute(options_.file).string());
}

void write_page_of(const scenes::Recording& recording, const PageOptions& options,
                   const scenes::RaySettings& rays, const std::string& title,
                   const std::vector<json>& figures, std::uint32_t every, const json& settings,
                   const json& tables, const std::filesystem::path& folder) {
    if (options.file.empty()) return;
    const scenes::SceneSetup scene = scenes::scene_of(recording);
    const auto detector = scenes::make_detector(scene, scenes::Method::rays, rays);
    DetectionPage page(options, detector->world(), title, names_of(scene), recording.dt * every);
    Progress progress("making the page", static_cast<std::uint32_t>(figures.size()));
    for (std::uint32_t k = 0; k < figures.size(); ++k) {
        scenes::put_frame(*detector, recording, k * every);
        detector->detect();
        page.add(figures[k]);
        try {
            progress.show(k + 1);
        } catch (Interrupted& stop) {
            stop.missing = options.file.string() + " is missing; what comes before it is written";
            throw;
        }
    }
    page.write(settings, folder, tables);
}

std::vector<std::string> names_of(const scenes::SceneSetup& scene) {
    std::vector<std::string> names;
    names.reserve(scene.bodies.size());
    for (const scenes::SceneBody& body : scene.bodies) names.push_back(body.name);
    return names;
}

}  // namespace pierce::app
