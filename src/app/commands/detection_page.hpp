#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/output/frame_log.hpp"
#include "page/scene_page.hpp"
#include "pierce/world.hpp"

namespace pierce::app {

/// The page of a detection, if its options ask for one; else nothing.
class DetectionPage {
public:
    /// Throws InputError if the page cannot be written, or if there is no world whose contacts it
    /// could show. The options and the world must outlive the page.
    DetectionPage(const DetectionOptions& options, World* world, const std::string& title,
                  const std::vector<std::string>& body_names, double dt);

    /// The world after a step, with the figures of the log's last frame.
    void add(const FrameLog& log);
    /// Writes the page and says where it is. `recording`: the folder that has the frames; empty:
    /// none.
    void write(const nlohmann::json& settings, const std::filesystem::path& recording = {}) const;

private:
    const DetectionOptions& options_;
    World* world_;
    std::optional<page::ScenePage> page_;
};

}  // namespace pierce::app
