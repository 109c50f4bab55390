#pragma once

#include <filesystem>
#include <string>

namespace pierce::app {

/// Text in gnuplot's quotes.
std::string quoted(const std::string& text);

/// Text for gnuplot's enhanced mode, in which every letter stands for itself. `style`: Bold,
/// Italic, or empty.
std::string styled(const std::string& text, const std::string& style);

/// The lines of a script that send what it draws to a file. Sizes are in pixels.
std::string svg_output(const std::filesystem::path& svg, int width, int height, int font_size);

/// Runs a script. Returns true if gnuplot is installed and has drawn it.
bool run_gnuplot(const std::string& script);

}  // namespace pierce::app
