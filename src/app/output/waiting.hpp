#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace pierce::app {

/// For work whose length nobody knows: the terminal's last line says what is going on, and for how
/// long, once it has taken a while. Silent if shows_progress() is false.
class Waiting {
public:
    explicit Waiting(std::string what);
    ~Waiting();
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;

private:
    void draw_until(const std::stop_token& stop) const;

    std::string what_;
    mutable std::mutex mutex_;
    mutable std::condition_variable_any stopped_;
    std::jthread drawing_;
};

}  // namespace pierce::app
