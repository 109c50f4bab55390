#pragma once

#include <string>

#include "app/commands/command_tree.hpp"

/// Scripts that let shells complete what is typed. They are made from the tree of commands, and
/// know what is fixed in it; elsewhere they offer files.
namespace pierce::app {

/// `program`: what `tree` describes. For `eval`, or a file that is sourced.
std::string bash_completion(const TreeCommand& program);
/// For a file _pierce in a folder of $fpath, or to be sourced.
std::string zsh_completion(const TreeCommand& program);
/// For ~/.config/fish/completions/pierce.fish, or to be sourced.
std::string fish_completion(const TreeCommand& program);

}  // namespace pierce::app
