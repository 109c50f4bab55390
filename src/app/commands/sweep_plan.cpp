#include "app/commands/sweep_plan.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "pierce/error.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;
// Parameters keep their order.
using json = nlohmann::ordered_json;

/// Commands that write what they found with --json.
constexpr std::array<std::string_view, 4> commands{"run", "replay", "compare", "validate"};
constexpr std::array<std::string_view, 6> keys{"format",     "version", "command",
                                               "parameters", "out",     "compare"};
/// More are a mistake in the file.
constexpr std::uint64_t most_runs = 1'000'000;

/// Text as an argument of a command has it.
std::string text_of(const json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
}

/// One parameter.
struct Parameter {
    std::string option;
    std::vector<json> values;
};

/// What is wrong with a sweep; read_sweep() adds the file's name.
void require(bool is_so, const std::string& what) {
    if (!is_so) throw InputError(what);
}

std::vector<std::string> strings_of(const json& list, const char* name) {
    require(
        list.is_array() && std::ranges::all_of(list, [](const json& s) { return s.is_string(); }),
        fmt::format("'{}' is a list of strings", name));
    return list.get<std::vector<std::string>>();
}

std::vector<Parameter> parameters_of(const json& object) {
    require(object.is_object() && !object.empty(), "'parameters' is an object, and not empty");
    std::vector<Parameter> parameters;
    for (const auto& [option, values] : object.items()) {
        require(option.starts_with("--") && option.size() > 2,
                fmt::format("'{}' is no option: options begin with two dashes", option));
        for (const char* own : {"--json", "--record", "--html"})
            require(option != own, fmt::format("'{}' is the sweep's own", own));
        require(values.is_array() && !values.empty() &&
                    std::ranges::all_of(
                        values, [](const json& v) { return v.is_primitive() && !v.is_null(); }),
                fmt::format("the values of '{}' are a list, and not empty", option));
        parameters.push_back({option, {values.begin(), values.end()}});
    }
    return parameters;
}

/// Appends an option with a value; a flag has true or false.
void append(std::vector<std::string>& arguments, const std::string& option, const json& value) {
    if (value.is_boolean()) {
        if (value.get<bool>()) arguments.push_back(option);
        return;
    }
    arguments.push_back(option);
    arguments.push_back(text_of(value));
}

Sweep sweep_of(const json& content, const fs::path& folder) {
    require(content.is_object(), "a sweep is an object");
    for (const auto& [key, value] : content.items())
        require(std::ranges::find(keys, key) != keys.end(),
                fmt::format("there is no '{}' in a sweep", key));
    require(content.value("format", "") == "pierce-sweep" && content.value("version", 0) == 1,
            "'format' is \"pierce-sweep\", and 'version' is 1");
    const std::vector<std::string> command = strings_of(content.value("command", json()),
                                                        "command");
    require(!command.empty() && std::ranges::find(commands, command[0]) != commands.end(),
            "'command' begins with run, replay, compare or validate");
    const std::vector<Parameter> parameters = parameters_of(content.value("parameters", json()));
    Sweep sweep;
    sweep.out = folder / content.value("out", "sweep");
    sweep.compares = content.contains("compare");
    if (sweep.compares) {
        require(command[0] == "run", "'compare' needs the motion that 'run' records");
        sweep.compare = strings_of(content["compare"], "compare");
    }
    std::uint64_t count = 1;
    for (const Parameter& p : parameters) {
        sweep.names.push_back(p.option.substr(2));
        count *= p.values.size();
        require(count <= most_runs, fmt::format("there are more than {} runs", most_runs));
    }
    for (std::uint32_t number = 0; number < count; ++number) {
        SweepRun& run = sweep.runs.emplace_back();
        run.number = number;
        run.arguments = command;
        run.folder = sweep.out / fmt::format("{:06}", number);
        std::uint64_t rest = count;
        for (const Parameter& p : parameters) {
            rest /= p.values.size();
            const json& value = p.values[number / rest % p.values.size()];
            run.values.push_back(text_of(value));
            append(run.arguments, p.option, value);
        }
    }
    return sweep;
}

/// What has ended well so far; no JSON if nothing has.
nlohmann::json read_done(const SweepRun& run) {
    std::ifstream in(run.done());
    return nlohmann::json::parse(in, nullptr, false);
}

}  // namespace

nlohmann::json Sweep::done_by(const SweepRun& run, bool compared) const {
    nlohmann::json done{{"run", run.arguments}};
    if (compared) done["compare"] = compare;
    return done;
}

bool Sweep::has_run(const SweepRun& run) const {
    const nlohmann::json done = read_done(run);
    return done.is_object() && done.value("run", nlohmann::json()) == run.arguments &&
           fs::exists(run.result()) && (!compares || fs::exists(run.motion()));
}

bool Sweep::has_compared(const SweepRun& run) const { return read_done(run).contains("compare"); }

bool Sweep::is_done(const SweepRun& run) const {
    if (!has_run(run)) return false;
    return !compares || (read_done(run) == done_by(run, true) && fs::exists(run.comparison()));
}

Sweep read_sweep(const fs::path& file) {
    std::ifstream in(file);
    if (!in) throw InputError("cannot read '" + file.string() + "'");
    try {
        return sweep_of(json::parse(in), file.parent_path());
    } catch (const std::exception& error) {
        throw InputError("'" + file.string() + "': " + error.what());
    }
}

}  // namespace pierce::app
