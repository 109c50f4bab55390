#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace pierce::app {

/// Files are there as a whole or not at all. Throws InputError if the file cannot be written.
void write_json_file(const std::filesystem::path& file, const nlohmann::json& content);
void write_text_file(const std::filesystem::path& file, const std::string& text);

/// Throws InputError if a file that is to be written at the end, empty for none, cannot be: a long
/// run shall not end so.
void check_writable(const std::filesystem::path& file);
/// Throws InputError if two files that are to be written, empty for none, are the same one.
void check_different(const std::vector<std::filesystem::path>& files);
/// check_writable() for a recording's folder, which is made.
void check_folder_writable(const std::filesystem::path& folder);

}  // namespace pierce::app
