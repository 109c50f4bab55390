#include "app/output/draw_plots.hpp"

#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>

#include "app/output/child.hpp"
#include "app/output/plot_scripts.hpp"
#include "app/output/waiting.hpp"

namespace pierce::app {
namespace {

/// With which code draw_plots.py ends where matplotlib is missing.
constexpr int no_matplotlib = 3;

/// Runs draw_plots.py with plot_looks.py, which it imports.
constexpr const char* start = R"(
import sys, types
looks = sys.modules["plot_looks"] = types.ModuleType("plot_looks")
exec(sys.argv[1], looks.__dict__)
exec(sys.argv[2])
)";

/// Runs the script in a Python, which reads `input`; nothing is imported from the current folder.
/// Returns the exit code, and none if there is no such program.
std::optional<int> run_script(const std::string& python, std::FILE* input) {
    std::rewind(input);
    const char* arguments[] = {python.c_str(), "-P",          "-X",          "utf8", "-c",
                               start,          plot_looks_py, draw_plots_py, nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, fileno(input), STDIN_FILENO);
    pid_t child = 0;
    const int failed = posix_spawnp(&child, python.c_str(), &actions, nullptr,
                                    const_cast<char**>(arguments), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) return std::nullopt;
    const int status = wait_for(child, "drawing plots");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

std::vector<std::string> drawing_pythons() {
    const char* named = std::getenv("PIERCE_PYTHON");
    if (named != nullptr && *named != 0) return {named};
    return {"python3", "/usr/bin/python3"};
}

namespace {

std::string draw(std::span<const std::string> descriptions) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> input(std::tmpfile(), std::fclose);
    if (input == nullptr) return "there is no room for a temporary file";
    for (std::size_t i = 0; i < descriptions.size(); ++i) {
        std::fputs(i == 0 ? "[" : ",", input.get());
        std::fputs(descriptions[i].c_str(), input.get());
    }
    std::fputs(descriptions.empty() ? "[]" : "]", input.get());
    if (std::fflush(input.get()) != 0) return "there is no room for a temporary file";
    for (const std::string& python : drawing_pythons()) {
        const std::optional<int> code = run_script(python, input.get());
        if (code == 0) return "";
        if (code && *code != no_matplotlib) return "Python could not draw it";
    }
    return "matplotlib is not installed";
}

}  // namespace

std::string drawing_problem() { return draw({}); }

std::string draw_plots(std::span<const std::string> descriptions) {
    if (descriptions.empty()) return "";
    const Waiting waiting(fmt::format("drawing {} plots", descriptions.size()));
    return draw(descriptions);
}

}  // namespace pierce::app
