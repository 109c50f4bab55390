// pierce_truth: writes beside a recording what every method should find in it.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pierce/app/progress.hpp"
#include "pierce/core/error.hpp"
#include "truth/frame_truth.hpp"

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using namespace pierce;

constexpr int exit_bad_input = 2;
constexpr int exit_failure = 1;

struct Options {
    fs::path folder;
    fs::path out;  ///< empty: in the folder
    std::uint32_t every = 1;
    bool pairs_only = false;
};

json to_json(const truth::FrameTruth& frame, bool pairs_only) {
    json result{{"frame", frame.frame}, {"overlapping", frame.overlapping}};
    if (pairs_only) return result;
    json& inside = result["inside"] = json::array();
    for (const truth::InsideVertex& v : frame.inside)
        inside.push_back({v.source, v.target, v.vertex, v.depth, v.normal.x, v.normal.y, v.normal.z});
    return result;
}

void write_truth(const Options& options) {
    const scenes::Recording recording = scenes::read_recording(options.folder);
    const truth::RecordingTruth truth(recording);
    json result{{"format", "pierce-truth"}, {"version", 1}, {"every", options.every}, {"frames", json::array()}};
    app::Progress progress("truth", recording.frame_count);
    for (std::uint64_t f = 0; f < recording.frame_count; f += options.every) {
        const auto frame = static_cast<std::uint32_t>(f);
        result["frames"].push_back(to_json(truth.at(frame, !options.pairs_only), options.pairs_only));
        progress.show(frame + 1);
    }
    const fs::path file = options.out.empty() ? options.folder / "truth.json" : options.out;
    std::ofstream out(file);
    out << result << '\n';
    if (!out.flush()) throw InputError("cannot write '" + file.string() + "'");
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Exact overlaps and inside vertices of a recording"};
    Options options;
    app.add_option("folder", options.folder, "folder with scene.json")->required();
    app.add_option("--every", options.every, "look at every Nth frame")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    app.add_flag("--pairs-only", options.pairs_only, "leave out inside vertices");
    app.add_option("--out", options.out, "write to FILE instead of truth.json in the folder")->type_name("FILE");
    try {
        app.parse(argc, argv);
        write_truth(options);
        return 0;
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : exit_bad_input;
    } catch (const InputError& error) {
        fmt::print(stderr, "pierce_truth: {}\n", error.what());
        return exit_bad_input;
    } catch (const std::exception& error) {
        fmt::print(stderr, "pierce_truth: {}\n", error.what());
        return exit_failure;
    }
}
