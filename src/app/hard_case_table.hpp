#pragma once

#include <filesystem>

#include "page.hpp"

namespace pierce::app {

/// The hard cases, their exact answers, and what each method answers; also as hard_cases.csv in the folder.
void hard_case_table(const std::filesystem::path& folder, Page& page);

}  // namespace pierce::app
