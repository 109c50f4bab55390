#pragma once

#include <span>
#include <string>

namespace pierce::app {

/// How a compared method looks in every plot.
struct MethodLook {
    const char* name;
    const char* colour;  ///< as #rrggbb
    bool ours;           ///< false: of another library
};

std::span<const MethodLook> method_looks();

/// Throws InputError for a method without one.
const MethodLook& look_of_method(const std::string& name);

}  // namespace pierce::app
