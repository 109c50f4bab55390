#include "app/output/child.hpp"

#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "app/output/interrupt.hpp"

namespace pierce::app {

namespace {

constexpr std::chrono::milliseconds between_looks{5};
/// After a signal has ended a child, this program has got the same one by then, if it came from a
/// terminal.
constexpr std::chrono::milliseconds until_signals_arrive{50};

}  // namespace

int wait_for(pid_t child, const std::string& what) {
    const InterruptDelay delay;
    int status = 0;
    for (pid_t ended = 0; (ended = waitpid(child, &status, WNOHANG)) != child;) {
        if (ended < 0) return -1;
        if (should_stop()) {
            kill(child, SIGTERM);
            waitpid(child, &status, 0);
            break;
        }
        std::this_thread::sleep_for(between_looks);
    }
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGINT || WTERMSIG(status) == SIGTERM))
        std::this_thread::sleep_for(until_signals_arrive);
    if (should_stop()) throw Interrupted("stopped while " + what);
    return status;
}

}  // namespace pierce::app
