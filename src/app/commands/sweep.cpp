#include "app/commands/sweep.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "app/commands/sweep_plan.hpp"
#include "app/output/child.hpp"
#include "app/output/json_file.hpp"
#include "app/output/progress.hpp"
#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Runs this program with its output in a file. Returns true if it has done its work.
bool run_pierce(std::vector<std::string> arguments, const fs::path& log) {
    arguments.insert(arguments.begin(), fs::read_symlink("/proc/self/exe").string());
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(),
                                     O_WRONLY | O_CREAT | O_APPEND, 0644);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    pid_t child = 0;
    const int failed = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) return false;
    const int status = wait_for(child, "running the sweep");
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// One run, and the comparison on its motion. What is there already is not made again.
bool run_one(const Sweep& sweep, const SweepRun& run) {
    fs::create_directories(run.folder);
    const fs::path log = run.folder / "log.txt";
    if (!sweep.has_run(run)) {
        std::vector<std::string> arguments = run.arguments;
        arguments.insert(arguments.end(), {"--json", run.result().string()});
        if (sweep.compares) arguments.insert(arguments.end(), {"--record", run.motion().string()});
        fs::remove(run.done());
        if (!run_pierce(arguments, log)) return false;
        write_json_file(run.done(), sweep.done_by(run, false));
    }
    if (sweep.is_done(run)) return true;
    // Another comparison may have made the truth of other frames.
    if (sweep.has_compared(run)) fs::remove(run.motion() / "truth.json");
    std::vector<std::string> arguments{"compare", run.motion().string(), "--json",
                                       run.comparison().string()};
    arguments.insert(arguments.end(), sweep.compare.begin(), sweep.compare.end());
    if (!run_pierce(arguments, log)) return false;
    write_json_file(run.done(), sweep.done_by(run, true));
    return true;
}

/// Runs on several threads, each of which waits for its process. Returns those that failed.
std::vector<std::uint32_t> run_all(const Sweep& sweep, std::span<const SweepRun* const> missing,
                                   std::uint32_t jobs) {
    std::vector<std::uint32_t> failed;
    std::atomic<std::uint32_t> next{0};
    std::uint32_t done = 0;
    std::mutex mutex;
    Progress progress("sweeping", static_cast<std::uint32_t>(missing.size()));
    std::atomic<bool> stop{false};
    const auto work = [&] {
        for (std::uint32_t k = 0; !stop && (k = next++) < missing.size();) {
            bool good = false;
            try {
                good = run_one(sweep, *missing[k]);
            } catch (const Interrupted&) {
                stop = true;
                break;
            } catch (const std::exception& error) {
                fmt::print(stderr, "pierce: run {}: {}\n", missing[k]->number, error.what());
            }
            const std::lock_guard lock(mutex);
            if (!good) failed.push_back(missing[k]->number);
            progress.draw(++done);
        }
    };
    {
        std::vector<std::jthread> threads;
        for (std::size_t j = 0; j < std::min<std::size_t>(jobs, missing.size()); ++j)
            threads.emplace_back(work);
    }
    if (stop) throw Interrupted("sweeping", done, static_cast<std::uint32_t>(missing.size()));
    std::ranges::sort(failed);
    return failed;
}

