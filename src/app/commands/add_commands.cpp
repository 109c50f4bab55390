#include "app/commands/add_commands.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <string>

#include "app/commands/check.hpp"
#include "app/commands/command_options.hpp"
#include "app/commands/commands.hpp"
#include "app/commands/compare_command.hpp"
#include "app/commands/completion.hpp"
#include "app/commands/doctor.hpp"
#include "app/commands/explain.hpp"
#include "app/commands/option_rules.hpp"
#include "app/commands/report_command.hpp"
#include "app/commands/sweep.hpp"
#include "app/commands/validate.hpp"
#include "app/output/ranks.hpp"

namespace pierce::app {
namespace {

void add_scenes(CLI::App& app, int& code) {
    CLI::App* command = app.add_subcommand("scenes", "list the scenes");
    add_examples(*command, {"pierce scenes"});
    command->callback([&code] { code = list_scenes(); });
}

void add_plan(CLI::App& app, int& code) {
    const auto options = std::make_shared<RunOptions>();
    CLI::App* command = app.add_subcommand("plan", "print which stages a scene's steps run");
    add_scene(*command, *options);
    options->detection.rays.mesh_progress = show_meshes();
    add_coverage(*command, options->detection.rays.world);
    add_temporal(*command, options->detection.rays.world);
    add_examples(*command, {"pierce plan tori --soft",
                            "pierce plan tori --temporal paper --coverage vertices"});
    command->callback([options, &code] { code = show_plan(*options); });
}

void add_run(CLI::App& app, int& code) {
    const auto options = std::make_shared<RunOptions>();
    CLI::App* command = app.add_subcommand(
        "run", "simulate a scene with Bullet and contacts from a method");
    add_scene(*command, *options);
    command->add_option("--seconds", options->seconds, "simulated time")
        ->capture_default_str()
        ->check(positive_number);
    command->add_option("--dt", options->dt, "time step in seconds; the scene's own if not given")
        ->check(positive_number);
    command->add_option("--record", options->record, "write the motion to DIR, for 'pierce replay'")
        ->type_name("DIR");
    command->add_option("--png", options->png, "write a picture of the last frame to FILE")
        ->type_name("FILE");
    add_detection(*command, options->detection);
    add_examples(*command,
                 {"pierce run tori --count 20 --seconds 2 --record motion",
                  "pierce run tori --count 5 --seconds 1 --soft --json run.json --png last.png",
                  "pierce run tori --count 5 --seconds 1 --html page.html",
                  "pierce -q run tori --count 5 --seconds 1 --json /dev/stdout"});
    command->callback([options, &code] {
        share_among_ranks(options->detection.rays);
        leave_to_first_rank({&options->record, &options->png, &options->detection.json,
                             &options->detection.page.file});
        code = run(*options);
    });
}

void add_replay(CLI::App& app, int& code) {
    const auto options = std::make_shared<ReplayOptions>();
    CLI::App* command = app.add_subcommand("replay", "detect contacts along recorded motion");
    command->add_option("folder", options->folder, "folder with scene.json")->required();
    command->add_flag("--deforming", options->deforming, "give rigid motion vertex by vertex");
    command->add_option("--png", options->png, "write a picture of the last frame to FILE")
        ->type_name("FILE");
    command
        ->add_option("--pictures", options->pictures,
                     "write a picture of every frame, with its contacts, to DIR")
        ->type_name("DIR");
    add_detection(*command, options->detection);
    add_examples(*command, {"pierce replay motion --method gimpact --json gimpact.json",
                            "pierce replay motion --pictures frames",
                            "pierce replay motion --threads 1 --temporal off --html page.html"});
    command->callback([options, &code] {
        if (!options->pictures.empty()) require_one_rank("--pictures");
        share_among_ranks(options->detection.rays);
        leave_to_first_rank(
            {&options->png, &options->detection.json, &options->detection.page.file});
        code = replay(*options);
    });
}

void add_detect(CLI::App& app, int& code) {
    const auto options = std::make_shared<DetectOptions>();
    CLI::App* command = app.add_subcommand("detect",
                                           "contacts of meshes as they stand in their files");
    command->add_option("meshes", options->meshes, "OBJ, PLY, STL or OFF files")
        ->required()
        ->expected(2, -1);
    command
        ->add_option("--backend", options->detection.rays.backend,
                     "automatic, embree, cuda, bvh or reference")
        ->capture_default_str();
    command
        ->add_option("--threads", options->detection.rays.threads,
                     "threads; all there are if not given")
        ->check(CLI::Range(1, 1024));
    options->detection.rays.mesh_progress = show_meshes();
    add_coverage(*command, options->detection.rays.world);
    command->add_option("--json", options->detection.json, "write the contacts to FILE")
        ->type_name("FILE");
    add_page(*command, options->detection.page);
    add_examples(*command,
                 {"pierce detect a.obj b.obj",
                  "pierce detect a.obj b.obj --margin 0.01 --json contacts.json --html page.html"});
    command->callback([options, &code] { code = detect(*options); });
}

void add_explain(CLI::App& app, int& code) {
    const auto options = std::make_shared<ExplainOptions>();
    CLI::App* command = app.add_subcommand(
        "explain", "why a vertex has, or has not, a contact with another body");
    command
        ->add_option("inputs", options->inputs,
                     "two mesh files as they stand, or a recording's folder")
        ->required()
        ->expected(1, 2);
    command->add_option("--vertex", options->vertex, "the vertex, counted from 0")->required();
    command
        ->add_option("--of", options->of,
                     "of meshes: which one has the vertex, a (the default) or b")
        ->check(CLI::IsMember({"a", "b"}));
    command->add_option("--frame", options->frame, "of a recording: the frame, counted from 0");
    command
        ->add_option("--bodies", options->bodies,
                     "of a recording: the vertex's body, and the other one")
        ->type_name("BODY OTHER")
        ->expected(2);
    add_rays(*command, options->rays);
    command->add_option("--json", options->json, "write the explanation to FILE")
        ->type_name("FILE");
    add_examples(*command, {"pierce explain a.obj b.obj --vertex 7",
                            "pierce explain a.obj b.obj --of b --vertex 0 --json why.json",
                            "pierce explain motion --frame 3 --bodies 1 0 --vertex 7"});
    command->callback([options, &code] { code = explain(*options); });
}

void add_check(CLI::App& app, int& code) {
    const auto options = std::make_shared<CheckOptions>();
    CLI::App* command = app.add_subcommand(
        "check", "what is wrong with meshes, and what that means for detection");
    command->add_option("meshes", options->meshes, "OBJ, PLY, STL or OFF files")->required();
    command->add_flag("--self-intersections", options->self_intersections,
                      "look for triangles that cross, too");
    add_inside(*command, options->inside);
    command
        ->add_option(
            "--fix", options->fix,
            "write the mesh, of which there must be one, to OUT, an OBJ file: if it is not "
            "closed, with vertices joined, triangles turned to face one way, doubles left "
            "out and holes closed; what was done is printed")
        ->type_name("OUT");
    command->add_option("--json", options->json, "write the findings to FILE")->type_name("FILE");
    add_examples(*command, {"pierce check a.obj b.obj --self-intersections",
                            "pierce check --fix fixed.obj a.obj"});
    command->callback([options, &code] { code = check(*options); });
}

void add_compare(CLI::App& app, int& code) {
    const auto options = std::make_shared<CompareOptions>();
    CLI::App* command = app.add_subcommand(
        "compare",
        "all methods on the same recorded frames: time beside error against the exact truth");
    command->add_option("folder", options->folder, "folder with scene.json")->required();
    command
        ->add_option("--methods", options->methods,
                     "full, walk, walk-predict, certified, overlaps, complete, reprojected, "
                     "gjk-hull, gjk-epa, gimpact, fcl; all if not given")
        ->delimiter(',');
    command->add_option("--threads", options->threads, "threads for rays")
        ->capture_default_str()
        ->check(CLI::Range(1, 1024));
    command
        ->add_option("--every", options->every,
                     "truth for every Nth frame; if not given, the truth that is there, or "
                     "every 4th frame")
        ->check(CLI::Range(1u, 1000000u));
    command->add_option("--json", options->json, "write all figures to FILE")->type_name("FILE");
    command->add_option("--plots", options->plots, "draw time against error into DIR")
        ->type_name("DIR");
    add_page(*command, options->page);
    add_examples(
        *command,
        {"pierce compare motion --methods full,overlaps,gimpact",
         "pierce compare motion --every 2 --json figures.json --plots plots --html page.html"});
    command->callback([options, &code] { code = compare_recording(*options); });
}

void add_validate(CLI::App& app, int& code) {
    const auto options = std::make_shared<ValidateOptions>();
    CLI::App* command = app.add_subcommand(
        "validate",
        "whether all backends find the same contacts, bit for bit, and which one is wrong");
    command->add_option("input", options->input, "name of a scene, or a recording's folder")
        ->required();
    command->add_option("--count", options->count, "of a scene: falling bodies; 100 if not given")
        ->check(CLI::Range(1u, 1000000u));
    command->add_flag("--soft", options->soft, "of a scene: falling bodies deform");
    command
        ->add_option("--seconds", options->seconds, "of a scene: simulated time; 10 if not given")
        ->check(positive_number);
    command->add_option("--every", options->every, "look at every Nth frame")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    command
        ->add_option("--backends", options->backends,
                     "reference, bvh, embree, cuda; all that can run here if not given, reference "
                     "for small scenes only")
        ->delimiter(',')
        ->expected(2, -1);
    command
        ->add_option("--modes", options->modes,
                     "what rays remember of the last step: full (nothing), walk, walk-predict, "
                     "certified; all if not given")
        ->delimiter(',')
        ->check(CLI::IsMember({"full", "walk", "walk-predict", "certified"}));
    add_coverage(*command, options->world);
    command->add_option("--json", options->json, "write all figures and wrong contacts to FILE")
        ->type_name("FILE");
    add_page(*command, options->page);
    add_examples(*command, {"pierce validate tori --count 5 --seconds 0.5",
                            "pierce validate motion --backends embree,bvh --modes full,certified "
                            "--json differences.json"});
    command->callback([options, &code] { code = validate(*options); });
}

void add_sweep(CLI::App& app, int& code) {
    const auto options = std::make_shared<SweepOptions>();
    CLI::App* command = app.add_subcommand(
        "sweep", "run a command with every combination of parameters, and gather one table");
    command->add_option("file", options->file, "JSON file with the command and the parameters")
        ->required();
    command->add_option("--jobs", options->jobs, "runs at the same time")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1024u));
    command->add_option("--only", options->only, "the number of one run");
    CLI::Option* list = command->add_flag("--list", options->list,
                                          "print the runs that are missing, and run nothing");
    command
        ->add_flag("--slurm", options->slurm,
                   "print a script for Slurm that runs what is missing, and run nothing")
        ->excludes(list);
    add_examples(*command, {"pierce sweep sweep.json --jobs 2", "pierce sweep sweep.json --list",
                            "pierce sweep sweep.json --slurm"});
    command->callback([options, &code] { code = sweep(*options); });
}

