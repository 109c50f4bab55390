#include "app/output/waiting.hpp"

#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include "app/output/progress.hpp"
#include "app/output/terminal.hpp"

namespace pierce::app {

namespace {

constexpr std::chrono::milliseconds between_lines{500};

}  // namespace

Waiting::Waiting(std::string what) : what_(std::move(what)) {
    if (shows_progress())
        drawing_ = std::jthread([this](const std::stop_token& stop) { draw_until(stop); });
}

Waiting::~Waiting() = default;

void Waiting::draw_until(const std::stop_token& stop) const {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point begin = Clock::now();
    std::unique_lock lock(mutex_);
    bool drawn = false;
    for (auto pause = patience_before_bars; !stop.stop_requested(); pause = between_lines) {
        stopped_.wait_for(lock, stop, pause, [] { return false; });
        if (stop.stop_requested()) break;
        const double elapsed = std::chrono::duration<double>(Clock::now() - begin).count();
        fmt::print(stderr, "\r\033[K{}, {}", what_, minutes_and_seconds(std::floor(elapsed)));
        std::fflush(stderr);
        drawn = true;
    }
    if (drawn) clear_line();
}

}  // namespace pierce::app
