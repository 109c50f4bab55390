#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <map>

#include "app/accuracy_report.hpp"
#include "app/check.hpp"
#include "app/cloth_report.hpp"
#include "app/commands.hpp"
#include "app/compare.hpp"
#include "app/explain.hpp"
#include "app/paper_report.hpp"
#include "app/validate.hpp"
#include "pierce/error.hpp"

namespace {

using namespace pierce::app;

constexpr int exit_bad_input = 2;
constexpr int exit_failure = 1;

const CLI::Validator positive_number(
    [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) &&
                          value > 0;
        return good ? std::string() : "must be a positive number, got " + text;
    },
    "POSITIVE");

const std::map<std::string, bool> switches{{"on", true}, {"off", false}};

/// What is looked for, and where contacts end.
void add_coverage(CLI::App& command, pierce::Settings& settings) {
    using pierce::Coverage;
    static const std::map<std::string, Coverage> coverages{{"vertices", Coverage::vertices},
                                                           {"complete", Coverage::complete}};
    command
        .add_option_function<std::string>(
            "--coverage",
            [&settings](const std::string& name) { settings.coverage = coverages.at(name); },
            "what is looked for inside other bodies: vertices (the default), or complete, with "
            "edges and whole bodies")
        ->check(CLI::IsMember({"vertices", "complete"}));
    command
        .add_option_function<std::string>(
            "--reproject",
            [&settings](const std::string& name) { settings.reproject = switches.at(name); },
            "move contacts to the closest point of the other surface: on or off (the default)")
        ->check(CLI::IsMember({"on", "off"}));
}

void add_temporal(CLI::App& command, pierce::Settings& settings) {
    using pierce::Temporal;
    static const std::map<std::string, Temporal> modes{
        {"off", Temporal::off}, {"paper", Temporal::paper}, {"certified", Temporal::certified}};
    command
        .add_option_function<std::string>(
            "--temporal",
            [&settings](const std::string& mode) { settings.temporal = modes.at(mode); },
            "what rays remember of the last step: off, paper or certified (the default)")
        ->check(CLI::IsMember({"off", "paper", "certified"}));
    command
        .add_option_function<std::string>(
            "--predict",
            [&settings](const std::string& mode) { settings.predict = switches.at(mode); },
            "with --temporal paper, look ahead for vertices about to enter: on or off")
        ->check(CLI::IsMember({"on", "off"}));
    command
        .add_option("--full-every", settings.full_every,
                    "with --temporal paper, steps between full passes of a pair")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
}

void add_rays(CLI::App& command, pierce::scenes::RaySettings& rays) {
    command
        .add_option("--backend", rays.backend,
                    "automatic (cuda if it can run here, else embree), embree, cuda, bvh or "
                    "reference; for rays")
        ->capture_default_str();
    command.add_option("--threads", rays.threads, "threads for rays; all there are if not given")
        ->check(CLI::Range(1, 1024));
    add_coverage(command, rays.world);
    add_temporal(command, rays.world);
}

void add_detection(CLI::App& command, DetectionOptions& options) {
    command
        .add_option("--method", options.method,
                    "rays, gjk-epa, gjk-hull, gimpact or bullet-clusters")
        ->capture_default_str();
    add_rays(command, options.rays);
    command.add_option("--json", options.json, "write settings, summary and every frame to FILE")
        ->type_name("FILE");
}

