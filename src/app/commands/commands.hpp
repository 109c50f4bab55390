#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/detect/method.hpp"

namespace pierce::app {

/// A page that plays the frames.
struct PageOptions {
    std::filesystem::path file;  ///< empty: none
    bool reasons = true;         ///< why vertices have no contact
};

/// What every command that detects contacts can be told.
struct DetectionOptions {
    std::string method = "rays";
    scenes::RaySettings rays = {};
    std::filesystem::path json;  ///< empty: none
    PageOptions page = {};
};

struct RunOptions {
    std::string scene;
    std::uint32_t count = 100;
    bool soft = false;
    double seconds = 10;
    double dt = 0;  ///< [s] 0: the scene's own
    std::uint32_t seed = 1;
    std::uint32_t nodes = 0;
    std::filesystem::path record, png;
    DetectionOptions detection;
};

struct ReplayOptions {
    std::filesystem::path folder;
    bool deforming = false;  ///< give rigid motion vertex by vertex
    std::filesystem::path png, pictures;
    DetectionOptions detection;
};

struct DetectOptions {
    std::vector<std::filesystem::path> meshes;
    DetectionOptions detection;
};

/// The commands. Each returns the process's exit code and throws InputError for what the user can
/// mend.
int list_scenes();
int show_plan(const RunOptions& options);
int run(const RunOptions& options);
int replay(const ReplayOptions& options);
int detect(const DetectOptions& options);
/// 100 tori by rays and by GJK/EPA, with a picture of the last frame and a page of all.
int demo(const std::filesystem::path& png, const std::filesystem::path& html);

}  // namespace pierce::app
