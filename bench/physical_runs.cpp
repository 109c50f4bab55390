// How physical the motion of rigid bodies is with Pierce's contacts, beside Bullet's own ways.
// Prints a table; docs/physical_runs.md says what is measured.
//   pierce_physical_runs [--scene NAME]... [--method NAME]... [--seconds S]
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <string>
#include <vector>

#include "physical/measures.hpp"
#include "physical/scene.hpp"
#include "physical/simulation.hpp"
#include "pierce/error.hpp"
#include "times.hpp"

namespace {

using namespace pierce;
using namespace pierce::physical;

constexpr int exit_bad_input = 2;
constexpr int steps_per_second = 60;
constexpr int steps_between_depths = 10;
constexpr double never = std::numeric_limits<double>::infinity();
constexpr int watched_seconds = 10;  ///< at the end

struct Options {
    std::vector<std::string> scenes{scene_names().begin(), scene_names().end()};
    std::vector<std::string> methods{method_names().begin(), method_names().end()};
    int seconds = 60;
    std::uint32_t starts = 5;
    MethodSettings method;
    int trace = 0;  ///< print a line every so many steps; 0: never
};

/// What a run has shown. Energies are per mass and less that of the start, drifts are divided by
/// the sums of the sizes at the start.
struct Result {
    double energy_max = 0, energy_end = 0;
    double energy_gained = 0;  ///< the most above an earlier energy
    double momentum_drift = 0, angular_drift = 0;
    double contact_drift = 0;  ///< of the angular momentum, over steps with contacts only
    double depth_max = 0, depth_mean = 0;
    double speed_median = 0, speed_max = 0;
    double asleep_since = never;  ///< the step from which on all slept
    double detection_ms = 0;      ///< the median of steps with contacts in which some body is awake
    double moved = 0;
    Verdict verdict;
};

std::vector<BodyState> states_of(const Simulation& simulation, const Scene& scene) {
    std::vector<BodyState> states;
    states.reserve(scene.bodies.size());
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) states.push_back(simulation.state_of(b));
    return states;
}

/// Follows a run step by step.
class Run {
public:
    Run(const Scene& scene, const MethodSettings& settings)
        : scene_(scene), simulation_(scene, settings), mechanics_(scene), gauge_(scene) {
        start_ = states_of(simulation_, scene);
        last_.push_back(start_);
    }

    void step() {
        simulation_.step(1.0 / steps_per_second);
        ++steps_;
        last_.push_back(states_of(simulation_, scene_));
        if (last_.size() > watched_seconds * steps_per_second + 1) last_.pop_front();
        note_sleep();
        note_conserved();
        if (steps_ % steps_between_depths == 0) note_depth();
    }

    void trace() const {
        fmt::print(
            "step {:5d}: energy {:9.4f}, fastest {:8.4f}, {:3d} points, deepest {:.4f}, "
            "bodies {:.4f} deep\n",
            steps_, result_.energy_end, std::ranges::max(mechanics_.speeds(last_.back())),
            simulation_.points(), -simulation_.deepest_point(), depth_);
    }

    Result finish() {
        const std::vector<BodyState>& end = last_.back();
        std::vector<double> speeds = mechanics_.speeds(end);
        result_.speed_max = std::ranges::max(speeds);
        result_.speed_median = median(std::move(speeds));
        result_.moved = mechanics_.moved(end, last_.front());
        result_.detection_ms = median(std::move(detection_ms_));
        std::vector<Pose> poses;
        for (const BodyState& state : end) poses.push_back(state.pose);
        result_.verdict = scene_.judge({.poses = poses, .moved = result_.moved});
        return result_;
    }

private:
    void note_sleep() {
        const bool sleep = simulation_.all_sleep();
        if (!sleep) {
            result_.asleep_since = never;
            if (simulation_.points() > 0)
                detection_ms_.push_back(simulation_.detection_milliseconds());
        } else if (result_.asleep_since == never) {
            result_.asleep_since = steps_;
        }
    }

    void note_conserved() {
        const std::vector<BodyState>& now = last_.back();
        result_.energy_end = mechanics_.energy_per_mass(now) - mechanics_.energy_per_mass(start_);
        result_.energy_max = std::max(result_.energy_max, result_.energy_end);
        least_energy_ = std::min(least_energy_, result_.energy_end);
        result_.energy_gained = std::max(result_.energy_gained, result_.energy_end - least_energy_);
        const auto drift = [](Vec3d a, Vec3d b, double size) {
            return size > 0 ? length(b - a) / size : 0;
        };
        result_.momentum_drift = std::max(
            result_.momentum_drift, drift(mechanics_.momentum(start_), mechanics_.momentum(now),
                                          mechanics_.momentum_size(start_)));
        result_.angular_drift = std::max(
            result_.angular_drift,
            drift(mechanics_.angular_momentum(start_), mechanics_.angular_momentum(now),
                  mechanics_.angular_momentum_size(start_)));
        if (simulation_.points() > 0)
            by_contacts_ += mechanics_.angular_momentum(now) -
                            mechanics_.angular_momentum(last_[last_.size() - 2]);
        result_.contact_drift = std::max(
            result_.contact_drift,
            drift({}, by_contacts_, mechanics_.angular_momentum_size(start_)));
    }

