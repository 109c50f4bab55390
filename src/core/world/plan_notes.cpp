#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/world/world_state.hpp"
#include "pierce/mesh.hpp"

/// What a plan tells of bodies.
namespace pierce {

namespace {

std::string why_open(const Mesh& mesh) {
    if (mesh.traits().closed()) return "closed, but without an inside";
    return "open (" + std::to_string(mesh.traits().inconsistent_edges) +
           " edges without a partner of opposite direction; " + describe(mesh.inside()) + ")";
}

/// What there is to know about the bodies of a mesh that are sheets, or that are none.
std::vector<std::string> notes_of(const Mesh& mesh, bool is_sheet) {
    std::vector<std::string> notes;
    const auto note = [&](const std::string& text) {
        notes.push_back("mesh '" + mesh.name() + "': " + text);
    };
    const MeshTraits& traits = mesh.traits();
    if (is_sheet)
        note(
            "sheet: contacts of its surface over the motion of a step, whatever is inside or "
            "outside");
    else if (!mesh.inside().exists())
        note(why_open(mesh) +
             ": nothing penetrates it; its own rays are limited in length and rules R2 and R3 do "
             "not apply");
    else if (traits.volume < 0)
        note(
            "inside out (negative volume): its normals point inward, so rays start in the wrong "
            "direction");
    if (!is_sheet && (mesh.inside().rule == Inside::winding || mesh.inside().covered_triangles > 0))
        note(describe(mesh.inside()));
    if (traits.degenerate_triangles > 0)
        note(std::to_string(traits.degenerate_triangles) +
             " triangles have no area and are never hit");
    return notes;
}

}  // namespace

void World::State::describe_bodies() {
    std::set<std::pair<const Mesh*, bool>> described;  // meshes, as those of sheets or of others
    std::set<std::string> lines;
    for (const auto& slot : bodies.slots()) {
        if (!slot.used) continue;
        const BodyEntry& body = slot.thing;
        const Mesh& mesh = mesh_of(body);
        plan.fixed_bodies += body.motion == Motion::fixed;
        plan.rigid_bodies += body.motion == Motion::rigid;
        plan.deforming_bodies += body.motion == Motion::deforming;
        plan.open_bodies += !mesh.inside().exists();
        if (!described.emplace(&mesh, body.collision.sheet).second) continue;
        for (std::string& line : notes_of(mesh, body.collision.sheet))
            if (lines.insert(line).second) plan.notes.push_back(std::move(line));
    }
}
}  // namespace pierce
