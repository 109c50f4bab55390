#pragma once

#include <memory>
#include <new>
#include <stdexcept>
#include <string>

namespace pierce {

/// Input that cannot be used. The message names the offending input. Whatever the call was to
/// change stays as it was.
class InputError : public std::invalid_argument {
public:
    using std::invalid_argument::invalid_argument;
};

/// There is no memory left where a library that Pierce uses asked for it, such as on a device.
class OutOfMemory : public std::bad_alloc {
public:
    explicit OutOfMemory(const std::string& what)
        : what_(std::make_shared<const std::string>(what)) {}
    const char* what() const noexcept override { return what_->c_str(); }

private:
    std::shared_ptr<const std::string> what_;  ///< exceptions are copied without throwing
};

}  // namespace pierce
