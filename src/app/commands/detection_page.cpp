#include "app/commands/detection_page.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "app/output/json_file.hpp"
#include "app/output/provenance.hpp"
#include "pierce/error.hpp"

namespace pierce::app {

using nlohmann::json;

DetectionPage::DetectionPage(const DetectionOptions& options, World* world,
                             const std::string& title, const std::vector<std::string>& body_names,
                             double dt)
    : options_(options), world_(world) {
    if (options.html.empty()) return;
    if (world == nullptr) throw InputError("--html needs --method rays: it shows their contacts");
    check_writable(options.html);
    page_.emplace(page::ScenePage::Options{
        .title = title, .body_names = body_names, .dt = dt, .reasons = options.reasons});
}

void DetectionPage::add(const FrameLog& log) {
    if (page_) page_->add(*world_, frame_json(log.size() - 1, log.frames().back()));
}

void DetectionPage::write(const json& settings, const std::filesystem::path& recording) const {
    if (!page_) return;
    json made_with{{"settings", settings},
                   {"machine", machine_json()},
                   {"versions", versions_json()},
                   {"backend", {{"name", world_->backend()}}},
                   {"notes", world_->plan().notes}};
    if (!recording.empty()) made_with["recording"] = recording.string();
    page_->write(options_.html, made_with);
    fmt::print("page: {}\n", std::filesystem::absolute(options_.html).string());
}

}  // namespace pierce::app
