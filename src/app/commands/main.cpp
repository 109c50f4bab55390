#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>

#include "app/commands/add_commands.hpp"
#include "app/output/backends.hpp"
#include "app/output/interrupt.hpp"
#include "app/output/ranks.hpp"
#include "app/output/terminal.hpp"
#include "pierce/error.hpp"

namespace {

constexpr int exit_bad_input = 2;
constexpr int exit_failure = 1;

constexpr const char* footer = R"(Exit codes:
  0    done
  1    failure; 'validate' found a difference, 'check' a defect, 'doctor' that nothing can be found
  2    input that you can mend: options, names, files
  130  stopped by Ctrl-C (SIGINT)
  143  stopped by SIGTERM

Environment:
  PIERCE_QUIET=1   the same as --quiet
  PIERCE_DATA_DIR  folder of the bunny
  PIERCE_PYTHON    Python that draws plots
  No colours are used, with NO_COLOR and without.

Examples:
  pierce run tori --count 20 --seconds 2 --record motion
  pierce replay motion --method gimpact
  pierce detect a.obj b.obj
  pierce doctor)";

/// What cannot be used is the same for all ranks.
void say(const std::exception& error) {
    if (pierce::app::is_first_rank()) fmt::print(stderr, "pierce: {}\n", error.what());
}

/// Names what is no command; CLI11 says only that one is missing.
void require_known_command(const CLI::App& app, int argc, char** argv) {
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word.starts_with('-')) continue;
        if (app.get_subcommands(
                   [&](const CLI::App* command) { return command->get_name() == word; })
                .empty())
            throw pierce::InputError("there is no command '" + word +
                                     "'; 'pierce --help' lists all");
        return;
    }
}

/// True if what the command prints is all that it is for.
bool prints_an_answer(const CLI::App* command) {
    const auto is_given = [&](const char* option) {
        const CLI::Option* known = command->get_option_no_throw(option);
        return known != nullptr && known->count() > 0;
    };
    const std::string& name = command->get_name();
    return name == "scenes" || name == "completion" || is_given("--list") || is_given("--slurm");
}

/// What was printed is there: a full disk shows here at the latest.
void flush_output() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        throw pierce::InputError("cannot write to the standard output");
}

int run(int argc, char** argv) {
    CLI::App app{"Contacts between triangle meshes by ray tracing"};
    app.set_version_flag("--version", pierce::app::version_text,
                         "print the version, and the backends that can run here");
    app.require_subcommand(1);
    app.fallthrough();
    bool quiet = false;
    app.add_flag("-q,--quiet", quiet,
                 "print nothing but errors and what was asked for as such, and show no progress; "
                 "files are written");
    app.parse_complete_callback([&] {
        const bool answers = std::ranges::any_of(app.get_subcommands(), prints_an_answer);
        if (!answers && (quiet || pierce::app::is_quiet())) pierce::app::be_quiet();
        for (const CLI::App* command : app.get_subcommands())
            if (command->get_name() != "run" && command->get_name() != "replay")
                pierce::app::require_one_rank("'" + command->get_name() + "'");
    });

    int code = 0;
    pierce::app::add_commands(app, code);
    // Commands would take it over.
    app.footer(footer);
    try {
        require_known_command(app, argc, argv);
        app.parse(argc, argv);
        flush_output();
        return code;
    } catch (const CLI::ParseError& error) {
        const int shown = app.exit(error);
        if (shown == 0) std::cout.flush();
        return shown == 0 && std::cout.good() ? 0 : exit_bad_input;
    } catch (const pierce::app::Interrupted& stop) {
        fmt::print(stderr, "pierce: {}: {}\n", stop.what(), stop.missing);
        return exit_failure;
    } catch (const pierce::InputError& error) {
        say(error);
        return exit_bad_input;
    } catch (const std::filesystem::filesystem_error& error) {
        say(error);
        return exit_bad_input;
    } catch (const std::exception& error) {
        // {fmt} throws where the standard output takes no more.
        const bool cannot_print = std::ferror(stdout) != 0;
        fmt::print(stderr, "pierce: {}\n",
                   cannot_print ? "cannot write to the standard output" : error.what());
        return cannot_print ? exit_bad_input : exit_failure;
    }
}

}  // namespace

int main(int argc, char** argv) {
    pierce::app::catch_interrupts();
    const pierce::app::Ranks ranks(argc, argv);
    const int code = ranks.finish(run(argc, argv));
    const int signal = pierce::app::delayed_signal();
    return signal == 0 ? code : pierce::app::exit_code_of_signal(signal);
}
