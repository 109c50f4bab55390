#include "app/output/frame_log.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/output/json_file.hpp"
#include "app/output/provenance.hpp"

namespace pierce::app {

using nlohmann::json;
using scenes::FrameResult;

Spread spread_of(std::vector<double> values) {
    if (values.empty()) return {};
    std::ranges::sort(values);
    const auto at = [&](double part) {
        return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
    };
    return {at(0.5), at(0.95), values.back()};
}

void FrameLog::add(const FrameResult& frame) { frames_.push_back(frame); }

std::vector<double> FrameLog::column(double FrameResult::*member) const {
    std::vector<double> values;
    values.reserve(frames_.size());
    for (const FrameResult& f : frames_) values.push_back(f.*member);
    return values;
}

std::vector<double> FrameLog::column(std::uint32_t FrameResult::*member) const {
    std::vector<double> values;
    values.reserve(frames_.size());
    for (const FrameResult& f : frames_) values.push_back(f.*member);
    return values;
}

std::vector<double> FrameLog::touching_pairs() const {
    std::vector<double> values;
    values.reserve(frames_.size());
    for (const FrameResult& f : frames_) values.push_back(static_cast<double>(f.touching.size()));
    return values;
}

std::vector<double> FrameLog::stage(const std::string& name) const {
    std::vector<double> values;
    values.reserve(frames_.size());
    for (const FrameResult& f : frames_)
        for (const scenes::NamedTime& t : f.times)
            if (t.name == name) values.push_back(t.milliseconds);
    return values;
}

std::vector<std::string> FrameLog::stage_names() const {
    std::vector<std::string> names;
    for (const FrameResult& f : frames_)
        for (const scenes::NamedTime& t : f.times)
            if (std::ranges::find(names, t.name) == names.end()) names.push_back(t.name);
    return names;
}

namespace {

/// The counts of a frame, as the table and the JSON name them.
struct Count {
    const char* label;
    const char* key;
    std::uint32_t FrameResult::*member;
    bool always;  ///< in the table even if it is zero throughout
};

constexpr Count counts[] = {
    {"pairs", "pairs", &FrameResult::pairs, true},
    {"full rays", "rays", &FrameResult::rays, true},
    {"hits", "hits", &FrameResult::hits, true},
    {"near edges", "edges", &FrameResult::edges, false},
    {"chords", "chords", &FrameResult::chords, false},
    {"edge contacts", "edge_contacts", &FrameResult::edge_contacts, false},
    {"separated pairs", "separated_pairs", &FrameResult::separated_pairs, false},
    {"reprojected", "reprojected", &FrameResult::reprojected, false},
    {"certified", "certified", &FrameResult::certified, false},
    {"rested", "rested", &FrameResult::rested, false},
    {"looks", "looks", &FrameResult::looks, false},
    {"walks", "walks", &FrameResult::walks, false},
    {"walk steps", "walk_steps", &FrameResult::walk_steps, false},
    {"lost walks", "lost_walks", &FrameResult::lost_walks, false},
    {"predictions", "predictions", &FrameResult::predictions, false},
    {"predictions true", "predictions_true", &FrameResult::predictions_true, false},
    {"contacts", "contacts", &FrameResult::contacts, true},
    {"crossings", "crossings", &FrameResult::crossings, false},
    {"remembered", "remembered", &FrameResult::remembered, false},
    {"tangled", "tangled", &FrameResult::tangled, false},
    {"rounds", "rounds", &FrameResult::rounds, false},
    {"pulled back", "pulled_back", &FrameResult::pulled_back, false},
    {"held bodies", "held_bodies", &FrameResult::held_bodies, false},
    {"crossings left", "crossings_left", &FrameResult::crossings_left, false},
    {"self crossings", "self_crossings", &FrameResult::self_crossings, false},
    {"tears", "tears", &FrameResult::tears, false}};

}  // namespace

void FrameLog::print() const {
    const auto row = [](const std::string& name, Spread s) {
        fmt::print("  {:<20} {:>10.3f} {:>10.3f} {:>10.3f}\n", name, s.median, s.p95, s.max);
    };
    const auto count = [](const std::string& name, Spread s) {
        fmt::print("  {:<20} {:>10.0f} {:>10.0f} {:>10.0f}\n", name, s.median, s.p95, s.max);
    };
    fmt::print("  {:<20} {:>10} {:>10} {:>10}\n", fmt::format("{} frames", size()), "median", "p95",
               "max");
    for (const std::string& name : stage_names()) row(name + " [ms]", spread_of(stage(name)));
    row("total [ms]", spread_of(column(&FrameResult::total_ms)));
    for (const Count& c : counts) {
        const Spread spread = spread_of(column(c.member));
        if (c.always || spread.max > 0) count(c.label, spread);
    }
    count("colliding pairs", spread_of(touching_pairs()));
    row("penetration mean", spread_of(column(&FrameResult::penetration_mean)));
    row("penetration max", spread_of(column(&FrameResult::penetration_max)));
    if (const Spread self = spread_of(column(&FrameResult::self_penetration)); self.max > 0)
        row("self-penetration", self);
    const auto excluded = std::ranges::count_if(frames_,
                                                [](const FrameResult& f) { return f.status != 0; });
    if (excluded > 0)
        fmt::print(
            "  warning: in {} frames bodies were left out because their motion is not finite\n",
            excluded);
}

namespace {

json spread_json(Spread s) { return {{"median", s.median}, {"p95", s.p95}, {"max", s.max}}; }

}  // namespace

namespace {

/// What is written of a frame: `ms` by stage, counts, depths, the hash.
json frame_json(std::size_t index, const FrameResult& f) {
    json ms;
    for (const scenes::NamedTime& t : f.times) ms[t.name] = t.milliseconds;
    ms["total"] = f.total_ms;
    json frame{{"index", index},
               {"ms", ms},
               {"pairs", f.touching},
               {"penetration_mean", f.penetration_mean},
               {"penetration_max", f.penetration_max},
               {"self_penetration", f.self_penetration},
               {"status", f.status},
               {"hash", fmt::format("{:016x}", f.hash)}};
    // "pairs" of a frame are the ones that touch; their number before that is in the summary.
    for (const Count& c : counts)
        if (!frame.contains(c.key)) frame[c.key] = f.*c.member;
    return frame;
}

}  // namespace

json FrameLog::last_json() const { return frame_json(size() - 1, frames_.back()); }

void FrameLog::write_json(const std::filesystem::path& file, const json& settings) const {
    json summary;
    for (const std::string& name : stage_names())
        summary["ms"][name] = spread_json(spread_of(stage(name)));
    summary["ms"]["total"] = spread_json(spread_of(column(&FrameResult::total_ms)));
    for (const Count& c : counts) summary[c.key] = spread_json(spread_of(column(c.member)));
    summary["colliding_pairs"] = spread_json(spread_of(touching_pairs()));
    summary["penetration_mean"] = spread_json(spread_of(column(&FrameResult::penetration_mean)));
    summary["penetration_max"] = spread_json(spread_of(column(&FrameResult::penetration_max)));

    summary["self_penetration_max"] = spread_of(column(&FrameResult::self_penetration)).max;

    json frames = json::array();
    for (std::size_t i = 0; i < frames_.size(); ++i) frames.push_back(frame_json(i, frames_[i]));
    write_json_file(file, {{"machine", machine_json()},
                           {"versions", versions_json()},
                           {"settings", settings},
                           {"summary", summary},
                           {"frames", frames}});
}

}  // namespace pierce::app
