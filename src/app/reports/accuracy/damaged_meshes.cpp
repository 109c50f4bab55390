#include "app/reports/accuracy/damaged_meshes.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "app/measure/compare.hpp"
#include "app/reports/accuracy/random_poses.hpp"
#include "scenes/named/bunny.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::app {
namespace {

using scenes::Recording;

constexpr double shares[] = {0.01, 0.02, 0.05, 0.1};

struct Subject {
    std::string name;
    MeshData mesh;
    double size;  ///< [length] two of them overlap often at distances below this
};

MeshData damaged(MeshData mesh, double share, bool turned, std::uint32_t seed) {
    RandomPoses random(seed);
    const auto is_hit = [&] { return random.uniform(0, 1) < share; };
    if (turned) {
        for (Triangle& t : mesh.triangles)
            if (is_hit()) std::swap(t.vertex[0], t.vertex[1]);
    } else {
        std::erase_if(mesh.triangles, [&](const Triangle&) { return is_hit(); });
    }
    return mesh;
}

Comparison by_default(const Recording& recording, std::span<const scenes::TrueFrame> truth) {
    const ComparedMethod methods[] = {compared_method_named("overlaps")};
    return compare(recording, truth, methods, 1, "damaged meshes").front();
}

}  // namespace

void damaged_meshes(const AccuracyReportOptions& options, Page& page) {
    const Subject subjects[] = {{"torus", scenes::torus(1, 0.4, 30, 10), 2},
                                {"sphere", scenes::sphere(1, 3), 1.8},
                                {"bunny", scenes::bunny_mesh().data, 3}};
    const std::uint32_t poses = std::max(options.poses / 4, 1u);
    page.line("## Damaged meshes\n");
    page.line(
        "Two copies of a mesh in {} random poses; of the second one some triangles are gone or "
        "turned. The truth is that of two whole meshes. `Inside::winding` closes the mesh; with "
        "`Inside::closed` it has no inside.\n",
        poses);
    page.line(
        "| mesh | damage | share of triangles [%] | vertices inside | whose inside changes [%] | "
        "pairs | missed pairs, whole | damaged | without an inside | contacts a frame, whole | "
        "damaged | without an inside |\n|---|---|---|---|---|---|---|---|---|---|---|---|");
    Table table{{"share", "vertices inside", "inside changed [%]", "pairs", "missed pairs, whole",
                 "missed pairs", "missed pairs, not closed", "contacts, whole", "contacts",
                 "contacts, not closed"},
                {}};
    table.label_name = "mesh";
    for (const Subject& subject : subjects) {
        Recording recording = random_pairs(subject.mesh, subject.mesh, 0.3 * subject.size,
                                           subject.size, poses, options.seed);
        const std::vector<scenes::TrueFrame> truth = truth_of(recording, 1);
        const Comparison whole = by_default(recording, truth);
        for (const bool turned : {false, true})
            for (const double share : shares) {
                recording.meshes[1].data = damaged(subject.mesh, share, turned, options.seed);
                recording.meshes[1].inside = Inside::winding;
                const Comparison closed = by_default(recording, truth);
                recording.meshes[1].inside = Inside::closed;
                const Comparison open = by_default(recording, truth);
                const scenes::Accuracy& a = closed.accuracy;
                const double changed = 100 *
                                       static_cast<double>(a.missed_vertices + a.false_vertices) /
                                       static_cast<double>(std::max<std::uint64_t>(a.vertices, 1));
                const char* damage = turned ? "turned" : "gone";
                page.line(
                    "| {} | {} | {:g} | {} | {:.2f} | {} | {} | {} | {} | {:.1f} | {:.1f} | {:.1f} "
                    "|",
                    subject.name, damage, 100 * share, whole.accuracy.vertices, changed,
                    whole.accuracy.pairs, whole.accuracy.missed_pairs, closed.accuracy.missed_pairs,
                    open.accuracy.missed_pairs, whole.contacts, closed.contacts, open.contacts);
                table.labels.push_back(subject.name + " " + damage);
                table.rows.push_back({share, static_cast<double>(whole.accuracy.vertices), changed,
                                      static_cast<double>(whole.accuracy.pairs),
                                      static_cast<double>(whole.accuracy.missed_pairs),
                                      static_cast<double>(closed.accuracy.missed_pairs),
                                      static_cast<double>(open.accuracy.missed_pairs),
                                      whole.contacts, closed.contacts, open.contacts});
            }
    }
    page.line("");
    page.csv(table, "damaged_meshes");
}

}  // namespace pierce::app
