#include "app/commands/option_rules.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "scenes/named/scene.hpp"

namespace pierce::app {
namespace {

/// An option that means something only where another one has a value.
struct Rule {
    const char* option;
    const char* other;
    const char* value;     ///< of the other one; empty: any that is given
    const char* standard;  ///< the other one's value if it is not given
};

constexpr std::array rules = {
    Rule{.option = "--predict", .other = "--temporal", .value = "paper", .standard = "certified"},
    Rule{
        .option = "--full-every", .other = "--temporal", .value = "paper", .standard = "certified"},
    Rule{.option = "--rest", .other = "--temporal", .value = "certified", .standard = "certified"},
    Rule{.option = "--html-reasons", .other = "--html", .value = "", .standard = ""}};

bool is_given(const CLI::App& command, const std::string& name) {
    const CLI::Option* option = command.get_option_no_throw(name);
    return option != nullptr && option->count() > 0;
}

void check_rule(const CLI::App& command, const Rule& rule) {
    if (!is_given(command, rule.option)) return;
    const bool has_other = is_given(command, rule.other);
    const std::string wanted = rule.value,
                      value = has_other ? command.get_option_no_throw(rule.other)->results().back()
                                        : rule.standard;
    if (has_other && wanted.empty()) return;
    if (!wanted.empty() && value == wanted) return;
    throw CLI::ValidationError(rule.option, fmt::format("has no effect without {}{}{}", rule.other,
                                                        wanted.empty() ? "" : " ", wanted));
}

void check_scene(const CLI::App& command) {
    const char* argument = is_given(command, "scene") ? "scene" : "input";
    if (!is_given(command, argument)) return;
    const std::string name = command.get_option_no_throw(argument)->results().back();
    const auto scenes = scenes::scene_list();
    const auto info = std::ranges::find(scenes, name, &scenes::SceneInfo::name);
    if (info == scenes.end()) return;  // make_scene() says so, or it is a recording
    for (const auto& [option, takes] :
         {std::pair{"--count", info->has_count}, std::pair{"--soft", info->may_be_soft},
          std::pair{"--seed", info->has_seed}, std::pair{"--nodes", info->has_nodes}})
        if (!takes && is_given(command, option))
            throw CLI::ValidationError(option,
                                       fmt::format("has no effect on the scene '{}'", name));
}

void check_names(const CLI::App& command) {
    for (const CLI::Option* option : command.get_options()) {
        const std::string type = option->get_type_name();
        if (type != "FILE" && type != "DIR" && type != "OUT") continue;
        for (const std::string& name : option->results())
            if (name.empty()) throw CLI::ValidationError(option->get_name(), "needs a name");
    }
}

bool is_output(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    return !option.get_positional() && (type == "FILE" || type == "OUT");
}

/// True if a recording in the folder may consist of the file.
bool is_of_recording(const std::filesystem::path& file, const std::filesystem::path& folder) {
    std::error_code none;
    // A folder that is not there yet is not made absolute by weakly_canonical().
    const auto whole = [&](const std::filesystem::path& path) {
        return std::filesystem::weakly_canonical(std::filesystem::absolute(path, none), none);
    };
    const std::string name = file.filename(), type = file.extension();
    const std::filesystem::path place = whole(file);
    return !place.empty() && place == whole(folder / file.filename()) &&
           (name == "scene.json" || type == ".npy" || type == ".obj");
}

/// True if a file is `input`, or one that a recording in the folder `input` consists of.
bool is_read(const std::filesystem::path& file, const std::filesystem::path& input) {
    std::error_code none;
    return std::filesystem::is_regular_file(file, none) &&
           (std::filesystem::equivalent(file, input, none) || is_of_recording(file, input));
}

/// What a command reads is not written over, nor what it records.
void check_outputs(const CLI::App& command) {
    const auto refuse_if = [&](const CLI::Option& output, const CLI::Option& option,
                               const auto& would_replace, const char* what) {
        for (const std::string& file : output.results())
            for (const std::string& name : option.results())
                if (would_replace(file, name))
                    throw CLI::ValidationError(
                        output.get_name(),
                        fmt::format("would replace '{}', which is {}", file, what));
    };
    for (const CLI::Option* output : command.get_options()) {
        if (!is_output(*output)) continue;
        for (const CLI::Option* option : command.get_options())
            if (option->get_positional())
                refuse_if(*output, *option, is_read, "read");
            else if (option->get_name() == "--record")
                refuse_if(*output, *option, is_of_recording, "of the recording");
    }
}

}  // namespace

void refuse_what_has_no_effect(CLI::App& app) {
    for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        refuse_what_has_no_effect(*command);
        command->parse_complete_callback([command] {
            for (const Rule& rule : rules) check_rule(*command, rule);
            check_scene(*command);
            check_names(*command);
            check_outputs(*command);
        });
    }
}

}  // namespace pierce::app
