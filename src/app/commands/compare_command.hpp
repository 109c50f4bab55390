#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/commands.hpp"

namespace pierce::app {

struct CompareOptions {
    std::filesystem::path folder;
    std::vector<std::string> methods;  ///< empty: all
    int threads = 1;
    std::optional<std::uint32_t> every;  ///< truth is for every such frame
    std::filesystem::path json, plots;
    PageOptions page;
};

/// The command. Returns the process's exit code.
int compare_recording(const CompareOptions& options);

}  // namespace pierce::app