std::string cell(const json& value) {
    std::string text = value.is_string() ? value.get<std::string>()
                       : value.is_null() ? std::string()
                                         : value.dump();
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

/// Numbers of a result under names like "ms.total.median", without what differs from frame to
/// frame.
void flatten(const json& value, const std::string& name, json& row) {
    if (value.is_object())
        for (const auto& [key, part] : value.items())
            flatten(part, name.empty() ? key : name + '.' + key, row);
    else if (value.is_primitive())
        row[name] = value;
}

/// The rows of a run: one, or one for each method or mode that it compares.
std::vector<json> rows_of(const Sweep& sweep, const SweepRun& run) {
    std::vector<json> rows;
    const auto read = [](const fs::path& file) {
        try {
            return json::parse(std::ifstream(file));
        } catch (const json::exception& error) {
            throw InputError("'" + file.string() + "' is damaged: " + error.what());
        }
    };
    const json result = read(sweep.compares ? run.comparison() : run.result());
    for (const char* list : {"methods", "modes"})
        for (const json& part : result.value(list, json::array()))
            flatten(part, "", rows.emplace_back());
    if (rows.empty()) flatten(result.value("summary", json::object()), "", rows.emplace_back());
    return rows;
}

/// Writes table.csv of the runs that are done. Returns how many there are.
std::size_t gather(const Sweep& sweep, const fs::path& file) {
    std::vector<std::pair<const SweepRun*, json>> rows;
    std::vector<std::string> columns;
    std::size_t done = 0;
    for (const SweepRun& run : sweep.runs) {
        if (!sweep.is_done(run)) continue;
        ++done;
        for (json& row : rows_of(sweep, run)) {
            for (const auto& [name, value] : row.items())
                if (std::ranges::find(columns, name) == columns.end()) columns.push_back(name);
            rows.emplace_back(&run, std::move(row));
        }
    }
    write_whole_file(file, [&](std::ostream& out) {
        out << "run";
        for (const std::string& name : sweep.names) out << ',' << cell(name);
        for (const std::string& name : columns) out << ',' << cell(name);
        out << '\n';
        for (const auto& [run, row] : rows) {
            out << run->number;
            for (const std::string& value : run->values) out << ',' << cell(value);
            for (const std::string& name : columns) out << ',' << cell(row.value(name, json()));
            out << '\n';
        }
    });
    return done;
}

/// A word of a shell's command line.
std::string quoted(const std::string& word) {
    std::string text = "'";
    for (const char c : word) c == '\'' ? text += "'\\''" : text += c;
    return text + "'";
}

/// A job array that runs what is missing.
void print_slurm(std::span<const SweepRun* const> missing, const fs::path& file) {
    if (missing.empty()) return fmt::print("#!/usr/bin/env bash\n# No run is missing.\n");
    std::vector<std::uint32_t> numbers;
    for (const SweepRun* run : missing) numbers.push_back(run->number);
    fmt::print(
        "#!/usr/bin/env bash\n#SBATCH --job-name=pierce-sweep\n#SBATCH --array={}\n"
        "#SBATCH --output=/dev/null\nexec {} --quiet sweep {} --only "
        "\"$SLURM_ARRAY_TASK_ID\"\n",
        fmt::join(numbers, ","), quoted(fs::read_symlink("/proc/self/exe").string()),
        quoted(fs::absolute(file).string()));
}

}  // namespace

int sweep(const SweepOptions& options) {
    const Sweep sweep = read_sweep(options.file);
    std::vector<const SweepRun*> missing;
    for (const SweepRun& run : sweep.runs)
        if (!sweep.is_done(run) && options.only.value_or(run.number) == run.number)
            missing.push_back(&run);
    if (options.only && *options.only >= sweep.runs.size())
        throw InputError(fmt::format("'{}' has runs 0 to {}, no run {}", options.file.string(),
                                     sweep.runs.size() - 1, *options.only));
    if (options.slurm) {
        print_slurm(missing, options.file);
        return 0;
    }
    if (options.list) {
        for (const SweepRun* run : missing)
            fmt::print("{}: pierce {}\n", run->number, fmt::join(run->arguments, " "));
        return 0;
    }
    fs::create_directories(sweep.out);
    const std::vector<std::uint32_t> failed = run_all(sweep, missing, options.jobs);
    for (std::uint32_t number : failed)
        fmt::print(stderr, "pierce: run {} has failed; its output is in '{}'\n", number,
                   (sweep.runs[number].folder / "log.txt").string());
    if (!options.only) {
        const fs::path table = sweep.out / "table.csv";
        const std::size_t done = gather(sweep, table);
        fmt::print("{} of {} runs are done\ntable: {}\n", done, sweep.runs.size(),
                   fs::absolute(table).string());
    }
    return failed.empty() ? 0 : 1;
}

}  // namespace pierce::app
