#include "pierce/mesh_check.hpp"

#include <string>
#include <vector>

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/mesh.hpp"
#include "c_api/versioned.hpp"
#include "pierce/c/mesh_check.h"
#include "pierce/mesh_fix.hpp"

namespace pierce::c {
namespace {

constexpr bool same(pierce_mesh_defect a, MeshDefect b) { return a == static_cast<int>(b); }
static_assert(same(PIERCE_NO_TRIANGLES, MeshDefect::no_triangles));
static_assert(same(PIERCE_NOT_FINITE, MeshDefect::not_finite));
static_assert(same(PIERCE_BAD_INDEX, MeshDefect::bad_index));
static_assert(same(PIERCE_BORDER_EDGE, MeshDefect::border_edge));
static_assert(same(PIERCE_FLIPPED_EDGE, MeshDefect::flipped_edge));
static_assert(same(PIERCE_NON_MANIFOLD_EDGE, MeshDefect::non_manifold_edge));
static_assert(same(PIERCE_INSIDE_OUT, MeshDefect::inside_out));
static_assert(same(PIERCE_DEGENERATE_TRIANGLE, MeshDefect::degenerate_triangle));
static_assert(same(PIERCE_DUPLICATE_TRIANGLE, MeshDefect::duplicate_triangle));
static_assert(same(PIERCE_OPPOSITE_TRIANGLE, MeshDefect::opposite_triangle));
static_assert(same(PIERCE_BOWTIE_VERTEX, MeshDefect::bowtie_vertex));
static_assert(same(PIERCE_NO_INWARD_DIRECTION, MeshDefect::no_inward_direction));
static_assert(same(PIERCE_SELF_INTERSECTION, MeshDefect::self_intersection));
static_assert(same(PIERCE_UNUSED_VERTEX, MeshDefect::unused_vertex));
static_assert(same(PIERCE_DUPLICATE_VERTEX, MeshDefect::duplicate_vertex));
static_assert(same(PIERCE_OUT_OF_RANGE, MeshDefect::out_of_range));
static_assert(mesh_defect_count == PIERCE_OUT_OF_RANGE + 1);

constexpr pierce_mesh_check_options default_options{
    .struct_size = sizeof(pierce_mesh_check_options),
    .self_intersections = 0,
    .inside = PIERCE_INSIDE_AUTOMATIC};

/// A report as the caller sees it, with what it points to.
struct KeptReport : pierce_mesh_report {
    MeshReport report;
    std::string text;
    std::vector<std::string> names, meanings;
    std::vector<pierce_mesh_finding> found;

    explicit KeptReport(MeshReport made)
        : pierce_mesh_report{}, report(std::move(made)), text(describe(report.inside)) {
        for (const MeshFinding& finding : report.findings) {
            names.emplace_back(name(finding.kind));
            meanings.emplace_back(meaning(finding.kind));
        }
        for (std::size_t i = 0; i < report.findings.size(); ++i) found.push_back(finding_of(i));
        struct_size = sizeof(pierce_mesh_report);
        findings = found.data();
        finding_count = found.size();
        vertices = report.vertices;
        triangles = report.triangles;
        components = report.components;
        closed = report.closed;
        sound = report.sound();
        inside = static_cast<std::uint32_t>(report.inside.rule);
        volume = report.traits.volume;
        mean_edge_length = report.traits.mean_edge_length;
        copy_to(box_lower, report.box.lower);
        copy_to(box_upper, report.box.upper);
        inside_text = text.c_str();
    }

private:
    pierce_mesh_finding finding_of(std::size_t i) const {
        const MeshFinding& finding = report.findings[i];
        const std::uint32_t ids = ids_per_place(element(finding.kind));
        return {.defect = static_cast<std::uint32_t>(finding.kind),
                .changes_detection = pierce::changes_detection(finding.kind),
                .count = finding.count,
                .ids_per_place = ids,
                .places = finding.places.data(),
                .place_count = finding.places.size() / ids,
                .name = names[i].c_str(),
                .meaning = meanings[i].c_str()};
    }
};

/// A repaired mesh as the caller sees it, with what it points to.
struct KeptMesh : pierce_fixed_mesh {
    FixedMesh fixed;
    std::string text;

    explicit KeptMesh(FixedMesh made)
        : pierce_fixed_mesh{}, fixed(std::move(made)), text(describe(fixed.done)) {
        struct_size = sizeof(pierce_fixed_mesh);
        positions = reinterpret_cast<const float*>(fixed.mesh.positions.data());
        vertices = fixed.vertices.data();
        triangles = reinterpret_cast<const std::uint32_t*>(fixed.mesh.triangles.data());
        vertex_count = fixed.mesh.positions.size();
        triangle_count = fixed.mesh.triangles.size();
        done = text.c_str();
        inside = static_cast<std::uint32_t>(fixed.done.rule);
    }
};

}  // namespace
}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_default_mesh_check_options(pierce_mesh_check_options* options,
                                                size_t struct_size) {
    return guarded([&] { write_defaults(default_options, options, struct_size, "options"); });
}

pierce_status pierce_check_mesh(const float* positions, size_t vertex_count,
                                const uint32_t* triangles, size_t triangle_count,
                                const pierce_mesh_check_options* options,
                                const pierce_mesh_report** report) {
    return guarded([&] {
        required(report, "report");
        const pierce_mesh_check_options o = options == nullptr
                                                ? default_options
                                                : read_struct(options, default_options, "options");
        *report = new KeptReport(pierce::check_mesh(
            mesh_data(positions, vertex_count, triangles, triangle_count),
            {.self_intersections = o.self_intersections != 0,
             .inside = enumerated(o.inside, pierce::Inside::none, "options.inside")}));
    });
}

void pierce_free_mesh_report(const pierce_mesh_report* report) {
    delete static_cast<const KeptReport*>(report);
}

pierce_status pierce_fix_mesh(const float* positions, size_t vertex_count,
                              const uint32_t* triangles, size_t triangle_count,
                              const pierce_fixed_mesh** fixed) {
    return guarded([&] {
        required(fixed, "fixed");
        *fixed = new KeptMesh(
            pierce::fix_mesh(mesh_data(positions, vertex_count, triangles, triangle_count)));
    });
}

void pierce_free_fixed_mesh(const pierce_fixed_mesh* fixed) {
    delete static_cast<const KeptMesh*>(fixed);
}
