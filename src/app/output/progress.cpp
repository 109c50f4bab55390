#include "app/output/progress.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <cmath>
#include <memory>
#include <utility>

namespace pierce::app {

Progress::Progress(std::string what, std::uint32_t total)
    : what_(std::move(what)),
      total_(total),
      visible_(isatty(STDERR_FILENO) != 0),
      begin_(Clock::now()) {}

Progress::~Progress() {
    if (visible_) fmt::print(stderr, "\r\033[K");
}

void Progress::one_more() {
    const std::lock_guard lock(mutex_);
    show(++done_);
}

void Progress::show(std::uint32_t done) {
    using namespace std::chrono_literals;
    if (!visible_ || done == 0) return;
    const Clock::time_point now = Clock::now();
    if (now - drawn_ < 100ms && done != total_) return;
    drawn_ = now;
    constexpr std::uint32_t width = 30;
    const auto filled = static_cast<std::uint32_t>(std::uint64_t{width} * done / total_);
    const double elapsed = std::chrono::duration<double>(now - begin_).count();
    const auto left = std::lround(elapsed / done * (total_ - done));
    fmt::print(stderr, "\r\033[K{} [{:#<{}}{:.<{}}] {}/{}  {:d}:{:02d} left", what_, "", filled, "",
               width - filled, done, total_, left / 60, left % 60);
    std::fflush(stderr);
}

namespace {

constexpr std::uint32_t all_of_mesh = 100;  ///< percent

}  // namespace

std::function<void(std::string_view, double)> show_meshes() {
    return [bar = std::shared_ptr<Progress>(), shown = std::string()](std::string_view what,
                                                                      double share) mutable {
        if (!bar || shown != what) {
            bar = std::make_shared<Progress>(fmt::format("meshes, {}", what), all_of_mesh);
            shown = what;
        }
        bar->show(static_cast<std::uint32_t>(share * all_of_mesh));
        if (share >= 1) bar.reset();
    };
}

}  // namespace pierce::app
