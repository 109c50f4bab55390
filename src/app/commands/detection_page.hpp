#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/commands.hpp"
#include "page/scene_page.hpp"
#include "pierce/world.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::app {

/// The page of a detection, if its options ask for one; else nothing.
class DetectionPage {
public:
    /// Throws InputError if the page cannot be written, or if there is no world whose contacts it
    /// could show. The world must outlive the page.
    DetectionPage(PageOptions options, World* world, const std::string& title,
                  const std::vector<std::string>& body_names, double dt);

    /// The world after a step, with the figures of the frame.
    void add(const nlohmann::json& figures);
    /// Writes the page and says where it is. `settings`: what the frames were made with;
    /// `tables`: as ScenePage::write() has them; `recording`: the folder that has the frames;
    /// empty: none.
    void write(const nlohmann::json& settings, const std::filesystem::path& recording,
               const nlohmann::json& tables) const;

private:
    PageOptions options_;
    World* world_;
    std::optional<page::ScenePage> page_;
};

/// Writes the page of a recording's frames 0, `every`, 2 `every` and so on, as rays see them with
/// some settings, with figures that are known already, one for each of these frames; nothing if
/// `options` ask for no page.
void write_page_of(const scenes::Recording& recording, const PageOptions& options,
                   const scenes::RaySettings& rays, const std::string& title,
                   const std::vector<nlohmann::json>& figures, std::uint32_t every,
                   const nlohmann::json& settings, const nlohmann::json& tables,
                   const std::filesystem::path& folder);

/// The names of a scene's bodies.
std::vector<std::string> names_of(const scenes::SceneSetup& scene);

}  // namespace pierce::app
