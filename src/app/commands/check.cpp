#include "app/commands/check.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

#include "app/commands/commands.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/interrupt.hpp"
#include "app/output/json_file.hpp"
#include "app/output/provenance.hpp"
#include "app/output/waiting.hpp"
#include "pierce/error.hpp"
#include "pierce/mesh_check.hpp"
#include "pierce/mesh_fix.hpp"
#include "scenes/files/mesh_io.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int sound = 0, has_findings = 1, unreadable = 2;

std::string places_text(const MeshFinding& finding) {
    const std::uint32_t step = ids_per_place(element(finding.kind));
    std::string text;
    for (std::size_t i = 0; i < finding.places.size(); i += step) {
        text += text.empty() ? "" : ", ";
        text += std::to_string(finding.places[i]);
        if (step == 2) text += "-" + std::to_string(finding.places[i + 1]);
    }
    if (text.empty()) return text;
    constexpr const char* elements[] = {"", "vertex", "triangle", "edge", "triangles"};
    const bool all = finding.places.size() == std::size_t{step} * finding.count;
    return fmt::format(" ({} {}{})", elements[static_cast<int>(element(finding.kind))], text,
                       all ? "" : ", ...");
}

void print(const std::string& file, const MeshReport& report) {
    const Vec3d size = report.box.empty() ? Vec3d{} : report.box.upper - report.box.lower;
    fmt::print(
        "{}: {}, {}; {} vertices, {} triangles, {} component{}, volume {:.6g}, size {:.6g} x "
        "{:.6g} x {:.6g}, ",
        file, report.sound() ? "sound" : "defective", report.closed ? "closed" : "not closed",
        report.vertices, report.triangles, report.components, report.components == 1 ? "" : "s",
        report.traits.volume, size.x, size.y, size.z);
    fmt::print("mean edge {:.6g}\n", report.traits.mean_edge_length);
    if (report.inside.rule != Inside::closed || report.inside.covered_triangles > 0)
        fmt::print("  inside: {}\n", describe(report.inside));
    for (const MeshFinding& finding : report.findings)
        fmt::print("  {} {}: {}{}\n      {}\n", changes_detection(finding.kind) ? "!" : "-",
                   name(finding.kind), finding.count, places_text(finding), meaning(finding.kind));
}

json to_json(const MeshInside& inside) {
    return {{"rule", name(inside.rule)},
            {"covered_triangles", inside.covered_triangles},
            {"joined_vertices", inside.joined_vertices},
            {"turned_triangles", inside.turned_triangles},
            {"left_out_triangles", inside.left_out_triangles},
            {"holes", inside.holes},
            {"cap_triangles", inside.cap_triangles},
            {"cap_share", inside.cap_share}};
}

json to_json(const std::string& file, const MeshReport& report) {
    const auto xyz = [](Vec3d v) { return json{v.x, v.y, v.z}; };
    json findings = json::array();
    for (const MeshFinding& finding : report.findings) {
        json places = json::array();
        const std::uint32_t step = ids_per_place(element(finding.kind));
        for (std::size_t i = 0; i < finding.places.size(); i += step)
            places.push_back(step == 1 ? json(finding.places[i])
                                       : json{finding.places[i], finding.places[i + 1]});
        findings.push_back({{"defect", name(finding.kind)},
                            {"count", finding.count},
                            {"places", places},
                            {"changes_detection", changes_detection(finding.kind)},
                            {"meaning", meaning(finding.kind)}});
    }
    json result = {{"file", file},
                   {"sound", report.sound()},
                   {"closed", report.closed},
                   {"inside", to_json(report.inside)},
                   {"vertices", report.vertices},
                   {"triangles", report.triangles},
                   {"components", report.components},
                   {"volume", report.traits.volume},
                   {"mean_edge", report.traits.mean_edge_length},
                   {"findings", findings}};
    if (!report.box.empty()) result["box"] = {xyz(report.box.lower), xyz(report.box.upper)};
    return result;
}

}  // namespace

namespace {

/// Writes the mesh repaired, and says what was done.
void fix(const fs::path& file, const fs::path& out) {
    std::optional<Waiting> waiting("repairing " + file.string());
    const MeshData mesh = scenes::read_mesh(file);
    const FixedMesh fixed = fix_mesh(mesh);
    {
        const InterruptDelay delay;
        scenes::write_obj(out, fixed.mesh);
    }
    waiting.reset();
    const MeshInside& done = fixed.done;
    fmt::print(
        "{}: {}; {} vertices ({} before), {} triangles ({} before): {} turned, {} left out, ",
        out.string(), done.exists() ? "closed" : "still open", fixed.mesh.positions.size(),
        mesh.positions.size(), fixed.mesh.triangles.size(), mesh.triangles.size(),
        done.turned_triangles, done.left_out_triangles);
    fmt::print("{} hole{} closed by {}\n", done.holes, done.holes == 1 ? "" : "s",
               done.cap_triangles);
}

}  // namespace

int check(const CheckOptions& options) {
    if (!options.fix.empty() && options.meshes.size() != 1)
        throw InputError("--fix writes one mesh, but there are " +
                         std::to_string(options.meshes.size()));
    if (options.fix.has_extension() && options.fix.extension() != ".obj")
        throw InputError("--fix writes an OBJ file, not '" + options.fix.string() + "'");
    check_writable(options.json);
    check_writable(options.fix);
    check_different({options.json, options.fix});
    json meshes = json::array();
    int worst = sound;
    for (const std::filesystem::path& file : options.meshes) {
        try {
            std::optional<Waiting> waiting("checking " + file.string());
            const MeshReport report = check_mesh(
                scenes::read_mesh(file),
                {.self_intersections = options.self_intersections, .inside = options.inside});
            waiting.reset();
            print(file.string(), report);
            meshes.push_back(to_json(file.string(), report));
            worst = std::max(worst, report.sound() ? sound : has_findings);
        } catch (const InputError& error) {
            fmt::print(stderr, "{}: unreadable: {}\n", file.string(), error.what());
            meshes.push_back({{"file", file.string()}, {"error", error.what()}});
            worst = unreadable;
        }
    }
    if (!options.json.empty())
        write_json_file(options.json, {{"versions", versions_json()}, {"meshes", meshes}});
    if (!options.fix.empty() && worst != unreadable) fix(options.meshes[0], options.fix);
    return worst;
}

}  // namespace pierce::app
