#include "app/commands/completion.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>

namespace pierce::app {
namespace {

/// Between single quotes, in any of the shells.
std::string in_quotes(const std::string& text) {
    std::string result = "'";
    for (char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

std::string words_of(const std::vector<std::string>& words) {
    return fmt::format("{}", fmt::join(words, " "));
}

std::string names_of(const std::vector<TreeOption>& options) {
    std::string names;
    for (const TreeOption& option : options)
        for (const std::string& name : option.names) names += (names.empty() ? "" : " ") + name;
    return names;
}

std::string names_of(const std::vector<TreeCommand>& commands) {
    std::string names;
    for (const TreeCommand& command : commands) names += (names.empty() ? "" : " ") + command.name;
    return names;
}

// Bash.

constexpr const char* bash_head = R"(# Completion of pierce for bash.
_pierce() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
    local command= options= words= files= value= head= i
    # Bash takes --option=value apart.
    if [[ $word == = ]]; then word=; fi
    if [[ $before == = ]]; then before=${COMP_WORDS[COMP_CWORD - 2]}; fi
    for ((i = 1; i < COMP_CWORD; ++i)); do
        case "$command ${COMP_WORDS[i]}" in
)";

constexpr const char* bash_tail = R"(    esac
    if [[ -z $value && $word == -* ]]; then
        words=$options files=
    elif [[ $value == list && $word == *,* ]]; then
        head=${word%,*},
        word=${word##*,}
    fi
    mapfile -t COMPREPLY < <(compgen -W "$words" -P "$head" -- "$word")
    if [[ -n $files ]]; then
        compopt -o filenames 2>/dev/null
        mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen "$files" -- "$word")
    fi
}
complete -F _pierce pierce
)";

/// The option of compgen that offers what is taken.
const char* bash_files(Takes takes) {
    return takes == Takes::file ? "-f" : takes == Takes::folder ? "-d" : "";
}

void add_bash_paths(const TreeCommand& command, const std::string& path, std::string& script) {
    for (const TreeCommand& inner : command.commands) {
        const std::string whole = path.empty() ? inner.name : path + " " + inner.name;
        script += fmt::format("            {}) command={} ;;\n", in_quotes(path + " " + inner.name),
                              in_quotes(whole));
        add_bash_paths(inner, whole, script);
    }
}

void add_bash_command(const TreeCommand& command, const std::string& path, std::string& script) {
    std::string words = names_of(command.commands), files;
    for (const TreeOption& argument : command.arguments) {
        words += words_of(argument.choices);
        files = bash_files(argument.takes);
    }
    script += fmt::format("        {})\n            options={} words={} files={}\n",
                          in_quotes(path), in_quotes(names_of(command.options)), in_quotes(words),
                          in_quotes(files));
    script += "            case $before in\n";
    for (const TreeOption& option : command.options) {
        if (option.takes == Takes::nothing) continue;
        script += fmt::format("                {}) value={} words={} files={} ;;\n",
                              fmt::join(option.names, " | "), option.is_list ? "list" : "one",
                              in_quotes(words_of(option.choices)),
                              in_quotes(bash_files(option.takes)));
    }
    script += "            esac\n            ;;\n";
    for (const TreeCommand& inner : command.commands)
        add_bash_command(inner, path.empty() ? inner.name : path + " " + inner.name, script);
}

// Zsh.

/// Inside of a part of what _arguments reads.
std::string escaped(const std::string& text) {
    std::string result;
    for (char c : text) {
        if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
        result += c;
    }
    return result;
}

/// What _arguments does to complete a value.
std::string zsh_action(const TreeOption& option) {
    const std::string words = words_of(option.choices);
    if (option.is_list && !words.empty())
        return "_values -s , " + escaped(option.label) + " " + words;
    if (option.takes == Takes::folder)
        return words.empty() ? "_files -/" : "{compadd -- " + words + "; _files -/}";
    if (option.takes == Takes::file) return "_files";
    return words.empty() ? " " : "(" + words + ")";
}

void add_zsh_command(const TreeCommand& command, int depth, std::string& script) {
    const std::string indent(static_cast<std::size_t>(4 * depth), ' ');
    script += indent + "_arguments -C";
    for (const TreeOption& option : command.options)
        for (const std::string& name : option.names) {
            const bool takes_value = option.takes != Takes::nothing;
            std::string text = fmt::format("({}){}{}[{}]", fmt::join(option.names, " "), name,
                                           takes_value && name.starts_with("--") ? "=" : "",
                                           escaped(option.description));
            if (takes_value)
                text += fmt::format(":{}:{}", escaped(option.label), zsh_action(option));
            script += " \\\n" + indent + "    " + in_quotes(text);
        }
    int place = 0;
    for (const TreeOption& argument : command.arguments)
        script += " \\\n" + indent + "    " +
                  in_quotes(fmt::format("{}:{}:{}",
                                        argument.repeats ? "*" : std::to_string(++place),
                                        escaped(argument.label), zsh_action(argument)));
    if (command.commands.empty()) {
        script += "\n";
        return;
    }
    script += fmt::format(" \\\n{0}    '1:command:({1})' \\\n{0}    '*::argument:->argument'\n",
                          indent, names_of(command.commands));
    script += indent + "[[ $state == argument ]] || return\n" + indent + "case $words[1] in\n";
    for (const TreeCommand& inner : command.commands) {
        script += fmt::format("{}{})\n", indent, inner.name);
        add_zsh_command(inner, depth + 1, script);
        script += indent + "    ;;\n";
    }
    script += indent + "esac\n";
}

// Fish.

/// True where a command of this path was typed, and none within it.
std::string fish_condition(const TreeCommand& command, const std::vector<std::string>& path) {
    std::string condition;
    for (const std::string& name : path)
        condition += (condition.empty() ? "" : "; and ") + ("__fish_seen_subcommand_from " + name);
    if (command.commands.empty()) return condition;
    if (path.empty()) return "__fish_use_subcommand";
    return condition + "; and not __fish_seen_subcommand_from " + names_of(command.commands);
}

std::string fish_value(const TreeOption& option) {
    const std::string words = words_of(option.choices);
    std::string offered;
    if (!words.empty())
        offered = " -a " + in_quotes(option.is_list ? "(__fish_append , " + words + ")" : words);
    if (option.takes == Takes::folder) offered += " -a '(__fish_complete_directories)'";
    if (option.takes == Takes::file) offered += " -F";
    return offered;
}

void add_fish_command(const TreeCommand& command, std::vector<std::string>& path,
                      std::string& script) {
    const std::string where = "complete -c pierce -n " + in_quotes(fish_condition(command, path));
    for (const TreeCommand& inner : command.commands)
        script += fmt::format("{} -a {} -d {}\n", where, inner.name, in_quotes(inner.description));
    for (const TreeOption& argument : command.arguments)
        if (const std::string offered = fish_value(argument); !offered.empty())
            script += where + offered + "\n";
    for (const TreeOption& option : command.options) {
        script += where;
        for (const std::string& name : option.names)
            script += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        if (option.takes != Takes::nothing)
            script += (option.takes == Takes::file ? " -r" : " -x") + fish_value(option);
        script += " -d " + in_quotes(option.description) + "\n";
    }
    for (const TreeCommand& inner : command.commands) {
        path.push_back(inner.name);
        add_fish_command(inner, path, script);
        path.pop_back();
    }
}

/// The program with the options of all commands in each of them.
TreeCommand with_shared_options(TreeCommand command, const std::vector<TreeOption>& shared) {
    for (const TreeOption& option : shared) {
        const auto has = [&](const TreeOption& own) { return own.names == option.names; };
        if (std::ranges::none_of(command.options, has)) command.options.push_back(option);
    }
    for (TreeCommand& inner : command.commands) inner = with_shared_options(inner, command.options);
    return command;
}

}  // namespace

std::string bash_completion(const TreeCommand& program) {
    const TreeCommand whole = with_shared_options(program, {});
    std::string script = bash_head;
    add_bash_paths(whole, "", script);
    script += "        esac\n    done\n    case $command in\n";
    add_bash_command(whole, "", script);
    return script + bash_tail;
}

std::string zsh_completion(const TreeCommand& program) {
    std::string script =
        "#compdef pierce\n# Completion of pierce for zsh.\n_pierce() {\n"
        "    local context state state_descr line\n    typeset -A opt_args\n";
    add_zsh_command(with_shared_options(program, {}), 1, script);
    // A file of $fpath is the function itself when it is first called.
    return script +
           "}\nif [[ $funcstack[1] == _pierce ]]; then\n    _pierce \"$@\"\nelse\n"
           "    compdef _pierce pierce\nfi\n";
}

std::string fish_completion(const TreeCommand& program) {
    std::string script = "# Completion of pierce for fish.\ncomplete -c pierce -f\n";
    std::vector<std::string> path;
    add_fish_command(with_shared_options(program, {}), path, script);
    return script;
}

}  // namespace pierce::app
