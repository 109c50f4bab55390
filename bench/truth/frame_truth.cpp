#include "truth/frame_truth.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <tuple>

namespace pierce::truth {
namespace {

/// A body as it stands in a frame.
struct Placed {
    std::uint32_t body = 0;
    const ExactMesh* mesh = nullptr;
    Frame frame;  ///< mesh's space to world
    Box box;      ///< in the world
};

std::vector<Vec3d> in_double(std::span<const Vec3f> positions) {
    std::vector<Vec3d> result;
    for (Vec3f p : positions) result.push_back(to_double(p));
    return result;
}

bool is_usable(const Pose& pose) {
    const Quaternion& q = pose.rotation;
    const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return is_finite(pose.position) && std::isfinite(norm) && norm > 0;
}

bool is_usable(std::span<const Vec3f> positions) {
    return std::ranges::all_of(positions, [](Vec3f p) { return is_finite(p); });
}

Box world_box(const ExactMesh& mesh, const Frame& frame) {
    Box box;
    for (std::uint32_t v : mesh.vertices()) box.extend(frame.to_parent(mesh.positions()[v]));
    return box;
}

/// The two of every pair whose boxes overlap, lower body first.
std::vector<std::pair<const Placed*, const Placed*>> candidates(std::vector<Placed>& bodies,
                                                                const scenes::PairRules& rules) {
    std::ranges::sort(bodies, {}, [](const Placed& p) { return p.box.lower.x; });
    std::vector<std::pair<const Placed*, const Placed*>> pairs;
    for (auto a = bodies.begin(); a != bodies.end(); ++a)
        for (auto b = a + 1; b != bodies.end() && b->box.lower.x <= a->box.upper.x; ++b)
            if (overlap(a->box, b->box) && rules.allow(a->body, b->body))
                pairs.push_back(a->body < b->body ? std::pair(&*a, &*b) : std::pair(&*b, &*a));
    return pairs;
}

void add_inside(const Placed& source, const Placed& target, std::vector<InsideVertex>& inside) {
    const Frame placement = relative_frame(source.frame, target.frame);
    for (std::uint32_t v : source.mesh->vertices()) {
        const Vec3d p = placement.to_parent(source.mesh->positions()[v]);
        if (target.mesh->where(p) != Where::inside) continue;
        const Nearest nearest = target.mesh->nearest(p);
        inside.push_back({source.body, target.body, v, nearest.distance,
                          normalized(target.frame.rotation * (nearest.point - p))});
    }
}

}  // namespace

RecordingTruth::RecordingTruth(const scenes::Recording& recording)
    : recording_(recording), rules_(recording) {
    for (std::uint32_t m = 0; m < recording.meshes.size(); ++m) {
        const scenes::SceneMesh& mesh = recording.meshes[m];
        const Mesh surface(mesh.name, mesh.data, {.inside = inside_of(recording, m)});
        triangles_.emplace_back(surface.triangles().begin(), surface.triangles().end());
        rest_.emplace_back(in_double(mesh.data.positions), triangles_.back());
    }
}

FrameTruth RecordingTruth::at(std::uint32_t frame, bool vertices) const {
    std::deque<ExactMesh> deformed;
    std::vector<Placed> bodies;
    for (std::uint32_t b = 0; b < recording_.bodies.size(); ++b) {
        const scenes::RecordedBody& body = recording_.bodies[b];
        const std::uint32_t mesh = recording_.mesh_of(b, frame);
        Placed placed{b, &rest_[mesh], {}, {}};
        if (body.motion == Motion::deforming) {
            const std::span<const Vec3f> positions = recording_.positions(b, frame);
            if (!is_usable(positions)) continue;
            placed.mesh = &deformed.emplace_back(in_double(positions), triangles_[mesh]);
        } else {
            const Pose pose = recording_.pose(b, frame);
            if (!is_usable(pose)) continue;
            placed.frame = frame_of(pose);
        }
        placed.box = world_box(*placed.mesh, placed.frame);
        bodies.push_back(placed);
    }

    FrameTruth truth{frame, {}, {}};
    for (const auto& [a, b] : candidates(bodies, rules_)) {
        const Frame a_in_b = relative_frame(a->frame, b->frame),
                    b_in_a = relative_frame(b->frame, a->frame);
        const bool meet = a->mesh->surfaces_intersect(*b->mesh, b_in_a);
        const bool a_enters = meet || b->mesh->contains_part(*a->mesh, a_in_b);
        const bool b_enters = meet || a->mesh->contains_part(*b->mesh, b_in_a);
        const bool solid = a->mesh->closed() && b->mesh->closed();
        if (meet || (solid && (a_enters || b_enters)))
            truth.overlapping.emplace_back(a->body, b->body);
        if (vertices && a_enters) add_inside(*a, *b, truth.inside);
        if (vertices && b_enters) add_inside(*b, *a, truth.inside);
    }
    std::ranges::sort(truth.overlapping);
    std::ranges::sort(truth.inside, {}, [](const InsideVertex& i) {
        return std::tuple(i.source, i.target, i.vertex);
    });
    return truth;
}

}  // namespace pierce::truth
