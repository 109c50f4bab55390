#include "pierce/c/body.h"

#include <utility>

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/versioned.hpp"
#include "c_api/world_state.hpp"

namespace pierce::c {
namespace {

static_assert(PIERCE_FIXED == static_cast<int>(Motion::fixed) &&
              PIERCE_RIGID == static_cast<int>(Motion::rigid) &&
              PIERCE_DEFORMING == static_cast<int>(Motion::deforming));
static_assert(PIERCE_SELF_OFF == static_cast<int>(SelfCollision::off) &&
              PIERCE_SELF_ON == static_cast<int>(SelfCollision::on) &&
              PIERCE_SELF_RAYS == static_cast<int>(SelfCollision::rays) &&
              PIERCE_SELF_PUBLISHED == static_cast<int>(SelfCollision::published));
static_assert(PIERCE_ALL_WORLDS == all_worlds);

pierce_collision collision_of(const Collision& c) {
    return {.struct_size = sizeof(pierce_collision),
            .self = static_cast<std::uint32_t>(c.self),
            .sheet = c.sheet,
            .thickness = c.thickness,
            .margin = c.margin};
}

pierce_filter filter_of(const Filter& f) {
    return {.struct_size = sizeof(pierce_filter),
            .groups = f.groups,
            .meets = f.meets,
            .chain = f.chain,
            .world = f.world};
}

Pose pose_or_none(const double* pose) { return pose == nullptr ? Pose{} : pose_of(pose, "pose"); }

}  // namespace
}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_add_fixed_body(pierce_world* world, pierce_mesh_id mesh, const double* pose,
                                    pierce_body_id* body) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(body, "body");
        *body = number(inner.add_fixed_body(mesh_handle(mesh), pose_or_none(pose)));
    });
}

pierce_status pierce_add_rigid_body(pierce_world* world, pierce_mesh_id mesh, const double* pose,
                                    pierce_body_id* body) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(body, "body");
        *body = number(inner.add_rigid_body(mesh_handle(mesh), pose_or_none(pose)));
    });
}

pierce_status pierce_add_deforming_body(pierce_world* world, pierce_mesh_id mesh,
                                        const float* positions, size_t vertex_count,
                                        pierce_body_id* body) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(body, "body");
        if (positions != nullptr && vertex_count == 0)
            throw pierce::InputError("positions has no elements");
        *body = number(inner.add_deforming_body(mesh_handle(mesh),
                                                vectors(positions, vertex_count, "positions")));
    });
}

pierce_status pierce_remove_body(pierce_world* world, pierce_body_id body) {
    return guarded([&] { world_of(world).remove_body(body_handle(body)); });
}

pierce_status pierce_set_mesh(pierce_world* world, pierce_body_id body, pierce_mesh_id mesh,
                              const float* positions, size_t vertex_count) {
    return guarded([&] {
        auto& inner = world_of(world);
        const auto points = vectors(positions, vertex_count, "positions");
        if (points.empty())
            inner.set_mesh(body_handle(body), mesh_handle(mesh));
        else
            inner.set_mesh(body_handle(body), mesh_handle(mesh), points);
    });
}

pierce_status pierce_mesh_of(const pierce_world* world, pierce_body_id body, pierce_mesh_id* mesh) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(mesh, "mesh") = number(inner.mesh_of(body_handle(body)));
    });
}

pierce_status pierce_motion_of(const pierce_world* world, pierce_body_id body, uint32_t* motion) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(motion, "motion") = static_cast<std::uint32_t>(inner.motion_of(body_handle(body)));
    });
}

pierce_status pierce_vertex_position(const pierce_world* world, pierce_body_id body,
                                     uint32_t vertex, double* position) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(position, "position");
        const pierce::Vec3d at = inner.vertex_position(body_handle(body), vertex);
        for (int k = 0; k < 3; ++k) position[k] = at[k];
    });
}

