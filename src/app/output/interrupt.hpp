#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

/// Ctrl-C, which is SIGINT, and SIGTERM. The first one ends the program at once unless something
/// delays it: then the work at hand stops where it can, and what is done is written. The second
/// one always ends the program at once.
namespace pierce::app {

/// Work that a signal has stopped.
class Interrupted : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
    /// So many of `total` parts of some work are done.
    Interrupted(const std::string& what, std::uint32_t done, std::uint32_t total);

    std::string missing = "what was asked for is missing";  ///< for people
};

/// Takes over SIGINT and SIGTERM; before, they end the program as they always do.
void catch_interrupts();

/// The exit code of a program that a signal has stopped, as shells have it: 130 for Ctrl-C.
int exit_code_of_signal(int signal);

/// The signal that was delayed; 0: none came.
int delayed_signal();

/// True if a signal was delayed, and nobody has acknowledged it: work stops as soon as it can.
bool should_stop();

/// From now on nothing stops any more for the signal that came: what is done is written.
void acknowledge_stop();

/// While there is one, the first signal is delayed.
class InterruptDelay {
public:
    InterruptDelay();
    ~InterruptDelay();
    InterruptDelay(const InterruptDelay&) = delete;
    InterruptDelay& operator=(const InterruptDelay&) = delete;
};

/// Does some work, and acknowledges the signal that stops it. Returns what was stopped.
template <class Work>
std::optional<Interrupted> until_interrupted(const Work& work) {
    try {
        work();
    } catch (const Interrupted& stop) {
        acknowledge_stop();
        return stop;
    }
    return std::nullopt;
}

}  // namespace pierce::app
