#include "app/commands/doctor.hpp"

#include <fmt/core.h>
#include <png.h>
#include <unistd.h>
#include <CLI/Version.hpp>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/measure/truth_program.hpp"
#include "app/output/backends.hpp"
#include "app/output/draw_plots.hpp"
#include "app/output/json_file.hpp"
#include "app/output/provenance.hpp"
#include "app/output/waiting.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/detect/method.hpp"
#include "scenes/named/bunny.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::app {
namespace {

using nlohmann::json;

constexpr double gibibyte = 1024.0 * 1024 * 1024;  // [bytes]

/// What a backend found where two boxes overlap.
struct SelfTest {
    BackendState backend;
    std::size_t contacts = 0;
    std::string hash;
    bool agrees = false;  ///< with brute force, and there is something to agree about
};

SelfTest test_backend(const BackendState& backend) {
    SelfTest test{.backend = backend, .contacts = 0, .hash = {}, .agrees = false};
    if (!backend.runs()) return test;
    try {
        scenes::RaySettings settings;
        settings.backend = backend.name;
        World world(scenes::make_backend(settings));
        for (const auto& [lower, upper] : {std::pair(Vec3d{0, 0, 0}, Vec3d{1, 1, 1}),
                                           std::pair(Vec3d{0.9, 0.2, 0.3}, Vec3d{1.9, 0.7, 0.8})})
            world.add_rigid_body(world.add_mesh("box", scenes::box(lower, upper)));
        world.detect();
        test.contacts = world.contacts().size();
        test.hash = fmt::format("{:016x}", contact_hash(world.contacts()));
    } catch (const std::exception& error) {
        test.backend.problem = error.what();
    }
    return test;
}

std::vector<SelfTest> test_all() {
    const Waiting waiting("testing backends");
    std::vector<SelfTest> tests;
    for (const BackendState& backend : backends()) tests.push_back(test_backend(backend));
    const auto reference = std::ranges::find(
        tests, "reference", [](const SelfTest& test) { return test.backend.name; });
    for (SelfTest& test : tests)
        test.agrees = test.backend.runs() && test.contacts > 0 && test.hash == reference->hash;
    return tests;
}

/// Something that some commands need: whether it is here, and what to do if it is not.
struct Need {
    std::string name, state, hint;  ///< without a hint all is well
};

std::vector<Need> needs() {
    std::vector<Need> all;
    try {
        scenes::bunny_mesh();
        all.push_back({"bunny", "in " + scenes::data_folder().string(), ""});
    } catch (const InputError& error) {
        all.push_back({"bunny", "missing; the scene bunnies needs it", error.what()});
    }
    if (has_truth_program())
        all.push_back({"truth", "pierce_truth is beside this program", ""});
    else
        all.push_back({"truth", "no pierce_truth; 'pierce compare' and reports need it",
                       "build with PIERCE_BENCH=ON, which needs libcgal-dev and libgmp-dev"});
    try {
        scenes::make_detector(scenes::make_scene("tori", {1, false, 1}), scenes::Method::fcl);
        all.push_back({"fcl", "here, as a method to compare with", ""});
    } catch (const InputError& error) {
        all.push_back({"fcl", error.what(), "install libfcl-dev and build again"});
    }
    const std::string problem = drawing_problem();
    std::string pythons;
    for (const std::string& python : drawing_pythons())
        pythons += (pythons.empty() ? "" : " or ") + python;
    if (problem.empty())
        all.push_back({"plots", "drawn by matplotlib with " + pythons, ""});
    else
        all.push_back({"plots", "none: " + problem + " for " + pythons,
                       "install python3-matplotlib, or name a Python that has it, 3.11 or later, "
                       "in PIERCE_PYTHON"});
    return all;
}

std::vector<std::string> hints_of(const std::vector<SelfTest>& tests,
                                  const std::vector<Need>& all) {
    std::vector<std::string> hints;
    for (const SelfTest& test : tests)
        if (!test.backend.runs())
            hints.push_back(test.backend.problem);
        else if (!test.agrees)
            hints.push_back(test.backend.name +
                            " finds other contacts than reference: report this");
    for (const Need& need : all)
        if (!need.hint.empty()) hints.push_back(need.hint);
    return hints;
}

double memory(int pages) {
    return static_cast<double>(sysconf(pages)) * static_cast<double>(sysconf(_SC_PAGESIZE)) /
           gibibyte;
}

json versions_of_all() {
    json versions = versions_json();
    versions["cli11"] = CLI11_VERSION;
    versions["fmt"] = fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                                  FMT_VERSION % 100);
    versions["nlohmann_json"] = fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR,
                                            NLOHMANN_JSON_VERSION_MINOR,
                                            NLOHMANN_JSON_VERSION_PATCH);
    versions["libpng"] = png_get_libpng_ver(nullptr);
    return versions;
}

void print_row(const std::string& name, const std::string& text) {
    fmt::print("  {:<14} {}\n", name, text);
}

void print_values(const json& values) {
    for (const auto& [name, value] : values.items())
        print_row(name, value.is_string() ? value.get<std::string>() : value.dump());
}

void print(const SelfTest& test) {
    if (!test.backend.runs())
        print_row(test.backend.name, test.backend.problem);
    else
        print_row(test.backend.name,
                  fmt::format("{}; self test: {} contacts, {}", test.backend.description,
                              test.contacts, test.agrees ? "right" : "WRONG"));
}

json to_json(const SelfTest& test) {
    return {{"name", test.backend.name},
            {"runs", test.backend.runs()},
            {"description", test.backend.description},
            {"problem", test.backend.problem},
            {"contacts", test.contacts},
            {"hash", test.hash},
            {"right", test.agrees}};
}

}  // namespace

int doctor(const std::filesystem::path& file) {
    check_writable(file);
    json machine = machine_json();
    machine["memory_gib"] = std::round(memory(_SC_PHYS_PAGES) * 10) / 10;
    machine["memory_free_gib"] = std::round(memory(_SC_AVPHYS_PAGES) * 10) / 10;
    const json versions = versions_of_all();
    const std::vector<SelfTest> tests = test_all();
    const std::vector<Need> all = needs();
    const std::vector<std::string> hints = hints_of(tests, all);
    const std::string automatic = automatic_backend();
    const auto taken = std::ranges::find(tests, automatic,
                                         [](const SelfTest& test) { return test.backend.name; });
    const bool works = taken->agrees && std::ranges::all_of(tests, [](const SelfTest& test) {
                           return !test.backend.runs() || test.agrees;
                       });
    fmt::print("machine\n");
    print_values(machine);
    fmt::print("versions\n");
    print_values(versions);
    fmt::print("backends\n");
    for (const SelfTest& test : tests) print(test);
    print_row("automatic", "takes " + automatic);
    fmt::print("what some commands need\n");
    for (const Need& need : all) print_row(need.name, need.state);
    for (const std::string& hint : hints) fmt::print("hint: {}\n", hint);
    fmt::print("{}\n", works ? "all is well" : "contacts cannot be found here");
    if (!file.empty()) {
        json backends = json::array(), found = json::object();
        for (const SelfTest& test : tests) backends.push_back(to_json(test));
        for (const Need& need : all)
            found[need.name] = {{"here", need.hint.empty()}, {"state", need.state}};
        write_json_file(file, {{"machine", machine},
                               {"versions", versions},
                               {"backends", backends},
                               {"automatic", automatic},
                               {"needs", found},
                               {"hints", hints},
                               {"works", works}});
    }
    return works ? 0 : 1;
}

}  // namespace pierce::app
