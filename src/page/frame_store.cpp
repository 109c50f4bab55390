#include "page/frame_store.hpp"

#include <unordered_set>
#include <utility>

#include "core/mesh/patch.hpp"
#include "pierce/error.hpp"

namespace pierce::page {
namespace {

void append(std::vector<float>& numbers, Vec3f p) {
    numbers.insert(numbers.end(), {p.x, p.y, p.z});
}

/// Per vertex, the number of its patch.
std::vector<std::uint32_t> patches_of(const Mesh& mesh) {
    const MeshView view = mesh.view(MeshNeeds{});
    std::vector<std::uint32_t> result(mesh.positions().size());
    for (std::uint32_t p = 0; p < patch_count(view); ++p)
        for (std::uint32_t i = 0; i < patch_length(view, p); ++i)
            result[view.patch_vertices[patch_begin(p) + i]] = p;
    return result;
}

/// Throws InputError unless places and contacts are of the same step.
void require_step(const World& world) {
    try {
        (void)world.world_offsets();
    } catch (const InputError&) {
        throw InputError(
            "a page shows a world after detect(), and bodies were added, removed, moved or changed "
            "since");
    }
}

/// Handles of all bodies there are.
std::vector<BodyId> bodies_of(const World& world) {
    std::vector<BodyId> result = world.bodies_of(all_worlds);
    for (std::int32_t number : world.worlds()) {
        const std::vector<BodyId> some = world.bodies_of(number);
        result.insert(result.end(), some.begin(), some.end());
    }
    return result;
}

}  // namespace

std::uint32_t FrameStore::number_of_mesh(const World& world, MeshId mesh) {
    const auto [entry, is_new] = mesh_numbers_.emplace(mesh, meshes_.size());
    if (is_new) {
        const Mesh& from = world.mesh(mesh);
        MeshArrays to{.name = from.name(),
                      .closed = from.traits().closed(),
                      .vertices = {},
                      .triangles = {},
                      .patches = {}};
        for (Vec3f p : from.positions()) append(to.vertices, p);
        to.patches = patches_of(from);
        for (const Triangle& t : from.triangles())
            to.triangles.insert(to.triangles.end(), {t.vertex[0], t.vertex[1], t.vertex[2]});
        meshes_.push_back(std::move(to));
    }
    return entry->second;
}

std::uint32_t FrameStore::number_of(const World& world, BodyId body,
                                    const std::map<BodyId, std::string>& names) {
    const auto [entry, is_new] = body_numbers_.emplace(body, bodies_.size());
    if (!is_new) return entry->second;
    const auto named = names.find(body);
    const bool has_name = named != names.end() && !named->second.empty();
    bodies_.push_back({.name = has_name ? named->second : world.mesh(world.mesh_of(body)).name(),
                       .motion = world.motion_of(body),
                       .sheet = world.collision_of(body).sheet});
    return entry->second;
}

void FrameStore::add(World& world, const std::map<BodyId, std::string>& names, bool reasons) {
    require_step(world);
    Frame frame;
    std::unordered_set<BodyId> taken;
    for (const World::BodyBox& box : world.body_boxes()) taken.insert(box.body);
    for (BodyId body : bodies_of(world)) {
        Place place{.body = number_of(world, body, names),
                    .mesh = number_of_mesh(world, world.mesh_of(body)),
                    .left_out = !taken.contains(body)};
        if (world.motion_of(body) == Motion::deforming) {
            for (Vec3d p : world.vertex_positions(body)) append(place.numbers, to_float(p));
        } else {
            const auto& [at, turned] = world.pose_of(body);
            for (double n : {at.x, at.y, at.z, turned.x, turned.y, turned.z, turned.w})
                place.numbers.push_back(static_cast<float>(n));
        }
        frame.places.push_back(std::move(place));
    }
    const std::span<const Contact> contacts = world.contacts();
    frame.contacts.assign(contacts.begin(), contacts.end());
    if (reasons) {
        Reasons found = reasons_of(world);
        frame.reasons = std::move(found.list);
        has_all_reasons_ = has_all_reasons_ && found.has_all;
    }
    frames_.push_back(std::move(frame));
}

}  // namespace pierce::page
