#include "app/measure/truth_program.hpp"

#include <fmt/core.h>
#include <spawn.h>
#include <unistd.h>

#include <optional>
#include <string>
#include <vector>

#include "app/measure/recording_files.hpp"
#include "app/output/child.hpp"
#include "app/output/waiting.hpp"
#include "pierce/error.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

namespace {

/// In this program's folder.
fs::path truth_program() {
    return fs::read_symlink("/proc/self/exe").parent_path() / "pierce_truth";
}

void run_truth_program(std::vector<std::string> arguments) {
    check_truth_program();
    arguments.insert(arguments.begin(), truth_program().string());
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_t child = 0;
    if (posix_spawn(&child, argv[0], nullptr, nullptr, argv.data(), environ) != 0 ||
        wait_for(child, "making the truth") != 0)
        throw InputError("pierce_truth failed");
}

/// A folder of its own, empty at first, that goes away with it. Throws InputError if it cannot be
/// made.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string name = (fs::temp_directory_path() / "pierce_truth_XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr)
            throw InputError("cannot make a folder like '" + name + "'");
        path_ = name;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

}  // namespace

bool has_truth_program() { return fs::exists(truth_program()); }

void check_truth_program() {
    if (!has_truth_program())
        throw InputError(
            "the truth is made by pierce_truth, which is not beside this program: build with "
            "PIERCE_BENCH=ON");
}

std::uint32_t sampling_of(const std::vector<scenes::TrueFrame>& truth) {
    return truth[1].frame - truth[0].frame;
}

namespace {

std::vector<scenes::TrueFrame> read(const fs::path& file) {
    const Waiting waiting("reading " + file.string());
    return scenes::read_truth(file);
}

/// Leaves every Nth frame. False if the truth lacks some of them.
bool keep_every(std::vector<scenes::TrueFrame>& truth, std::uint32_t every) {
    if (truth.size() < 2 || every % sampling_of(truth) != 0) return false;
    std::erase_if(truth, [&](const scenes::TrueFrame& f) { return f.frame % every != 0; });
    return true;
}

}  // namespace

std::vector<scenes::TrueFrame> truth_of(const fs::path& folder, std::optional<std::uint32_t> every,
                                        bool pairs_only) {
    const fs::path file = folder / "truth.json";
    if (fs::exists(file)) {
        std::vector<scenes::TrueFrame> truth = read(file);
        if (!every || keep_every(truth, *every)) return truth;
    }
    std::vector<std::string> arguments{folder.string(), "--every",
                                       std::to_string(every.value_or(usual_truth))};
    if (pairs_only) arguments.emplace_back("--pairs-only");
    run_truth_program(std::move(arguments));
    return read(file);
}

std::vector<scenes::TrueFrame> truth_of(const scenes::Recording& recording, std::uint32_t every,
                                        bool pairs_only) {
    const TemporaryFolder folder;
    save_recording(recording, folder.path());
    return truth_of(folder.path(), every, pairs_only);
}

std::vector<scenes::TrueSheetFrame> sheet_truth_of(const scenes::Recording& recording,
                                                   std::uint32_t every) {
    const TemporaryFolder folder;
    save_recording(recording, folder.path());
    run_truth_program({folder.path().string(), "--sheets", "--every", std::to_string(every)});
    const Waiting waiting("reading the truth");
    return scenes::read_sheet_truth(folder.path() / "sheets.json");
}

}  // namespace pierce::app
