#include "fuzz/sandbox.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <stdexcept>

namespace pierce::fuzz {

std::string name_of_signal(int signal) {
    return signal == SIGALRM ? "a world takes too long"
                             : std::string("crash: ") + strsignal(signal);
}

std::optional<Failure> judge_apart(const Program& program, const Backends& backends) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("no process");
    if (child == 0) {
        close(ends[0]);
        alarm(longest_world);
        JudgeCounts counts;
        const std::optional<Failure> failure = judge(program, backends(), counts);
        const std::string text = failure ? failure->kind + '\0' + failure->text : "";
        for (std::size_t at = 0; at < text.size();) {
            const ssize_t n = write(ends[1], text.data() + at, text.size() - at);
            if (n <= 0) break;
            at += static_cast<std::size_t>(n);
        }
        _exit(0);
    }
    close(ends[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
        text.append(buffer, static_cast<std::size_t>(n));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) return Failure{name_of_signal(WTERMSIG(status)), ""};
    if (WEXITSTATUS(status) != 0)
        return Failure{"crash: exit " + std::to_string(WEXITSTATUS(status)), ""};
    if (text.empty()) return std::nullopt;
    const std::size_t end = text.find('\0');
    return Failure{text.substr(0, end), text.substr(end + 1)};
}

}  // namespace pierce::fuzz
