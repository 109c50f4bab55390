#pragma once

#include <string>
#include <string_view>

namespace pierce::page {

/// Bytes as text that may stand in a page.
std::string base64(std::string_view bytes);

}  // namespace pierce::page
