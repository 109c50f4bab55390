#include "app/output/terminal.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace pierce::app {

bool is_quiet() {
    const char* value = std::getenv(quiet_variable);
    return value != nullptr && *value != 0 && std::string_view(value) != "0";
}

void be_quiet() {
    setenv(quiet_variable, "1", 1);
    // Not by freopen(): what is written to the file /dev/stdout shall arrive.
    if (std::FILE* nowhere = std::fopen("/dev/null", "w")) stdout = nowhere;
}

bool shows_progress() {
    const char* terminal = std::getenv("TERM");
    const bool is_dumb = terminal != nullptr && std::string_view(terminal) == "dumb";
    return isatty(STDERR_FILENO) != 0 && !is_dumb && !is_quiet();
}

void clear_line() {
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
}

}  // namespace pierce::app
