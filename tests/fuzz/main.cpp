// Plays random programs on worlds of all backends and says which break a promise.
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <ranges>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "fuzz/generator.hpp"
#include "fuzz/sandbox.hpp"
#include "fuzz/shrink.hpp"

namespace pierce::fuzz {
namespace {

struct Options {
    std::uint64_t seed = 1;
    std::uint64_t worlds = 0;
    double seconds = 60;
    unsigned jobs = 1;
    unsigned shrinks = 3;
    std::string out;
    std::vector<std::string> backends;
    std::vector<std::string> replay;
    bool show = false;
};

/// What a worker tells the process that watches it, in memory that both have.
struct Desk {
    std::uint64_t seed = 0;  ///< in work
    JudgeCounts counts;
    bool done = false;
};

Program program_of_seed(std::uint64_t seed) {
    const std::vector<std::uint8_t> bytes = bytes_of(seed);
    Choices choices(bytes);
    return random_program(choices);
}

/// Does not look for a device: CUDA cannot be used in the children of a process that has used it.
std::vector<std::string> names_of_backends() {
    std::vector<std::string> names;
    for (const test::NamedBackend& backend : test::known_backends()) names.push_back(backend.name);
    return names;
}

std::vector<test::NamedBackend> chosen_backends(const std::vector<std::string>& names) {
    std::vector<test::NamedBackend> chosen;
    for (test::NamedBackend& backend : test::backends())
        if (names.empty() || std::ranges::count(names, backend.name) > 0)
            chosen.push_back(std::move(backend));
    return chosen;
}

/// One of several processes that share the seeds out.
class Worker {
public:
    Worker(const Options& options, const Backends& backends, Desk& desk, int log)
        : options_(options), backends_(backends()), desk_(desk), log_(log) {}

    /// Goes on after the seed on the desk.
    [[noreturn]] void run(std::chrono::steady_clock::time_point end) {
        for (;; desk_.seed += options_.jobs) {
            const bool over = options_.worlds > 0 ? desk_.seed >= options_.seed + options_.worlds
                                                  : std::chrono::steady_clock::now() >= end;
            if (over) break;
            alarm(longest_world);
            if (const auto failure = judge(program_of_seed(desk_.seed), backends_, desk_.counts)) {
                std::string line = fmt::format("{}\t{}\t{}", desk_.seed, failure->kind,
                                               failure->text);
                std::ranges::replace(line, '\n', ' ');
                line += '\n';
                [[maybe_unused]] const ssize_t n = write(log_, line.data(), line.size());
            }
        }
        desk_.done = true;
        _exit(0);
    }

private:
    const Options& options_;
    std::vector<test::NamedBackend> backends_;
    Desk& desk_;
    int log_;
};

class Watch {
public:
    explicit Watch(const Options& options)
        : options_(options), backends_([&options] { return chosen_backends(options.backends); }) {}

    int run() {
        if (!can_run()) {
            fmt::print(stderr, "pierce_fuzz: a backend of these cannot run here\n");
            return 2;
        }
        if (!options_.replay.empty()) return replay();
        if (options_.show) {
            fmt::print("{}", to_text(program_of_seed(options_.seed)));
            return 0;
        }
        search();
        report();
        return failures_.empty() ? 0 : 1;
    }

private:
    /// True if all backends that were asked for can run. A process of its own looks for a device.
    bool can_run() const {
        const pid_t child = fork();
        if (child < 0) throw std::runtime_error("no process");
        if (child == 0) _exit(backends_().size() < options_.backends.size() ? 1 : 0);
        int status = 0;
        waitpid(child, &status, 0);
        return status == 0;
    }

    int replay() {
        int failed = 0;
        for (const std::string& path : options_.replay) {
            std::ifstream file(path);
            const std::string text{std::istreambuf_iterator<char>(file), {}};
            const auto failure = judge_apart(program_of(text), backends_);
            fmt::print("{}: {}\n", path, failure ? failure->kind + "\n" + failure->text : "holds");
            failed += failure.has_value();
        }
        return failed > 0;
    }

    void search() {
        const auto begin = std::chrono::steady_clock::now();
        const auto end = begin + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                     std::chrono::duration<double>(options_.seconds));
        // Processes append to one file, whose place they share.
        std::FILE* const log = std::tmpfile();
        if (log == nullptr) throw std::runtime_error("no temporary file");
        void* shared = mmap(nullptr, options_.jobs * sizeof(Desk), PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (shared == MAP_FAILED) throw std::runtime_error("no memory to share");
        desks_ = static_cast<Desk*>(shared);
        std::map<pid_t, unsigned> running;
        const auto start = [&](unsigned w) {
            std::fflush(stdout);
            const pid_t child = fork();
            if (child < 0) throw std::runtime_error("no process");
            if (child == 0) {
                Worker(options_, backends_, desks_[w], fileno(log)).run(end);
            }
            running[child] = w;
        };
        for (unsigned w = 0; w < options_.jobs; ++w) {
            new (&desks_[w]) Desk;
            desks_[w].seed = options_.seed + w;
            start(w);
        }
        while (!running.empty()) {
            int status = 0;
            const pid_t child = waitpid(-1, &status, 0);
            const auto at = running.find(child);
            if (at == running.end()) continue;
            const unsigned w = at->second;
            running.erase(at);
            if (desks_[w].done) continue;
            const std::string kind = WIFSIGNALED(status)
                                         ? name_of_signal(WTERMSIG(status))
                                         : fmt::format("crash: exit {}", WEXITSTATUS(status));
            found(desks_[w].seed, kind, "");
            desks_[w].seed += options_.jobs;
            start(w);
        }
        read_log(log);
        for (unsigned w = 0; w < options_.jobs; ++w) counts_ += desks_[w].counts;
        seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }

