#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace pierce::app {

/// A bar with the time left on the terminal's last line; silent if standard error is no terminal.
class Progress {
public:
    Progress(std::string what, std::uint32_t total);
    ~Progress();

    /// `done` of the total are done. Redraws a few times a second at most.
    void show(std::uint32_t done);
    /// One more is done; may be called from any thread.
    void one_more();

private:
    using Clock = std::chrono::steady_clock;

    std::string what_;
    std::uint32_t total_;
    bool visible_;
    Clock::time_point begin_, drawn_;
    std::mutex mutex_;
    std::uint32_t done_ = 0;
};

/// Shows a bar of what is being made of meshes, for MeshOptions::progress.
std::function<void(std::string_view what, double share)> show_meshes();

}  // namespace pierce::app
