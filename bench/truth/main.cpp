// pierce_truth: writes beside a recording what every method should find in it.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/output/progress.hpp"
#include "app/output/waiting.hpp"
#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"
#include "truth/frame_truth.hpp"
#include "truth/sheet_truth.hpp"

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
    bool sheets = false;
};

json to_json(const truth::FrameTruth& frame, bool pairs_only) {
    json result{{"frame", frame.frame}, {"overlapping", frame.overlapping}};
    if (pairs_only) return result;
    json& inside = result["inside"] = json::array();
    for (const truth::InsideVertex& v : frame.inside)
        inside.push_back(
            {v.source, v.target, v.vertex, v.depth, v.normal.x, v.normal.y, v.normal.z});
    return result;
}

void write_truth(const Options& options) {
    std::optional<app::Waiting> reading("reading " + options.folder.string());
    const scenes::Recording recording = scenes::read_recording(options.folder);
    const truth::RecordingTruth truth(recording);
    reading.reset();
    json result{{"format", "pierce-truth"},
                {"version", 1},
                {"every", options.every},
                {"frames", json::array()}};
    app::Progress progress("truth", recording.frame_count);
    for (std::uint64_t f = 0; f < recording.frame_count; f += options.every) {
        const auto frame = static_cast<std::uint32_t>(f);
        result["frames"].push_back(
            to_json(truth.at(frame, !options.pairs_only), options.pairs_only));
        progress.show(frame + 1);
    }
    const fs::path file = options.out.empty() ? options.folder / "truth.json" : options.out;
    WholeFile whole(file);
    std::ofstream out(whole.part());
    out << result << '\n';
    if (!out.flush()) refuse_to_write(file);
    out.close();
    whole.keep();
}

json to_json(std::span<const truth::SheetMeeting> meetings,
             std::span<const truth::Piercing> piercings) {
    json result{{"meetings", json::array()}, {"piercings", json::array()}};
    for (const truth::SheetMeeting& m : meetings)
        result["meetings"].push_back({static_cast<int>(m.features), m.a, m.item, m.b, m.other});
    for (const truth::Piercing& p : piercings)
        result["piercings"].push_back({p.a, p.edge, p.b, p.triangle, p.depth});
    return result;
}

/// Frames are written one by one: there may be many meetings.
void write_sheets(const Options& options) {
    const scenes::Recording recording = scenes::read_recording(options.folder);
    const truth::SheetTruth truth(recording);
    const fs::path file = options.out.empty() ? options.folder / "sheets.json" : options.out;
    WholeFile whole(file);
    std::ofstream out(whole.part());
    truth::MeetingCounts counts;
    out << "{\"format\":\"pierce-sheet-truth\",\"version\":1,\"every\":" << options.every
        << ",\"frames\":[";
    app::Progress progress("sheets", recording.frame_count);
    for (std::uint64_t f = 0; f < recording.frame_count; f += options.every) {
        const auto frame = static_cast<std::uint32_t>(f);
        json entry = to_json(truth.meetings(frame, &counts), truth.piercings(frame));
        entry["frame"] = frame;
        out << (f == 0 ? "\n" : ",\n") << entry;
        progress.show(frame + 1);
    }
    out << "],\"decided\":"
        << json{{"apart", counts.apart},
                {"bounded", counts.bounded},
                {"ends", counts.ends},
                {"exact", counts.exact}}
        << "}\n";
    if (!out.flush()) refuse_to_write(file);
    out.close();
    whole.keep();
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Exact overlaps, inside vertices and meetings of sheets of a recording"};
    Options options;
    app.add_option("folder", options.folder, "folder with scene.json")->required();
    app.add_option("--every", options.every, "look at every Nth frame")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    app.add_flag("--pairs-only", options.pairs_only, "leave out inside vertices");
    app.add_flag("--sheets", options.sheets,
                 "what sheets meet from frame to frame, and edges through triangles")
        ->excludes("--pairs-only");
    app.add_option("--out", options.out,
                   "write to FILE instead of truth.json, or sheets.json, in the folder")
        ->type_name("FILE");
    try {
        app.parse(argc, argv);
        options.sheets ? write_sheets(options) : write_truth(options);
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