    void read_log(std::FILE* log) {
        std::string lines;
        char buffer[4096];
        std::rewind(log);
        for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, log)) > 0;)
            lines.append(buffer, n);
        std::fclose(log);
        std::istringstream in(lines);
        for (std::string seed, kind, text; std::getline(in, seed, '\t') &&
                                           std::getline(in, kind, '\t') && std::getline(in, text);)
            found(std::stoull(seed), kind, text);
    }

    /// `text`: of a failure that does not end its process.
    void found(std::uint64_t seed, const std::string& kind, const std::string& text) {
        failures_[kind].emplace(seed, text);
    }

    void report() {
        const OracleCounts& o = counts_.oracle;
        fmt::print(
            "{} worlds from seed {}, {:.0f} s: {} calls ({} refused), {} steps, {} contacts; {} "
            "pairs that overlap and {} "
            "that do "
            "not, {} starts and {} ways inside, {} contacts by definition, {} meetings of sheets, "
            "{} exact questions about "
            "others\n",
            counts_.worlds, options_.seed, seconds_, counts_.calls, counts_.refused, counts_.steps,
            counts_.contacts, o.overlapping_pairs, o.apart_pairs, o.inside_vertices, o.segments,
            o.expected_contacts, o.feature_meetings, o.feature_questions);
        for (const auto& [kind, seeds] : failures_) {
            fmt::print("FAILED {} times: {}; seeds", seeds.size(), kind);
            for (const auto& [seed, text] : seeds | std::views::take(most_seeds))
                fmt::print(" {}", seed);
            fmt::print("\nthe first: {}\n", seeds.begin()->second);
        }
        std::fflush(stdout);  // finding small programs may take long
        if (options_.out.empty()) return;
        std::filesystem::create_directories(options_.out);
        for (const auto& [kind, seeds] : failures_)
            for (const auto& [seed, text] : seeds | std::views::take(options_.shrinks))
                keep(kind, seed);
    }

    /// Writes a small program that fails likewise.
    void keep(const std::string& kind, std::uint64_t seed) {
        const auto fails = [&](const Program& p) {
            const auto failure = judge_apart(p, backends_);
            return failure && failure->kind == kind;
        };
        const Program program = shrunk(program_of_seed(seed), fails);
        std::string name = kind;
        for (char& c : name)
            if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
        const std::string path = fmt::format("{}/{}-{}.json", options_.out, name.substr(0, 60),
                                             seed);
        std::ofstream(path) << to_text(program);
        const auto failure = judge_apart(program, backends_);
        fmt::print("{}: {} calls\n{}\n", path, program.calls.size(),
                   failure ? failure->text : "does not fail again");
        std::fflush(stdout);
    }

    static constexpr std::ptrdiff_t most_seeds = 10;  ///< that are printed of a kind

    const Options& options_;
    Backends backends_;
    Desk* desks_ = nullptr;
    JudgeCounts counts_;
    double seconds_ = 0;
    /// By kind and seed, what was wrong.
    std::map<std::string, std::map<std::uint64_t, std::string>> failures_;
};

}  // namespace
}  // namespace pierce::fuzz

int main(int argc, char** argv) {
    pierce::fuzz::Options options;
    CLI::App app{"Random worlds against the reference, fresh worlds, invariants and exact truth"};
    app.add_option("--seed", options.seed, "first seed");
    app.add_option("--worlds", options.worlds, "how many; 0: as many as there is time for");
    app.add_option("--seconds", options.seconds, "time");
    app.add_option("--jobs", options.jobs, "processes")->check(CLI::PositiveNumber);
    app.add_option("--out", options.out, "folder for small programs that fail");
    app.add_option("--shrinks", options.shrinks, "how many of them per kind of failure");
    app.add_option("--backends", options.backends, "names, separated by commas; all if none")
        ->delimiter(',')
        ->check(CLI::IsMember(pierce::fuzz::names_of_backends()));
    app.add_option("--replay", options.replay, "programs to play")->check(CLI::ExistingFile);
    app.add_flag("--show", options.show, "print the program of the first seed");
    CLI11_PARSE(app, argc, argv);
    return pierce::fuzz::Watch(options).run();
}
