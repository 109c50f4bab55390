// Hands spoiled files to everything that reads files: each must be taken or refused, in bounded
// time and memory.
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <map>
#include <set>
#include <stdexcept>

#include "fuzz/hostile_files.hpp"
#include "fuzz/sandbox.hpp"

namespace pierce::fuzz {
namespace {

constexpr std::size_t readers = static_cast<std::size_t>(Reader::count);

/// A file takes no longer than this [s], nor more memory [bytes].
constexpr unsigned longest_file = 10;
constexpr rlim_t most_memory = rlim_t{4} << 30;

/// What the process that reads tells the one that watches it.
struct Desk {
    std::uint64_t seed = 0;
    std::uint64_t taken[readers] = {}, refused[readers] = {};
    bool done = false;
};

Reader reader_of(std::uint64_t seed) { return static_cast<Reader>(seed % readers); }

std::string file_of(std::uint64_t seed) {
    const std::string sound = sound_file(reader_of(seed), seed / readers);
    return seed / readers % 16 == 0 ? sound : spoiled(sound, seed);
}

[[noreturn]] void work(Desk& desk, std::uint64_t end, std::chrono::steady_clock::time_point until,
                       bool limits_memory) {
    if (limits_memory) {
        const rlimit limit{most_memory, most_memory};
        setrlimit(RLIMIT_AS, &limit);
    }
    for (; desk.seed < end && std::chrono::steady_clock::now() < until; ++desk.seed) {
        alarm(longest_file);
        const Reader reader = reader_of(desk.seed);
        // An exception that is not InputError ends the process, and is a failure.
        ++(read(reader, file_of(desk.seed)) ? desk.taken
                                            : desk.refused)[static_cast<std::size_t>(reader)];
    }
    desk.done = true;
    exit(0);
}

int run(std::uint64_t seed, std::uint64_t files, double seconds, bool limits_memory) {
    void* shared = mmap(nullptr, sizeof(Desk), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS,
                        -1, 0);
    if (shared == MAP_FAILED) throw std::runtime_error("no memory to share");
    Desk& desk = *new (shared) Desk;
    desk.seed = seed;
    const std::uint64_t end = files > 0 ? seed + files : ~std::uint64_t{0};
    const auto until = std::chrono::steady_clock::now() +
                       std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                           std::chrono::duration<double>(files > 0 ? 1e6 : seconds));
    std::map<std::string, std::set<std::uint64_t>> failures;
    while (!desk.done) {
        std::fflush(stdout);
        const pid_t child = fork();
        if (child < 0) throw std::runtime_error("no process");
        if (child == 0) work(desk, end, until, limits_memory);
        int status = 0;
        waitpid(child, &status, 0);
        if (desk.done) break;
        const std::string how = WIFSIGNALED(status)
                                    ? name_of_signal(WTERMSIG(status))
                                    : fmt::format("crash: exit {}", WEXITSTATUS(status));
        failures[std::string(name_of(reader_of(desk.seed))) + ": " + how].insert(desk.seed);
        ++desk.seed;
    }
    for (std::size_t r = 0; r < readers; ++r)
        fmt::print("{}: {} taken, {} refused\n", name_of(static_cast<Reader>(r)), desk.taken[r],
                   desk.refused[r]);
    for (const auto& [how, seeds] : failures) {
        fmt::print("FAILED {} times: {}; seeds", seeds.size(), how);
        std::size_t left = 10;
        for (std::uint64_t s : seeds)
            if (left-- > 0) fmt::print(" {}", s);
        fmt::print("\n");
    }
    return failures.empty() ? 0 : 1;
}

}  // namespace
}  // namespace pierce::fuzz

int main(int argc, char** argv) {
    std::uint64_t seed = 1, files = 0;
    double seconds = 20;
    bool show = false, limits_memory = true;
    CLI::App app{"Spoiled files for every reader"};
    app.add_option("--seed", seed, "first seed");
    app.add_option("--files", files, "how many; 0: as many as there is time for");
    app.add_option("--seconds", seconds, "time");
    app.add_option("--limit-memory", limits_memory,
                   "off under a sanitizer, which reserves more than there is");
    app.add_flag("--show", show, "print the first seed's file");
    CLI11_PARSE(app, argc, argv);
    if (show) {
        fmt::print("{}", pierce::fuzz::file_of(seed));
        return 0;
    }
    return pierce::fuzz::run(seed, files, seconds, limits_memory);
}
