#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "scenes/files/sheet_truth_file.hpp"
#include "scenes/files/truth_file.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::app {

/// True if the program that makes truths, pierce_truth, was built beside this one.
bool has_truth_program();

/// Throws InputError unless the program that makes truths, pierce_truth, was built beside this one.
void check_truth_program();

inline constexpr std::uint32_t usual_truth = 4;  ///< every such frame, unless another is asked for

/// The truth beside a recording, for every Nth frame; made by pierce_truth unless it is there for
/// these frames. Without `every`, what is there, or every fourth frame. Throws InputError if making
/// it fails.
std::vector<scenes::TrueFrame> truth_of(const std::filesystem::path& folder,
                                        std::optional<std::uint32_t> every,
                                        bool pairs_only = false);

/// Every which frame a truth of several frames has.
std::uint32_t sampling_of(const std::vector<scenes::TrueFrame>& truth);

/// The same of a recording that is in no folder.
std::vector<scenes::TrueFrame> truth_of(const scenes::Recording& recording, std::uint32_t every,
                                        bool pairs_only = false);

/// What the sheets of a recording that is in no folder meet, in every frame or every Nth one.
/// Throws InputError if pierce_truth fails.
std::vector<scenes::TrueSheetFrame> sheet_truth_of(const scenes::Recording& recording,
                                                   std::uint32_t every = 1);

}  // namespace pierce::app
