#include <algorithm>
#include <string>

#include "core/world/world_state.hpp"
#include "pierce/mesh.hpp"

/// What a plan tells of bodies.
namespace pierce {

namespace {

std::string why_open(const Mesh& mesh) {
    if (mesh.traits().closed()) return "closed, but without an inside";
    return "open (" + std::to_string(mesh.traits().inconsistent_edges) +
           " edges without a partner of opposite direction; " + pierce::describe(mesh.inside()) +
           ")";
}

}  // namespace

void World::State::describe(const BodyEntry& body, const Mesh& mesh) {
    plan.fixed_bodies += body.motion == Motion::fixed;
    plan.rigid_bodies += body.motion == Motion::rigid;
    plan.deforming_bodies += body.motion == Motion::deforming;
    plan.open_bodies += !mesh.inside().exists();
    const auto note = [&](const std::string& text) {
        const std::string line = "mesh '" + mesh.name() + "': " + text;
        if (std::ranges::find(plan.notes, line) == plan.notes.end()) plan.notes.push_back(line);
    };
    const MeshTraits& traits = mesh.traits();
    if (body.collision.sheet)
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
    if (!body.collision.sheet &&
        (mesh.inside().rule == Inside::winding || mesh.inside().covered_triangles > 0))
        note(pierce::describe(mesh.inside()));
    if (traits.degenerate_triangles > 0)
        note(std::to_string(traits.degenerate_triangles) +
             " triangles have no area and are never hit");
}

}  // namespace pierce
