#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace pierce::app {

/// What can stand for an option or an argument.
enum class Takes {
    nothing,  ///< a flag
    text,     ///< what nobody can guess
    file,
    folder
};

/// An option with its names, "--json", or an argument without any.
struct TreeOption {
    std::vector<std::string> names;
    std::string label;  ///< what stands for it: "FILE"
    std::string description;
    Takes takes = Takes::text;
    std::vector<std::string> choices = {};  ///< beside what `takes` says; empty: none are known
    bool is_list = false;                   ///< commas stand between choices
    bool repeats = false;                   ///< of an argument: it takes all that follow
};

/// A command with its options, those of all commands among them, and its subcommands.
struct TreeCommand {
    std::string name, description;
    std::vector<TreeOption> options = {}, arguments = {};
    std::vector<TreeCommand> commands = {};
};

/// What the command line understands.
TreeCommand tree_of(const CLI::App& app);

}  // namespace pierce::app
