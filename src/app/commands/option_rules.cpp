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

/// True if a file is `input`, or one that a recording in the folder `input` consists of.
bool is_read(const std::filesystem::path& file, const std::filesystem::path& input) {
    std::error_code none;
    if (!std::filesystem::is_regular_file(file, none)) return false;
    if (std::filesystem::equivalent(file, input, none)) return true;
    const std::string name = file.filename(), type = file.extension();
    return std::filesystem::equivalent(std::filesystem::absolute(file).parent_path(), input,
                                       none) &&
           (name == "scene.json" || type == ".npy" || type == ".obj");
}

/// What a command reads is not written over.
void check_outputs(const CLI::App& command) {
    for (const CLI::Option* output : command.get_options()) {
        if (!is_output(*output)) continue;
        for (const CLI::Option* input : command.get_options())
            for (const std::string& file : output->results())
                for (const std::string& name : input->results())
                    if (input->get_positional() && is_read(file, name))
                        throw CLI::ValidationError(output->get_name(),
                                                   "would replace '" + file + "', which is read");
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
