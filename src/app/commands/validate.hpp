#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/commands.hpp"
#include "pierce/settings.hpp"

namespace pierce::app {

struct ValidateOptions {
    std::string input;                   ///< a scene's name, or a recording's folder
    std::optional<std::uint32_t> count;  ///< this and the next two: of a scene
    bool soft = false;
    std::optional<double> seconds;
    std::uint32_t every = 1;
    std::vector<std::string> backends;  ///< empty: all that can run here
    std::vector<std::string> modes = {"full", "walk", "walk-predict", "certified"};  ///< what rays
                                                                                     ///< remember
    Settings world;
    std::filesystem::path json;  ///< empty: none
    PageOptions page;
};

/// Gives the same frames to several backends, in each mode. Returns 0 if all of them find the same
/// contacts, bit for bit, and 1 otherwise.
int validate(const ValidateOptions& options);

}  // namespace pierce::app
