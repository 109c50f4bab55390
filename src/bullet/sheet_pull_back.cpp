#include "bullet/sheet_response_state.hpp"

namespace pierce::bullet {
namespace {

/// Pulling back starts gently: at first a vertex keeps this part of its way to the meeting [1].
constexpr double way_kept = 0.5;
/// For so many detections a vertex keeps a part of its way; after them it goes back all the way.
constexpr std::uint32_t gentle_attempts = 3;
/// After so many detections the vertices around it go back, too, ring by ring.
constexpr std::uint32_t single_attempts = 8;
/// After so many detections the whole body goes back. By then twenty rings have gone back, which is
/// further than anything spreads that would still end.
constexpr std::uint32_t ring_attempts = 28;

/// Calls visit(body, vertex) for every vertex of a contact.
template <class Visit>
void each_vertex(const World& world, const Contact& c, const Visit& visit) {
    visit(c.source_body(), c.vertex);
    if (c.is_edge()) visit(c.source_body(), c.edge_end);
    const Triangle& t = world.mesh(world.mesh_of(c.target_body())).triangles()[c.triangle];
    for (int k = 0; k < 3; ++k)
        // A vertex may meet a corner, where the other corners have no weight, but the whole
        // triangle counts. Where an edge meets an edge, the opposite corner does not count.
        if (!c.is_edge() || c.barycentric[k] != 0) visit(c.target_body(), t.vertex[k]);
}

}  // namespace

void SheetResponse::State::pull_back(Sheet& sheet, std::uint32_t vertex, double share) {
    const Vec3d start = to_double(sheet.nodes.start[vertex]);
    Vec3d& end = sheet.nodes.end[vertex];
    end = start + share * (end - start);
    sheet.pulled_back[vertex] = true;
}

/// Puts a rigid body back to where the step began, if it moves and is free to.
SheetResponse::State::Hold SheetResponse::State::hold(BodyId body) {
    const auto found = obstacle_of.find(body);
    // Things that do not move have not met; they are only too close together to be told apart.
    if (found == obstacle_of.end()) return Hold::needless;
    Obstacle& o = obstacles[found->second];
    if (o.start == o.end) return Hold::needless;
    if (!(o.moving.inverse_mass > 0)) return Hold::impossible;
    o.end = o.start;
    o.is_held = true;
    return Hold::held;
}

/// Pulls back all vertices of triangles with a vertex that was pulled back before.
void SheetResponse::State::pull_back_around(Sheet& sheet) {
    const std::vector<bool> before = sheet.pulled_back;
    for (const Triangle& t : world.mesh(world.mesh_of(sheet.body)).triangles())
        if (before[t.vertex[0]] || before[t.vertex[1]] || before[t.vertex[2]])
            for (std::uint32_t v : t.vertex) pull_back(sheet, v, 0);
}

/// Pulls back the vertices of all features that have met, and rigid bodies where no vertex can go
/// back any further; false if nothing can.
bool SheetResponse::State::pull_back(std::uint32_t attempt) {
    bool moved = false;
    report.crossings_left = 0;
    for (const Contact& c : world.contacts()) {
        if (!is_met(c) || !concerns_sheet(c)) continue;
        bool could = false;
        each_vertex(world, c, [&](BodyId body, std::uint32_t v) {
            const auto found = sheet_of.find(body);
            if (found == sheet_of.end()) return;
            Sheet& sheet = *found->second;
            // The test uses the detected position: an earlier contact of this list may have pulled
            // the vertex back since.
            if (sheet.end[v] == sheet.nodes.start[v]) return;
            could = true;
            pull_back(sheet, v, attempt < gentle_attempts ? way_kept * c.time : 0.0);
        });
        if (!could) {
            const Hold first = hold(c.a), second = hold(c.b);
            could = first == Hold::held || second == Hold::held;
            if (!could && (first == Hold::impossible || second == Hold::impossible))
                ++report.crossings_left;
        }
        moved |= could;
    }
    if (!moved) return false;
    for (const auto& sheet : sheets) {
        if (attempt >= ring_attempts)
            for (std::uint32_t v = 0; v < sheet->end.size(); ++v) pull_back(*sheet, v, 0);
        else if (attempt >= single_attempts)
            pull_back_around(*sheet);
    }
    return true;
}

}  // namespace pierce::bullet