void add_scene(CLI::App& command, RunOptions& options) {
    command.add_option("scene", options.scene, "name of a scene, see 'pierce scenes'")->required();
    command.add_option("--count", options.count, "falling bodies")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    command.add_flag("--soft", options.soft, "falling bodies deform");
    command.add_option("--seed", options.seed, "of the bodies' rotations")->capture_default_str();
    command
        .add_option("--nodes", options.nodes,
                    "of a sheet, vertices along a side; the scene's own number if not given")
        ->check(CLI::Range(2u, 10000u));
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Contacts between triangle meshes by ray tracing"};
    app.set_version_flag("--version", "pierce " PIERCE_VERSION);
    app.require_subcommand(1);

    int code = 0;
    app.add_subcommand("scenes", "list the scenes")->callback([&] { code = list_scenes(); });

    RunOptions plan_options;
    CLI::App* plan_command = app.add_subcommand("plan", "print which stages a scene's steps run");
    add_scene(*plan_command, plan_options);
    add_coverage(*plan_command, plan_options.detection.rays.world);
    add_temporal(*plan_command, plan_options.detection.rays.world);
    plan_command->callback([&] { code = show_plan(plan_options); });

    RunOptions run_options;
    CLI::App* run_command = app.add_subcommand(
        "run", "simulate a scene with Bullet and contacts from a method");
    add_scene(*run_command, run_options);
    run_command->add_option("--seconds", run_options.seconds, "simulated time")
        ->capture_default_str()
        ->check(positive_number);
    run_command
        ->add_option("--dt", run_options.dt, "time step in seconds; the scene's own if not given")
        ->check(positive_number);
    run_command
        ->add_option("--record", run_options.record, "write the motion to DIR, for 'pierce replay'")
        ->type_name("DIR");
    run_command->add_option("--png", run_options.png, "write a picture of the last frame to FILE")
        ->type_name("FILE");
    add_detection(*run_command, run_options.detection);
    run_command->callback([&] { code = run(run_options); });

    ReplayOptions replay_options;
    CLI::App* replay_command = app.add_subcommand("replay",
                                                  "detect contacts along recorded motion");
    replay_command->add_option("folder", replay_options.folder, "folder with scene.json")
        ->required();
    replay_command->add_flag("--deforming", replay_options.deforming,
                             "give rigid motion vertex by vertex");
    replay_command
        ->add_option("--png", replay_options.png, "write a picture of the last frame to FILE")
        ->type_name("FILE");
    replay_command
        ->add_option("--pictures", replay_options.pictures,
                     "write a picture of every frame, with its contacts, to DIR")
        ->type_name("DIR");
    add_detection(*replay_command, replay_options.detection);
    replay_command->callback([&] { code = replay(replay_options); });

    DetectOptions detect_options;
    CLI::App* detect_command = app.add_subcommand(
        "detect", "contacts of meshes as they stand in their files");
    detect_command->add_option("meshes", detect_options.meshes, "OBJ, PLY, STL or OFF files")
        ->required()
        ->expected(2, -1);
    detect_command
        ->add_option("--backend", detect_options.detection.rays.backend,
                     "automatic, embree, cuda, bvh or reference")
        ->capture_default_str();
    detect_command
        ->add_option("--threads", detect_options.detection.rays.threads,
                     "threads; all there are if not given")
        ->check(CLI::Range(1, 1024));
    add_coverage(*detect_command, detect_options.detection.rays.world);
    detect_command
        ->add_option("--json", detect_options.detection.json, "write the contacts to FILE")
        ->type_name("FILE");
    detect_command->callback([&] { code = detect(detect_options); });

    ExplainOptions explain_options;
    CLI::App* explain_command = app.add_subcommand(
        "explain", "why a vertex has, or has not, a contact with another body");
    explain_command
        ->add_option("inputs", explain_options.inputs,
                     "two mesh files as they stand, or a recording's folder")
        ->required()
        ->expected(1, 2);
    explain_command->add_option("--vertex", explain_options.vertex, "the vertex, counted from 0")
        ->required();
    explain_command
        ->add_option("--of", explain_options.of,
                     "of meshes: which one has the vertex, a (the default) or b")
        ->check(CLI::IsMember({"a", "b"}));
    explain_command->add_option("--frame", explain_options.frame,
                                "of a recording: the frame, counted from 0");
    explain_command
        ->add_option("--bodies", explain_options.bodies,
                     "of a recording: the vertex's body, and the other one")
        ->type_name("BODY OTHER")
        ->expected(2);
    add_rays(*explain_command, explain_options.rays);
    explain_command->add_option("--json", explain_options.json, "write the explanation to FILE")
        ->type_name("FILE");
    explain_command->callback([&] { code = explain(explain_options); });

    CheckOptions check_options;
    CLI::App* check_command = app.add_subcommand(
        "check", "what is wrong with meshes, and what that means for detection");
    check_command->add_option("meshes", check_options.meshes, "OBJ, PLY, STL or OFF files")
        ->required();
    check_command->add_flag("--self-intersections", check_options.self_intersections,
                            "look for triangles that cross, too");
    check_command->add_option("--json", check_options.json, "write the findings to FILE")
        ->type_name("FILE");
    check_command->callback([&] { code = check(check_options); });

    CompareOptions compare_options;
    CLI::App* compare_command = app.add_subcommand(
        "compare",
        "all methods on the same recorded frames: time beside error against the exact truth");
    compare_command->add_option("folder", compare_options.folder, "folder with scene.json")
        ->required();
    compare_command
        ->add_option("--methods", compare_options.methods,
                     "full, walk, walk-predict, certified, complete, reprojected, gjk-hull, "
                     "gjk-epa, gimpact; all if not given")
        ->delimiter(',');
    compare_command->add_option("--threads", compare_options.threads, "threads for rays")
        ->capture_default_str()
        ->check(CLI::Range(1, 1024));
    compare_command
        ->add_option("--every", compare_options.every,
                     "make the truth, if there is none yet, for every Nth frame")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    compare_command->add_option("--json", compare_options.json, "write all figures to FILE")
        ->type_name("FILE");
    compare_command
        ->add_option("--plots", compare_options.plots, "draw time against error into DIR")
        ->type_name("DIR");
    compare_command->callback([&] { code = compare_recording(compare_options); });

    ValidateOptions validate_options;
    CLI::App* validate_command = app.add_subcommand(
        "validate",
        "whether all backends find the same contacts, bit for bit, and which one is wrong");
    validate_command
        ->add_option("input", validate_options.input, "name of a scene, or a recording's folder")
        ->required();
    validate_command
        ->add_option("--count", validate_options.count,
                     "of a scene: falling bodies; 100 if not given")
        ->check(CLI::Range(1u, 1000000u));
    validate_command->add_flag("--soft", validate_options.soft,
                               "of a scene: falling bodies deform");
    validate_command
        ->add_option("--seconds", validate_options.seconds,
                     "of a scene: simulated time; 10 if not given")
        ->check(positive_number);
    validate_command->add_option("--every", validate_options.every, "look at every Nth frame")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    validate_command
        ->add_option("--backends", validate_options.backends,
                     "reference, bvh, embree, cuda; all that can run here if not given, reference "
                     "for small scenes only")
        ->delimiter(',')
        ->expected(2, -1);
    add_coverage(*validate_command, validate_options.world);
    validate_command
        ->add_option("--json", validate_options.json,
                     "write all figures and wrong contacts to FILE")
        ->type_name("FILE");
    validate_command->callback([&] { code = validate(validate_options); });

    std::filesystem::path demo_png = "demo.png";
    CLI::App* demo_command = app.add_subcommand("demo",
                                                "100 tori by rays and by GJK/EPA, with a picture");
    demo_command->add_option("--png", demo_png, "picture of the last frame")->capture_default_str();
    demo_command->callback([&] { code = demo(demo_png); });

    PaperReportOptions report_options;
    CLI::App* report_command = app.add_subcommand(
        "report", "run a set of experiments and write a page about them");
    report_command->require_subcommand(1);
    CLI::App* paper_command = report_command->add_subcommand(
        "paper", "the paper's experiments, with its figures beside ours");
    paper_command
        ->add_option("--out", report_options.out, "folder for the page, its pictures and CSV files")
        ->required()
        ->type_name("DIR");
    paper_command->add_option("--count", report_options.count, "falling bodies")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    paper_command->add_option("--seconds", report_options.timing.seconds, "simulated time")
        ->capture_default_str()
        ->check(positive_number);
    paper_command->add_option("--dt", report_options.timing.dt, "time step in seconds")
        ->capture_default_str()
        ->check(positive_number);
    paper_command->add_option("--seed", report_options.seed, "of the bodies' rotations")
        ->capture_default_str();
    paper_command
        ->add_option("--bunnies", report_options.bunnies, "falling bodies of figures 10 and 11")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    paper_command
        ->add_option("--runs", report_options.runs,
                     "runs of figure 14, each with a seed of its own")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000u));
    paper_command
        ->add_option("--truth-every", report_options.truth_every,
                     "figures 10 to 13 show every Nth frame")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    paper_command
        ->add_option("--parts", report_options.parts,
                     "times, curves, prediction, quality, time-step; all if not given")
        ->delimiter(',')
        ->check(CLI::IsMember({"times", "curves", "prediction", "quality", "time-step"}));
    paper_command->callback([&] { code = report_paper(report_options); });

    AccuracyReportOptions accuracy_options;
    CLI::App* accuracy_command = report_command->add_subcommand(
        "accuracy",
        "time and error of all methods against exact truth, and their answers to the hard cases");
    accuracy_command
        ->add_option("--out", accuracy_options.out,
                     "folder for the page, its pictures and CSV files")
        ->required()
        ->type_name("DIR");
    const auto add_size = [&](const char* name, std::uint32_t& size, const char* what) {
        accuracy_command->add_option(name, size, what)
            ->capture_default_str()
            ->check(CLI::Range(1u, 1'000'000'000u));
    };
    add_size("--count", accuracy_options.count, "falling bodies of the scenes");
    add_size("--every", accuracy_options.every, "make the scenes' truth for every Nth frame");
    add_size("--poses", accuracy_options.poses, "random poses per pair of meshes");
    add_size("--rays", accuracy_options.rays, "rays at vertices and edges");
    accuracy_command
        ->add_option("--seconds", accuracy_options.timing.seconds, "simulated time of the scenes")
        ->capture_default_str()
        ->check(positive_number);
    accuracy_command->add_option("--threads", accuracy_options.threads, "threads for rays")
        ->capture_default_str()
        ->check(CLI::Range(1, 1024));
    accuracy_command->add_option("--seed", accuracy_options.seed, "of rotations and poses")
        ->capture_default_str();
    accuracy_command->callback([&] { code = report_accuracy(accuracy_options); });

    ClothReportOptions cloth_options;
    CLI::App* cloth_command = report_command->add_subcommand(
        "cloth",
        "which crossings of cloth each method misses or invents, and how deep cloth goes through "
        "itself");
    cloth_command
        ->add_option("--out", cloth_options.out, "folder for the page, its pictures and CSV files")
        ->required()
        ->type_name("DIR");
    cloth_command
        ->add_option("--seconds", cloth_options.timing.seconds,
                     "simulated time of the motions compared on")
        ->capture_default_str()
        ->check(positive_number);
    cloth_command
        ->add_option("--fall", cloth_options.falling.seconds, "simulated time of figure 16")
        ->capture_default_str()
        ->check(positive_number);
    cloth_command
        ->add_option("--nodes", cloth_options.nodes,
                     "of a sheet, vertices along a side; the scene's own if not given")
        ->check(CLI::Range(2u, 10000u));
    cloth_command->add_option("--threads", cloth_options.threads, "threads for detection")
        ->capture_default_str()
        ->check(CLI::Range(1, 1024));
    cloth_command
        ->add_option("--parts", cloth_options.parts,
                     "accuracy, penetration, size; all if not given")
        ->delimiter(',')
        ->check(CLI::IsMember({"accuracy", "penetration", "size"}));
    cloth_command
        ->add_option("--sizes", cloth_options.sizes,
                     "of the part size: vertices along a side of its sheets")
        ->delimiter(',')
        ->capture_default_str()
        ->check(CLI::Range(2u, 10000u));
    cloth_command
        ->add_option("--size-seconds", cloth_options.size_seconds, "simulated time of its sheets")
        ->capture_default_str()
        ->check(positive_number);
    cloth_command
        ->add_option("--layers-nodes", cloth_options.layers_nodes, "of its layers, as in --nodes")
        ->check(CLI::Range(2u, 10000u));
    cloth_command->add_option("--seed", cloth_options.seed, "of the sheet's turn")
        ->capture_default_str();
    cloth_command->callback([&] { code = report_cloth(cloth_options); });

    try {
        app.parse(argc, argv);
        return code;
    } catch (const CLI::ParseError& error) {
        const int shown = app.exit(error);
        return shown == 0 ? 0 : exit_bad_input;
    } catch (const pierce::InputError& error) {
        fmt::print(stderr, "pierce: {}\n", error.what());
        return exit_bad_input;
    } catch (const std::exception& error) {
        fmt::print(stderr, "pierce: {}\n", error.what());
        return exit_failure;
    }
}
