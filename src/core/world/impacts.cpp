#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/body/reach.hpp"
#include "core/mesh/used_vertices.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "core/overlap/face_parts.hpp"
#include "core/overlap/first_meeting.hpp"
#include "core/world/world_state.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/impact_contact.hpp"
#include "pierce/mesh.hpp"

namespace pierce {
namespace {

/// True if the solids overlap at time 0, and do not only touch.
bool overlap_at_start(const MovingSurface& a, const MovingSurface& b) {
    Box box_a, box_b;
    for (const MovingPoint& p : a.points) box_a.extend(p.start);
    for (const MovingPoint& p : b.points) box_b.extend(p.start);
    if (!overlap(box_a, box_b)) return false;
    Box around = box_a;
    around.extend(box_b);
    const Grid grid(around);
    std::vector<GridPoint> points[2];
    for (const MovingPoint& p : a.points) points[0].push_back(grid.point(p.start));
    for (const MovingPoint& p : b.points) points[1].push_back(grid.point(p.start));
    const FaceParts parts = find_face_parts(grid, {points[0], a.triangles},
                                            {points[1], b.triangles});
    // What is inside as a whole overlaps, however small it is beside the other one.
    for (int side = 0; side < 2; ++side) {
        std::vector<bool> is_out(points[side].size(), false);
        for (const Triangle& t : (side == 0 ? a : b).triangles)
            for (const std::uint32_t v : t.vertex) is_out[v] = true;
        for (const std::uint32_t v : parts.vertices_in[side]) is_out[v] = false;
        if (std::ranges::count(is_out, true) == 0) return true;
    }
    double volume = 0, area = 0;
    for (const std::vector<FacePart>& side : parts.of)
        for (const FacePart& part : side) {
            volume += volume_of(part);
            area += part.area;
        }
    // The grid moves the points of each surface by less than a step.
    return volume > std::max(touch_at_start(a, b), 2 * grid.step()) * area;
}

using State = WorldInside::State;

/// The way of a rigid body.
struct Way {
    Frame start, end;
};

/// The solids of a world, whose state it is, on their ways: to where they are now, or some of them
/// from there on. Only those that come near one that moves are looked at vertex by vertex.
class Ways {
public:
    /// `ahead`: per slot, where a body is going; null: all bodies are on their way to where they
    /// are.
    Ways(const State& state, const std::map<std::uint32_t, Pose>* ahead)
        : state_(state), ahead_(ahead) {
        const auto& slots = state.bodies.slots();
        for (std::uint32_t i = 0; i < slots.size(); ++i) {
            if (!slots[i].used) continue;
            const BodyEntry& body = slots[i].thing;
            if (body.is_on_device())
                throw InputError("body " + std::to_string(i) + " has its place in device memory");
            if (!body.usable || body.away || state.left_out.contains(body.filter.world) ||
                body.collision.sheet || !state.mesh_of(body).inside().exists())
                continue;
            bodies_.push_back(i);
            boxes_.push_back(box_of(i));
        }
        surfaces_.resize(bodies_.size());
    }

    std::uint32_t count() const { return static_cast<std::uint32_t>(bodies_.size()); }
    std::uint32_t slot(std::uint32_t k) const { return bodies_[k]; }
    const BodyEntry& body(std::uint32_t k) const { return state_.bodies.slots()[bodies_[k]].thing; }
    const std::vector<Box>& boxes() const { return boxes_; }
    bool moves(std::uint32_t k) const {
        return ahead_ != nullptr ? ahead_->contains(bodies_[k]) : body(k).moved;
    }

    const MovingSurface& surface(std::uint32_t k) {
        std::optional<MovingSurface>& known = surfaces_[k];
        if (known) return *known;
        const BodyEntry& of = body(k);
        const Mesh& mesh = state_.mesh_of(of);
        MovingSurface& surface = known.emplace(MovingSurface{{}, mesh.triangles()});
        if (of.motion == Motion::deforming) {
            const std::span<const Vec3f> starts = start_of(of);
            for (const std::uint32_t v : stand_ins(mesh.triangles(), starts.size()))
                surface.points.push_back({to_double(starts[v]), to_double(of.positions[v])});
            return surface;
        }
        const Way way = way_of(bodies_[k]);
        for (const std::uint32_t v : stand_ins(mesh.triangles(), mesh.positions().size())) {
            const Vec3d p = to_double(mesh.positions()[v]);
            surface.points.push_back({way.start.to_parent(p), way.end.to_parent(p)});
        }
        return surface;
    }

private:
    /// Of a rigid or fixed body.
    Way way_of(std::uint32_t slot) const {
        const BodyEntry& body = state_.bodies.slots()[slot].thing;
        const Frame now = frame_of(body.pose);
        if (ahead_ == nullptr) return {body.moved ? frame_of(body.start_pose) : now, now};
        const auto goes = ahead_->find(slot);
        return {now, goes != ahead_->end() ? frame_of(goes->second) : now};
    }
    /// Of a deforming body.
    std::span<const Vec3f> start_of(const BodyEntry& body) const {
        return ahead_ == nullptr && body.moved ? body.start : body.positions;
    }

