#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "app/output/interrupt.hpp"

namespace pierce::app {

/// For so long work shows nothing: what is short does not flicker.
inline constexpr std::chrono::milliseconds patience_before_bars{500};

/// Time as people read it, in minutes and seconds.
std::string minutes_and_seconds(double seconds);

/// A bar with the time left on the terminal's last line; silent if shows_progress() is false.
/// Signals are delayed while there is one that can stop.
class Progress {
public:
    /// `can_stop`: show() is called, not draw() alone.
    Progress(std::string what, std::uint32_t total, bool can_stop = true);
    ~Progress();

    /// `done` of the total are done. Redraws a few times a second at most. Throws Interrupted if
    /// there is more to do, and it should stop.
    void show(std::uint32_t done);
    /// The same for work that does not stop, from one thread at a time.
    void draw(std::uint32_t done);
    /// One more is done; may be called from any thread.
    void one_more();

private:
    using Clock = std::chrono::steady_clock;

    std::optional<InterruptDelay> delay_;
    std::string what_;
    std::uint32_t total_;
    bool visible_;
    Clock::time_point begin_, drawn_;
    std::mutex mutex_;
    std::uint32_t done_ = 0;
};

/// Shows a bar of work that tells its share, from 0 to 1, and does not stop. Until it first does,
/// says what is going on.
std::function<void(double share)> show_share(const std::string& what);

/// Shows a bar of what is being made of meshes, for MeshOptions::progress.
std::function<void(std::string_view what, double share)> show_meshes();

}  // namespace pierce::app
