#include "app/output/interrupt.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <string_view>

namespace pierce::app {
namespace {

// What the handler reads. It may run on any thread.
std::atomic<int> delays = 0, first_signal = 0;
std::atomic<bool> acknowledged = false, on_terminal = false;
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

constexpr int signal_base = 128;  ///< shells add a signal's number to it
constexpr std::string_view clear_line = "\r\033[K";

void say(std::string_view text) {
    if (on_terminal && write(STDERR_FILENO, clear_line.data(), clear_line.size()) < 0) return;
    if (write(STDERR_FILENO, text.data(), text.size()) < 0) return;
}

void on_signal(int signal) {
    const int error = errno;
    int none = 0;
    if (delays > 0 && first_signal.compare_exchange_strong(none, signal)) {
        say("pierce: stopping where it can; once more ends it at once\n");
        errno = error;
        return;
    }
    say(first_signal != 0 ? "pierce: ended at once; files that are not written yet are missing\n"
                          : "pierce: stopped; files that are not written yet are missing\n");
    _exit(signal_base + signal);
}

}  // namespace

Interrupted::Interrupted(const std::string& what, std::uint32_t done, std::uint32_t total)
    : std::runtime_error(fmt::format("stopped after {} of {} ({})", done, total, what)) {}

void catch_interrupts() {
    on_terminal = isatty(STDERR_FILENO) != 0;
    struct sigaction action = {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    for (int signal : {SIGINT, SIGTERM}) {
        struct sigaction before = {};
        sigaction(signal, nullptr, &before);
        // What runs in the background of a script ignores Ctrl-C.
        if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
    }
}

int exit_code_of_signal(int signal) { return signal_base + signal; }

int delayed_signal() { return first_signal; }

bool should_stop() { return first_signal != 0 && !acknowledged; }

void acknowledge_stop() { acknowledged = true; }

InterruptDelay::InterruptDelay() { ++delays; }
InterruptDelay::~InterruptDelay() { --delays; }

}  // namespace pierce::app