    /// Around all places on the way.
    Box box_of(std::uint32_t slot) const {
        const BodyEntry& body = state_.bodies.slots()[slot].thing;
        Box box;
        if (body.motion == Motion::deforming) {
            for (Vec3f p : body.positions) box.extend(to_double(p));
            for (Vec3f p : start_of(body)) box.extend(to_double(p));
            return box;
        }
        const Box rest = state_.mesh_of(body).view({}).box;
        const Way way = way_of(slot);
        for (const Frame& frame : {way.start, way.end}) box.extend(placed_box(rest, frame).box);
        // Corners are rounded, as vertices are.
        return box.inflated(constants::touch_tolerance * box.extent());
    }

    const State& state_;
    const std::map<std::uint32_t, Pose>* ahead_;
    std::vector<std::uint32_t> bodies_;  ///< their slots
    std::vector<Box> boxes_;             ///< like the next ones, per body
    std::vector<std::optional<MovingSurface>> surfaces_;
};

std::vector<ImpactContact> impacts_of(const State& s, Ways ways, std::uint32_t most_per_pair) {
    const auto& slots = s.bodies.slots();
    std::vector<ImpactContact> found;
    if (ways.count() == 0) return found;
    const BoxTree tree(ways.boxes());
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (std::uint32_t k = 0; k < ways.count(); ++k) {
        if (!ways.moves(k)) continue;
        tree.for_each_in(ways.boxes()[k], [&](std::uint32_t other) {
            if (other != k) pairs.insert(std::minmax(k, other));
        });
    }
    for (const auto& [k, other] : pairs) {
        const BodyId id_a{ways.slot(k), slots[ways.slot(k)].generation},
            id_b{ways.slot(other), slots[ways.slot(other)].generation};
        if ((ways.body(k).motion == Motion::fixed && ways.body(other).motion == Motion::fixed) ||
            !ways.body(k).filter.allows(ways.body(other).filter) ||
            s.excluded.contains({id_a, id_b}) || (s.pair_filter && !s.pair_filter(id_a, id_b)))
            continue;
        const MovingSurface &a = ways.surface(k), &b = ways.surface(other);
        const std::vector<FirstMeeting> meetings = first_meetings(a, b, most_per_pair);
        if (meetings.empty() || overlap_at_start(a, b)) continue;
        for (const FirstMeeting& meeting : meetings)
            found.push_back({.a = id_a,
                             .b = id_b,
                             .time = meeting.time,
                             .point = meeting.place,
                             .normal = meeting.normal,
                             .gap = meeting.gap,
                             .start_a = meeting.start[0],
                             .start_b = meeting.start[1],
                             .edges = meeting.edges,
                             .source = meeting.vertex_of_second ? Side::b : Side::a,
                             .vertex = meeting.vertex,
                             .edge_end = meeting.edges ? meeting.edge_end : no_vertex,
                             .triangle = meeting.triangle});
    }
    return found;
}

}  // namespace

std::vector<ImpactContact> World::impacts(std::uint32_t most_per_pair) const {
    return impacts_of(*state_, Ways(*state_, nullptr), most_per_pair);
}

std::vector<ImpactContact> World::impacts_ahead(std::span<const PoseAhead> ahead,
                                                std::uint32_t most_per_pair) const {
    std::map<std::uint32_t, Pose> poses;
    for (const PoseAhead& goes : ahead) {
        const std::string body = "body " + std::to_string(goes.body.index);
        if (state_->bodies.get(goes.body, "body").motion != Motion::rigid)
            throw InputError(body + " is not rigid: it has no pose ahead");
        if (!is_usable(goes.pose))
            throw InputError("the pose ahead of " + body +
                             " is not finite, too far away or has no rotation");
        if (!poses.emplace(goes.body.index, goes.pose).second)
            throw InputError(body + " has two poses ahead");
    }
    return impacts_of(*state_, Ways(*state_, &poses), most_per_pair);
}

}  // namespace pierce