    void note_depth() {
        depth_ = gauge_.deepest(last_.back());
        result_.depth_max = std::max(result_.depth_max, depth_);
        ++depths_;
        result_.depth_mean += (depth_ - result_.depth_mean) / depths_;
    }

    const Scene& scene_;
    Simulation simulation_;
    Mechanics mechanics_;
    DepthGauge gauge_;
    std::vector<BodyState> start_;
    std::deque<std::vector<BodyState>> last_;  ///< of the last seconds, and the step before them
    Result result_;
    double depth_ = 0;
    double least_energy_ = 0;
    Vec3d by_contacts_;  ///< angular momentum that steps with contacts have added
    std::vector<double> detection_ms_;
    int steps_ = 0, depths_ = 0;
};

Result run(const Scene& scene, const std::string& method, const Options& options) {
    MethodSettings settings = options.method;
    settings.method = method;
    Run run(scene, settings);
    for (int i = 1; i <= options.seconds * steps_per_second; ++i) {
        run.step();
        if (options.trace > 0 && i % options.trace == 0) run.trace();
    }
    return run.finish();
}

/// A column of the table: its head, and how wide it is.
struct Column {
    const char* head;
    int width;
};

constexpr std::array<Column, 17> columns = {{{"scene", -6},
                                             {"method", -20},
                                             {"energy max", 11},
                                             {"end", 9},
                                             {"gained", 8},
                                             {"momentum", 9},
                                             {"angular", 9},
                                             {"contacts", 9},
                                             {"deepest", 8},
                                             {"mean", 7},
                                             {"speed", 8},
                                             {"fastest", 8},
                                             {"moved", 8},
                                             {"asleep", 7},
                                             {"ms", 8},
                                             {"intact", 7},
                                             {"  figures", -9}}};

void print_row(const std::array<std::string, columns.size()>& cells) {
    std::string line;
    for (std::size_t c = 0; c < cells.size(); ++c)
        line += columns[c].width < 0 ? fmt::format("{:<{}}", cells[c], -columns[c].width)
                                     : fmt::format("{:>{}}", cells[c], columns[c].width);
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

void print_head() {
    std::array<std::string, columns.size()> heads;
    std::ranges::transform(columns, heads.begin(), &Column::head);
    print_row(heads);
}

/// Medians of figures, and for drifts, gains and depths the worst.
void print_results(const Scene& scene, const std::string& method, const std::vector<Result>& all) {
    const auto of = [&](double Result::*figure) {
        std::vector<double> values;
        for (const Result& r : all) values.push_back(r.*figure);
        std::ranges::sort(values);
        return values;
    };
    const auto middle = [&](double Result::*figure) {
        return fmt::format("{:.4f}", median(of(figure)));
    };
    const auto worst = [&](double Result::*figure) {
        return fmt::format("{:.4f}", of(figure).back());
    };
    const auto drift = [&](double Result::*figure) {
        return scene.gravity == 0 ? fmt::format("{:.1e}", of(figure).back()) : std::string("-");
    };
    const double asleep = median(of(&Result::asleep_since));
    const auto intact = std::ranges::count_if(all,
                                              [](const Result& r) { return r.verdict.intact; });
    print_row({scene.name, method, worst(&Result::energy_max), middle(&Result::energy_end),
               worst(&Result::energy_gained), drift(&Result::momentum_drift),
               drift(&Result::angular_drift), drift(&Result::contact_drift),
               worst(&Result::depth_max), middle(&Result::depth_mean),
               middle(&Result::speed_median), middle(&Result::speed_max), middle(&Result::moved),
               asleep == never ? "never" : fmt::format("{:.0f}", asleep),
               fmt::format("{:.3f}", median(of(&Result::detection_ms))),
               fmt::format("{}/{}", intact, all.size()), "  " + all.front().verdict.words});
}

void run_all(const Options& options) {
    print_head();
    for (const std::string& name : options.scenes)
        for (const std::string& method : options.methods) {
            const Scene first = make_scene(name);
            if (!first.has_ground && method.ends_with("-plane")) continue;
            std::vector<Result> results;
            for (std::uint32_t start = 0; start < options.starts; ++start)
                results.push_back(run(make_scene(name, start), method, options));
            print_results(first, method, results);
        }
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Physical runs: rigid bodies in Bullet with Pierce's contacts and with its own"};
    Options options;
    app.add_option("--scene", options.scenes, "run these scenes only")->capture_default_str();
    app.add_option("--method", options.methods, "use these methods only")->capture_default_str();
    app.add_option("--seconds", options.seconds, "simulated time")
        ->capture_default_str()
        ->check(CLI::Range(1, 3600));
    app.add_option("--starts", options.starts, "runs that start a little differently")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000u));
    app.add_option("--margin", options.method.margin, "of pierce-margin")
        ->capture_default_str()
        ->check(CLI::NonNegativeNumber);
    app.add_option("--most-per-pair", options.method.most_per_pair,
                   "Pierce's contacts of a pair that reach the solver")
        ->capture_default_str();
    app.add_option("--trace", options.trace, "print a line every N steps")
        ->type_name("N")
        ->check(CLI::Range(1, 1000000));
    try {
        app.parse(argc, argv);
        run_all(options);
        return 0;
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : exit_bad_input;
    } catch (const InputError& error) {
        fmt::print(stderr, "pierce_physical_runs: {}\n", error.what());
        return exit_bad_input;
    }
}
