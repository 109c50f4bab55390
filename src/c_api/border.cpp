#include "c_api/border.hpp"

#include <cstring>
#include <string_view>

namespace pierce::c {
namespace {

// An array, as a string would have to be allocated where memory may just have run out.
thread_local char last_error[1024] = "";

#define PIERCE_TEXT_OF(x) #x
#define PIERCE_TEXT(x) PIERCE_TEXT_OF(x)
constexpr char version[] = PIERCE_TEXT(PIERCE_VERSION_MAJOR) "." PIERCE_TEXT(
    PIERCE_VERSION_MINOR) "." PIERCE_TEXT(PIERCE_VERSION_PATCH);

}  // namespace

pierce_status failed(pierce_status status, const char* message) noexcept {
    const std::size_t length = strnlen(message, sizeof last_error - 1);
    // The message may be the last one itself.
    std::memmove(last_error, message, length);
    last_error[length] = '\0';
    return status;
}

}  // namespace pierce::c

const char* pierce_last_error(void) { return pierce::c::last_error; }

const char* pierce_version(void) {
    static_assert(std::string_view(pierce::c::version) == PIERCE_PROJECT_VERSION);
    return pierce::c::version;
}