pierce_status pierce_vertex_positions(const pierce_world* world, pierce_body_id body,
                                      double* positions, size_t vertex_count) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(positions, "positions");
        const std::vector<pierce::Vec3d> all = inner.vertex_positions(body_handle(body));
        if (vertex_count != all.size())
            throw pierce::InputError("the body has " + std::to_string(all.size()) +
                                     " vertices, and there is room for " +
                                     std::to_string(vertex_count));
        for (const pierce::Vec3d& at : all)
            for (int k = 0; k < 3; ++k) *positions++ = at[k];
    });
}

pierce_status pierce_pose_of(const pierce_world* world, pierce_body_id body, double* pose) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(pose, "pose");
        const auto& [at, turned] = inner.pose_of(body_handle(body));
        for (double number : {at.x, at.y, at.z, turned.x, turned.y, turned.z, turned.w})
            *pose++ = number;
    });
}

pierce_status pierce_default_collision(pierce_collision* collision, size_t struct_size) {
    return guarded([&] {
        write_defaults(collision_of(pierce::Collision{}), collision, struct_size, "collision");
    });
}

pierce_status pierce_set_collision(pierce_world* world, pierce_body_id body,
                                   const pierce_collision* collision) {
    return guarded([&] {
        auto& inner = world_of(world);
        const pierce_collision c = read_struct(collision, collision_of(pierce::Collision{}),
                                               "collision");
        inner.set_collision(
            body_handle(body),
            {.self = enumerated(c.self, pierce::SelfCollision::published, "collision.self"),
             .sheet = c.sheet != 0,
             .thickness = c.thickness,
             .margin = c.margin});
    });
}

pierce_status pierce_collision_of(const pierce_world* world, pierce_body_id body,
                                  pierce_collision* collision) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(collision, "collision");
        write_struct(collision_of(inner.collision_of(body_handle(body))), collision);
    });
}

pierce_status pierce_default_filter(pierce_filter* filter, size_t struct_size) {
    return guarded(
        [&] { write_defaults(filter_of(pierce::Filter{}), filter, struct_size, "filter"); });
}

pierce_status pierce_set_filter(pierce_world* world, pierce_body_id body,
                                const pierce_filter* filter) {
    return guarded([&] {
        auto& inner = world_of(world);
        const pierce_filter f = read_struct(filter, filter_of(pierce::Filter{}), "filter");
        inner.set_filter(
            body_handle(body),
            {.groups = f.groups, .meets = f.meets, .chain = f.chain, .world = f.world});
    });
}

pierce_status pierce_filter_of(const pierce_world* world, pierce_body_id body,
                               pierce_filter* filter) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(filter, "filter");
        write_struct(filter_of(inner.filter_of(body_handle(body))), filter);
    });
}

pierce_status pierce_exclude(pierce_world* world, pierce_body_id a, pierce_body_id b) {
    return guarded([&] { world_of(world).exclude(body_handle(a), body_handle(b)); });
}

pierce_status pierce_excluded_pairs(pierce_world* world, const pierce_body_pair** pairs,
                                    size_t* count) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(pairs, "pairs");
        required(count, "count");
        std::vector<pierce_body_pair> found;
        for (const auto& [a, b] : inner.excluded_pairs()) found.push_back({number(a), number(b)});
        world->excluded_pairs = std::move(found);
        *pairs = world->excluded_pairs.data();
        *count = world->excluded_pairs.size();
    });
}

pierce_status pierce_include(pierce_world* world, pierce_body_id a, pierce_body_id b) {
    return guarded([&] { world_of(world).include(body_handle(a), body_handle(b)); });
}

pierce_status pierce_set_pair_filter(pierce_world* world, pierce_pair_filter filter, void* user) {
    return guarded([&] {
        pierce::PairFilter asked;
        if (filter != nullptr)
            asked = [filter, user](pierce::BodyId a, pierce::BodyId b) {
                return filter(number(a), number(b), user) != 0;
            };
        world_of(world).set_pair_filter(std::move(asked));
    });
}
