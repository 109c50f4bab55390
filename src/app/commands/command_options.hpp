#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <initializer_list>
#include <map>
#include <string>

#include "app/commands/commands.hpp"
#include "app/output/progress.hpp"

/// Groups of options that several commands have.
namespace pierce::app {

/// Examples at the end of a command's --help.
inline void add_examples(CLI::App& command, std::initializer_list<const char*> lines) {
    std::string text = "Examples:";
    for (const char* line : lines) text += std::string("\n  ") + line;
    command.footer(text);
}

inline const std::map<std::string, bool> switches{{"on", true}, {"off", false}};

/// Refuses what is no positive, finite number.
inline const CLI::Validator positive_number(
    [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) &&
                          value > 0;
        return good ? std::string() : "must be a positive number, got " + text;
    },
    "POSITIVE");

/// What is looked for, and where contacts end.
inline void add_coverage(CLI::App& command, Settings& settings) {
    static const std::map<std::string, Coverage> coverages{{"vertices", Coverage::vertices},
                                                           {"overlaps", Coverage::overlaps},
                                                           {"complete", Coverage::complete}};
    command
        .add_option_function<std::string>(
            "--coverage",
            [&settings](const std::string& name) { settings.coverage = coverages.at(name); },
            "what is looked for inside other bodies: vertices, or overlaps (the default), with "
            "edges and whole bodies where no vertex is inside, or complete, with all edges")
        ->check(CLI::IsMember({"vertices", "overlaps", "complete"}));
    command
        .add_option_function<std::string>(
            "--reproject",
            [&settings](const std::string& name) { settings.reproject = switches.at(name); },
            "move contacts to the closest point of the other surface: on (the default) or off")
        ->check(CLI::IsMember({"on", "off"}));
    command
        .add_option("--margin", settings.margin,
                    "solids nearer than this are in contact before they touch")
        ->check(positive_number);
}

/// What rays remember of the last step.
inline void add_temporal(CLI::App& command, Settings& settings) {
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
        .add_option_function<std::string>(
            "--rest",
            [&settings](const std::string& name) { settings.may_rest = switches.at(name); },
            "with --temporal certified, remember nothing for a while where that would cost more "
            "than it spares: on (the default) or off")
        ->check(CLI::IsMember({"on", "off"}));
    command
        .add_option("--full-every", settings.full_every,
                    "with --temporal paper, steps between full passes of a pair")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
}

/// What is inside of meshes.
inline void add_inside(CLI::App& command, Inside& inside) {
    command
        .add_option_function<std::string>(
            "--inside", [&inside](const std::string& rule) { inside = *inside_named(rule); },
            "what is inside of meshes that do not say: automatic (the default), closed, winding or "
            "none")
        ->check(CLI::IsMember({"automatic", "closed", "winding", "none"}));
}

/// Backend, threads, coverage and memory.
inline void add_rays(CLI::App& command, scenes::RaySettings& rays) {
    rays.mesh_progress = show_meshes();
    command
        .add_option("--backend", rays.backend,
                    "automatic (cuda if it can run here, else embree), embree, cuda, bvh or "
                    "reference; for rays")
        ->capture_default_str();
    command.add_option("--threads", rays.threads, "threads for rays; all there are if not given")
        ->check(CLI::Range(1, 1024));
    command
        .add_option("--parts", rays.parts,
                    "so many backends share the bodies; of cuda one per device")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command
        .add_option("--host-share", rays.host_share,
                    "the processors do so much of one device's work beside cuda, such as 0.02")
        ->check(CLI::PositiveNumber);
    add_inside(command, rays.inside);
    command
        .add_option("--mesh-cache", rays.mesh_cache,
                    "keep what is measured of meshes in DIR, and find it there the next time")
        ->type_name("DIR");
    add_coverage(command, rays.world);
    add_temporal(command, rays.world);
}

/// A page that shows what was found.
inline void add_page(CLI::App& command, PageOptions& options) {
    command
        .add_option("--html", options.file,
                    "write a page to FILE that plays the frames with their contacts, in any "
                    "browser and without a network")
        ->type_name("FILE");
    command
        .add_option_function<std::string>(
            "--html-reasons",
            [&options](const std::string& mode) { options.reasons = switches.at(mode); },
            "of that page: why vertices have no contact, which takes longer than to detect: on "
            "(the default) or off")
        ->check(CLI::IsMember({"on", "off"}));
}

inline void add_detection(CLI::App& command, DetectionOptions& options) {
    command
        .add_option("--method", options.method,
                    "rays, gjk-epa, gjk-hull, gimpact, fcl or bullet-clusters")
        ->capture_default_str();
    add_rays(command, options.rays);
    command.add_option("--json", options.json, "write settings, summary and every frame to FILE")
        ->type_name("FILE");
    add_page(command, options.page);
}

/// The scene, and how large it is.
inline void add_scene(CLI::App& command, RunOptions& options) {
    command.add_option("scene", options.scene, "name of a scene, see 'pierce scenes'")->required();
    command.add_option("--count", options.count, "falling bodies")
        ->capture_default_str()
        ->check(CLI::Range(1u, 1000000u));
    command.add_flag("--soft", options.soft, "falling bodies deform");
    command.add_option("--seed", options.seed, "of the bodies' rotations")->capture_default_str();
    command
        .add_option("--nodes", options.nodes,
                    "of a sheet, vertices along a side; of a torus, around its hole; the "
                    "scene's own number if not given")
        ->check(CLI::Range(2u, 10000u));
}

}  // namespace pierce::app
