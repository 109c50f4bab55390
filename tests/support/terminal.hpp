#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>

namespace pierce::test {

/// The pierce command on a terminal of its own, in a folder.
class OnTerminal {
public:
    OnTerminal(const std::string& arguments, const std::string& folder) {
        child_ = forkpty(&terminal_, nullptr, nullptr, nullptr);
        if (child_ != 0) return;
        const std::string line = "cd '" + folder + "' && TERM=xterm exec " + PIERCE_APP + " " +
                                 arguments;
        execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
        _exit(127);
    }
    ~OnTerminal() {
        if (code_ < 0) {
            kill(child_, SIGKILL);
            waitpid(child_, nullptr, 0);
        }
        close(terminal_);
    }
    OnTerminal(const OnTerminal&) = delete;
    OnTerminal& operator=(const OnTerminal&) = delete;

    /// Waits until the command has printed `what`; false if it ends before.
    bool wait_for(const std::string& what) {
        while (text_.find(what) == std::string::npos)
            if (!read_some()) return false;
        return true;
    }
    void press_ctrl_c() const { EXPECT_EQ(write(terminal_, "\x03", 1), 1); }
    void send(int signal) const { EXPECT_EQ(kill(child_, signal), 0); }
    /// Waits until the command ends. Returns its exit code; -1 if a signal has ended it.
    int end() {
        while (read_some()) {
        }
        int status = 0;
        waitpid(child_, &status, 0);
        return code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    /// All that was printed until now.
    const std::string& text() const { return text_; }

private:
    bool read_some() {
        if (std::chrono::steady_clock::now() > deadline_) {
            kill(child_, SIGKILL);
            ADD_FAILURE() << "it takes too long; until now: " << text_;
            return false;
        }
        pollfd readable{.fd = terminal_, .events = POLLIN, .revents = 0};
        if (poll(&readable, 1, milliseconds_between_looks) == 0) return true;
        char buffer[4096];
        const ssize_t n = read(terminal_, buffer, sizeof buffer);
        if (n > 0) text_.append(buffer, static_cast<std::size_t>(n));
        return n > 0;
    }

    static constexpr int milliseconds_between_looks = 100;
    static constexpr std::chrono::seconds most{60};

    std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::now() + most;
    int terminal_ = -1, code_ = -1;
    pid_t child_ = -1;
    std::string text_;
};

}  // namespace pierce::test
