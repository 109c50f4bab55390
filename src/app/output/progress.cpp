#include "app/output/progress.hpp"

#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include "app/output/terminal.hpp"
#include "app/output/waiting.hpp"

namespace pierce::app {
namespace {

constexpr std::uint32_t bar_width = 30;  // [letters]
constexpr std::chrono::milliseconds between_bars{100};
constexpr std::uint32_t percent = 100;

}  // namespace

std::string minutes_and_seconds(double seconds) {
    const auto whole = std::lround(seconds);
    return fmt::format("{:d}:{:02d}", whole / 60, whole % 60);
}

Progress::Progress(std::string what, std::uint32_t total, bool can_stop)
    : what_(std::move(what)), total_(total), visible_(shows_progress()), begin_(Clock::now()) {
    if (can_stop) delay_.emplace();
}

Progress::~Progress() {
    if (drawn_ != Clock::time_point()) clear_line();
}

void Progress::one_more() {
    const std::lock_guard lock(mutex_);
    draw(++done_);
}

void Progress::show(std::uint32_t done) {
    draw(done);
    if (done < total_ && should_stop()) throw Interrupted(what_, done, total_);
}

void Progress::draw(std::uint32_t done) {
    if (!visible_ || done == 0 || done > total_) return;
    const Clock::time_point now = Clock::now();
    if (now - begin_ < patience_before_bars) return;
    if (now - drawn_ < between_bars && done != total_) return;
    drawn_ = now;
    const auto filled = static_cast<std::uint32_t>(std::uint64_t{bar_width} * done / total_);
    const double elapsed = std::chrono::duration<double>(now - begin_).count();
    fmt::print(stderr, "\r\033[K{} [{:#<{}}{:.<{}}] {}/{}  {} left", what_, "", filled, "",
               bar_width - filled, done, total_,
               minutes_and_seconds(elapsed / done * (total_ - done)));
    std::fflush(stderr);
}

std::function<void(double)> show_share(const std::string& what) {
    return [what, waiting = std::make_shared<Waiting>(what),
            bar = std::shared_ptr<Progress>()](double share) mutable {
        waiting.reset();
        if (!bar) bar = std::make_shared<Progress>(what, percent, false);
        bar->draw(static_cast<std::uint32_t>(share * percent));
    };
}

std::function<void(std::string_view, double)> show_meshes() {
    return [bar = std::shared_ptr<Progress>(), shown = std::string()](std::string_view what,
                                                                      double share) mutable {
        if (!bar || shown != what) {
            bar = std::make_shared<Progress>(fmt::format("meshes, {}", what), percent, false);
            shown = what;
        }
        // Threads that make meshes do not stop in between.
        bar->draw(static_cast<std::uint32_t>(share * percent));
        if (share >= 1) bar.reset();
    };
}

}  // namespace pierce::app
