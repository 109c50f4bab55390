#include "app/commands/report_command.hpp"

#include <memory>

#include "app/commands/command_options.hpp"
#include "app/reports/accuracy/accuracy_report.hpp"
#include "app/reports/cloth/cloth_report.hpp"
#include "app/reports/paper/paper_report.hpp"

namespace pierce::app {
namespace {

/// Where a report goes.
void add_places(CLI::App& command, std::filesystem::path& out, std::filesystem::path& html) {
    command.add_option("--out", out, "folder for the page, its pictures and CSV files")
        ->required()
        ->type_name("DIR");
    command
        .add_option("--html", html,
                    "write the page that holds all of it to FILE; DIR/report.html if not given")
        ->type_name("FILE");
}

void add_paper(CLI::App& report, int& code) {
    const auto options = std::make_shared<PaperReportOptions>();
    CLI::App* command = report.add_subcommand(
        "paper", "the paper's experiments, with its figures beside ours");
    add_places(*command, options->out, options->html);
    command->add_option("--count", options->count, "falling bodies")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    command->add_option("--seconds", options->timing.seconds, "simulated time")
        ->capture_default_str()
        ->check(positive_number);
    command->add_option("--dt", options->timing.dt, "time step in seconds")
        ->capture_default_str()
        ->check(positive_number);
    command->add_option("--seed", options->seed, "of the bodies' rotations")->capture_default_str();
    command->add_option("--bunnies", options->bunnies, "falling bodies of figures 10 and 11")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    command->add_option("--runs", options->runs, "runs of figure 14, each with a seed of its own")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000u));
    command
        ->add_option("--truth-every", options->truth_every, "figures 10 to 13 show every Nth frame")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    command
        ->add_option("--soft-seconds", options->soft_seconds,
                     "simulated time of soft piles, if that is less")
        ->capture_default_str()
        ->check(positive_number);
    command
        ->add_option("--landing-seconds", options->landing_seconds,
                     "simulated time of figure 14, whose first 3 seconds stand apart")
        ->capture_default_str()
        ->check(positive_number);
    command
        ->add_option("--cloth-seconds", options->cloth_seconds,
                     "simulated time of figures 15 and 16")
        ->capture_default_str()
        ->check(positive_number);
    command
        ->add_option("--gpu-results", options->gpu_results,
                     "folder of a report made with a GPU, whose parts are merged if there is none "
                     "here")
        ->type_name("DIR")
        ->check(CLI::ExistingDirectory);
    command
        ->add_option("--lattices", options->lattices,
                     "bodies of scenes that only a GPU is timed on")
        ->delimiter(',')
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    command
        ->add_option("--parts", options->parts,
                     "pictures, trees, times, curves, prediction, quality, time-step, cloth, gpu, "
                     "crossover; all if not given")
        ->delimiter(',')
        ->check(CLI::IsMember(PaperReportOptions::all_parts()));
    command->add_flag_callback(
        "--quick", [options] { options->make_quick(); },
        "few bodies, short motions: everything in about two minutes; options after it change it");
    add_examples(*command, {"pierce report paper --out report --quick",
                            "pierce report paper --out report --parts trees,quality"});
    command->callback([options, &code] { code = report_paper(*options); });
}

void add_accuracy(CLI::App& report, int& code) {
    const auto options = std::make_shared<AccuracyReportOptions>();
    CLI::App* command = report.add_subcommand(
        "accuracy",
        "time and error of all methods against exact truth, and their answers to the hard cases");
    add_places(*command, options->out, options->html);
    const auto add_size = [&](const char* name, std::uint32_t& size, const char* what) {
        command->add_option(name, size, what)
            ->capture_default_str()
            ->check(CLI::Range(1u, 1'000'000'000u));
    };
    add_size("--count", options->count, "falling bodies of the scenes");
    add_size("--every", options->every, "make the scenes' truth for every Nth frame");
    add_size("--poses", options->poses,
             "random poses per pair of meshes; half of it per ratio of resolutions");
    add_size("--rays", options->rays, "rays at vertices and edges");
    command->add_option("--seconds", options->timing.seconds, "simulated time of the scenes")
        ->capture_default_str()
        ->check(positive_number);
    command->add_option("--threads", options->threads, "threads for rays")
        ->capture_default_str()
        ->check(CLI::Range(1, 1024));
    command->add_option("--seed", options->seed, "of rotations and poses")->capture_default_str();
    add_examples(*command, {"pierce report accuracy --out accuracy --count 10 --seconds 2"});
    command->callback([options, &code] { code = report_accuracy(*options); });
}

void add_cloth(CLI::App& report, int& code) {
    const auto options = std::make_shared<ClothReportOptions>();
    CLI::App* command = report.add_subcommand(
        "cloth",
        "which crossings of cloth each method misses or invents, and how deep cloth goes through "
        "itself");
    add_places(*command, options->out, options->html);
    command
        ->add_option("--seconds", options->timing.seconds,
                     "simulated time of the motions compared on")
        ->capture_default_str()
        ->check(positive_number);
    command->add_option("--fall", options->falling.seconds, "simulated time of figure 16")
        ->capture_default_str()
        ->check(positive_number);
    command
        ->add_option("--nodes", options->nodes,
                     "of a sheet, vertices along a side; the scene's own if not given")
        ->check(CLI::Range(2u, 10000u));
    command->add_option("--threads", options->threads, "threads for detection")
        ->capture_default_str()
        ->check(CLI::Range(1, 1024));
    command->add_option("--parts", options->parts, "accuracy, penetration, size; all if not given")
        ->delimiter(',')
        ->check(CLI::IsMember({"accuracy", "penetration", "size"}));
    command
        ->add_option("--sizes", options->sizes,
                     "of the part size: vertices along a side of its sheets")
        ->delimiter(',')
        ->capture_default_str()
        ->check(CLI::Range(2u, 10000u));
    command->add_option("--size-seconds", options->size_seconds, "simulated time of its sheets")
        ->capture_default_str()
        ->check(positive_number);
    command->add_option("--layers-nodes", options->layers_nodes, "of its layers, as in --nodes")
        ->check(CLI::Range(2u, 10000u));
    command->add_option("--seed", options->seed, "of the sheet's turn")->capture_default_str();
    add_examples(*command, {"pierce report cloth --out cloth --parts accuracy --seconds 1"});
    command->callback([options, &code] { code = report_cloth(*options); });
}

}  // namespace

void add_report(CLI::App& app, int& code) {
    CLI::App* report = app.add_subcommand("report",
                                          "run a set of experiments and write a page about them");
    report->require_subcommand(1);
    add_examples(*report, {"pierce report paper --out report --quick"});
    add_paper(*report, code);
    add_accuracy(*report, code);
    add_cloth(*report, code);
}

}  // namespace pierce::app
