#include "app/commands/command_tree.hpp"

#include <algorithm>
#include <sstream>

#include "app/measure/compare.hpp"
#include "scenes/detect/method.hpp"
#include "scenes/named/scene.hpp"

namespace pierce::app {
namespace {

/// "a,b,c" of "TEXT:{a,b,c}".
std::vector<std::string> in_braces(const std::string& type) {
    std::vector<std::string> words;
    const std::size_t open = type.find('{'), close = type.find('}');
    if (open == std::string::npos || close == std::string::npos) return words;
    std::istringstream in(type.substr(open + 1, close - open - 1));
    for (std::string word; std::getline(in, word, ',');) words.push_back(word);
    return words;
}

std::vector<std::string> names_of_scenes() {
    std::vector<std::string> names;
    for (const scenes::SceneInfo& info : scenes::scene_list()) names.push_back(info.name);
    return names;
}

/// Names that the parser does not check: what takes them says which ones there are.
std::vector<std::string> choices_of(const std::string& name) {
    std::vector<std::string> names;
    if (name == "--backend") return {"automatic", "embree", "cuda", "bvh", "reference"};
    if (name == "--backends") return {"reference", "bvh", "embree", "cuda"};
    if (name == "scene" || name == "input") return names_of_scenes();
    if (name == "--method")
        for (const auto& [text, method] : scenes::method_names) names.emplace_back(text);
    if (name == "--methods")
        for (const ComparedMethod& method : compared_methods()) names.push_back(method.name);
    return names;
}

TreeOption describe(const CLI::Option& option) {
    TreeOption result{.names = {}, .label = {}, .description = option.get_description()};
    for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
    const std::string name = result.names.empty() ? option.get_name() : result.names.back(),
                      type = option.get_type_name();
    result.label = result.names.empty() ? name : type.substr(0, type.find(':'));
    result.choices = in_braces(type);
    if (result.choices.empty()) result.choices = choices_of(name);
    result.is_list = option.get_delimiter() != 0;
    result.repeats = option.get_items_expected_max() > 1;
    const auto is_any_of = [](const std::string& text, std::initializer_list<const char*> texts) {
        return std::ranges::find(texts, text) != texts.end();
    };
    if (option.get_items_expected_max() == 0)
        result.takes = Takes::nothing;
    else if (is_any_of(result.label, {"FILE", "OUT", "meshes", "inputs"}))
        result.takes = Takes::file;
    else if (is_any_of(result.label, {"DIR", "folder", "input"}))
        result.takes = Takes::folder;
    return result;
}

}  // namespace

TreeCommand tree_of(const CLI::App& app) {
    TreeCommand tree{.name = app.get_name(), .description = app.get_description()};
    for (const CLI::Option* option : app.get_options()) {
        const TreeOption described = describe(*option);
        (described.names.empty() ? tree.arguments : tree.options).push_back(described);
    }
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        tree.commands.push_back(tree_of(*command));
    return tree;
}

}  // namespace pierce::app
