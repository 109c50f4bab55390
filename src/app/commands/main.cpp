#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "app/commands/add_commands.hpp"
#include "app/output/backends.hpp"
#include "app/output/interrupt.hpp"
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

int run(int argc, char** argv) {
    CLI::App app{"Contacts between triangle meshes by ray tracing"};
    app.set_version_flag("--version", pierce::app::version_text,
                         "print the version, and the backends that can run here");
    app.require_subcommand(1);
    app.fallthrough();
    bool quiet = false;
    app.add_flag("-q,--quiet", quiet,
                 "print nothing but errors, and show no progress; files are written");
    app.parse_complete_callback([&] {
        if (quiet || pierce::app::is_quiet()) pierce::app::be_quiet();
    });

    int code = 0;
    pierce::app::add_commands(app, code);
    // Commands would take it over.
    app.footer(footer);
    try {
        app.parse(argc, argv);
        return code;
    } catch (const CLI::ParseError& error) {
        const int shown = app.exit(error);
        return shown == 0 ? 0 : exit_bad_input;
    } catch (const pierce::app::Interrupted& stop) {
        fmt::print(stderr, "pierce: {}: {}\n", stop.what(), stop.missing);
        return exit_failure;
    } catch (const pierce::InputError& error) {
        fmt::print(stderr, "pierce: {}\n", error.what());
        return exit_bad_input;
    } catch (const std::filesystem::filesystem_error& error) {
        fmt::print(stderr, "pierce: {}\n", error.what());
        return exit_bad_input;
    } catch (const std::exception& error) {
        fmt::print(stderr, "pierce: {}\n", error.what());
        return exit_failure;
    }
}

}  // namespace

int main(int argc, char** argv) {
    pierce::app::catch_interrupts();
    const int code = run(argc, argv);
    const int signal = pierce::app::delayed_signal();
    return signal == 0 ? code : pierce::app::exit_code_of_signal(signal);
}
