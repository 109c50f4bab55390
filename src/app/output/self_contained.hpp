#pragma once

#include <filesystem>
#include <string>

namespace pierce::app {

/// A page in Markdown as one HTML file that asks for no other: pictures that it shows from `folder`
/// are inside of it. Throws InputError if a picture cannot be read.
std::string self_contained_html(const std::string& title, const std::string& markdown,
                                const std::filesystem::path& folder);

}  // namespace pierce::app
