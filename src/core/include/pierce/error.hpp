#pragma once

#include <stdexcept>
#include <string>

namespace pierce {

/// Input that cannot be used. The message names the offending input. Whatever the call was to
/// change stays as it was.
class InputError : public std::invalid_argument {
public:
    using std::invalid_argument::invalid_argument;
};

}  // namespace pierce
