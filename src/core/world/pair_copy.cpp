#include "core/world/pair_copy.hpp"

#include <algorithm>
#include <optional>

#include "core/body/part_along_boxes.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/world/world_state.hpp"
#include "pierce/overlap.hpp"
#include "pierce/reference_backends.hpp"

namespace pierce {

World::PairCopy::PairCopy()
    : world_(bvh_backend(), {.coverage = Coverage::complete, .temporal = Temporal::off}) {}

void World::PairCopy::set(const Body& a, const Body& b) {
    for (BodyId id : ids_) world_.remove_body(id);
    ids_.clear();
    bodies_[0] = a;
    bodies_[1] = b;
    std::erase_if(meshes_, [&](const Kept& kept) {
        constexpr long owners_here = 2;  // this list and world_
        const bool is_needed = kept.mesh.use_count() > owners_here;
        if (!is_needed) world_.remove_mesh(kept.id);
        return !is_needed;
    });
    for (const Body& body : bodies_)
        ids_.push_back(body.motion == Motion::deforming
                           ? world_.add_deforming_body(keep(body.mesh), body.positions)
                           : world_.add_rigid_body(keep(body.mesh), body.pose));
}

MeshId World::PairCopy::keep(const std::shared_ptr<const Mesh>& mesh) {
    for (const Kept& kept : meshes_)
        if (kept.mesh == mesh) return kept.id;
    meshes_.push_back({mesh, world_.add_mesh(mesh)});
    return meshes_.back().id;
}

std::span<const Contact> World::PairCopy::contacts_after(Vec3d way) {
    // A pose moves a body exactly; positions are rounded to float32.
    const bool moves_a = bodies_[0].motion != Motion::deforming &&
                         bodies_[1].motion == Motion::deforming;
    if (moves_a)
        move(0, -way);
    else
        move(1, way);
    world_.detect();
    return world_.contacts();
}

void World::PairCopy::move(int body, Vec3d way) {
    const Body& from = bodies_[body];
    if (from.motion != Motion::deforming) {
        world_.set_pose(ids_[body], {from.pose.position + way, from.pose.rotation});
        return;
    }
    moved_.resize(from.positions.size());
    std::ranges::transform(from.positions, moved_.begin(),
                           [&](Vec3f p) { return to_float(to_double(p) + way); });
    world_.set_positions(ids_[body], moved_);
}

PlacedSurface World::PairCopy::placed(int body) const {
    const Body& from = bodies_[body];
    PlacedSurface surface{{}, from.mesh->triangles()};
    if (from.motion == Motion::deforming) {
        for (const Vec3f p : from.positions) surface.points.push_back(to_double(p));
    } else {
        const Frame frame = frame_of(from.pose);
        for (const Vec3f p : from.mesh->positions())
            surface.points.push_back(frame.to_parent(to_double(p)));
    }
    return surface;
}

bool World::PairCopy::are_within_reach() const {
    const auto& views = world_.state_->views;
    return views[ids_[0].index].active && views[ids_[1].index].active;
}

bool World::PairCopy::share_volume() {
    for (const Body& body : bodies_)
        if (!body.mesh->inside().exists()) return false;
    const std::optional<Overlap> shared = world_.overlap(ids_[0], ids_[1]);
    return shared && shared->volume > touch() * (shared->area_a + shared->area_b);
}

double World::PairCopy::touch() const {
    const auto& views = world_.state_->views;
    const BodyView &a = views[ids_[0].index], &b = views[ids_[1].index];
    return std::max(stages::touch_between(a, b, relative_frame(a.space, b.space)),
                    stages::touch_between(b, a, relative_frame(b.space, a.space)));
}

Vec3d World::PairCopy::way_apart() const {
    const auto& views = world_.state_->views;
    return part_along_boxes(views[ids_[1].index], views[ids_[0].index]).translation();
}

}  // namespace pierce