void add_demo(CLI::App& app, int& code) {
    const auto png = std::make_shared<std::filesystem::path>("demo.png");
    const auto html = std::make_shared<std::filesystem::path>("demo.html");
    CLI::App* command = app.add_subcommand(
        "demo", "100 tori by rays and by GJK/EPA, with a picture and a page");
    command->add_option("--png", *png, "picture of the last frame")
        ->type_name("FILE")
        ->capture_default_str();
    command->add_option("--html", *html, "page that plays all frames")
        ->type_name("FILE")
        ->capture_default_str();
    add_examples(*command, {"pierce demo", "pierce demo --png tori.png --html tori.html"});
    command->callback([png, html, &code] { code = demo(*png, *html); });
}

void add_doctor(CLI::App& app, int& code) {
    const auto json = std::make_shared<std::filesystem::path>();
    CLI::App* command = app.add_subcommand(
        "doctor", "what this machine has, what will be used of it, and what could be installed");
    command->add_option("--json", *json, "write all of it to FILE, too")->type_name("FILE");
    add_examples(*command, {"pierce doctor", "pierce doctor --json machine.json"});
    command->callback([json, &code] { code = doctor(*json); });
}

void add_completion(CLI::App& app, int& code) {
    const auto shell = std::make_shared<std::string>();
    CLI::App* command = app.add_subcommand("completion",
                                           "print a script that lets a shell complete commands");
    command->add_option("shell", *shell, "bash, zsh or fish")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish"}));
    add_examples(*command,
                 {"pierce completion bash > ~/.local/share/bash-completion/completions/pierce",
                  "pierce completion zsh > ~/.zsh/completions/_pierce",
                  "pierce completion fish > ~/.config/fish/completions/pierce.fish"});
    command->callback([shell, &app, &code] {
        const TreeCommand tree = tree_of(app);
        fmt::print("{}", *shell == "bash"  ? bash_completion(tree)
                         : *shell == "zsh" ? zsh_completion(tree)
                                           : fish_completion(tree));
        code = 0;
    });
}

}  // namespace

void add_commands(CLI::App& app, int& code) {
    add_scenes(app, code);
    add_plan(app, code);
    add_run(app, code);
    add_replay(app, code);
    add_detect(app, code);
    add_explain(app, code);
    add_check(app, code);
    add_compare(app, code);
    add_validate(app, code);
    add_sweep(app, code);
    add_demo(app, code);
    add_report(app, code);
    add_doctor(app, code);
    add_completion(app, code);
    refuse_what_has_no_effect(app);
}

}  // namespace pierce::app
