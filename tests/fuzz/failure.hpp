#pragma once

#include <optional>
#include <string>

namespace pierce::fuzz {

/// What is wrong with a world.
struct Failure {
    std::string kind;  ///< the promise that was broken, in a few words: the same for all programs
                       ///< that break it
    std::string text;  ///< all that is known
};

}  // namespace pierce::fuzz
