#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "scenes/files/sheet_truth_file.hpp"
#include "scenes/files/truth_file.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::app {

/// True if the program that makes truths, pierce_truth, was built beside this one.
bool has_truth_program();

/// Throws InputError unless the program that makes truths, pierce_truth, was built beside this one.
void check_truth_program();

/// The truth beside a recording; made by pierce_truth if there is none. Throws InputError if that
/// fails.
std::vector<scenes::TrueFrame> truth_of(const std::filesystem::path& folder, std::uint32_t every,
                                        bool pairs_only = false);

/// The same of a recording that is in no folder.
std::vector<scenes::TrueFrame> truth_of(const scenes::Recording& recording, std::uint32_t every,
                                        bool pairs_only = false);

/// What the sheets of a recording that is in no folder meet, in every frame or every Nth one.
/// Throws InputError if pierce_truth fails.
std::vector<scenes::TrueSheetFrame> sheet_truth_of(const scenes::Recording& recording,
                                                   std::uint32_t every = 1);

}  // namespace pierce::app
