#include "pierce/c/places.h"

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/world_state.hpp"

namespace pierce::c {
namespace {

template <class T>
pierce_status set_poses(pierce_world* world, const pierce_body_id* bodies, std::size_t body_count,
                        const T* poses) {
    return guarded([&] {
        auto& inner = world_of(world);
        const auto handles = body_handles(bodies, body_count, "bodies");
        if (body_count > 0) required(poses, "poses");
        inner.set_poses(handles, std::span<const T>(poses, 7 * body_count));
    });
}

}  // namespace
}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_set_pose(pierce_world* world, pierce_body_id body, const double* pose) {
    return guarded([&] { world_of(world).set_pose(body_handle(body), pose_of(pose, "pose")); });
}

pierce_status pierce_set_poses(pierce_world* world, const pierce_body_id* bodies, size_t body_count,
                               const double* poses) {
    return set_poses(world, bodies, body_count, poses);
}

pierce_status pierce_set_poses_float(pierce_world* world, const pierce_body_id* bodies,
                                     size_t body_count, const float* poses) {
    return set_poses(world, bodies, body_count, poses);
}

pierce_status pierce_set_positions(pierce_world* world, pierce_body_id body, const float* positions,
                                   size_t vertex_count) {
    return guarded([&] {
        auto& inner = world_of(world);
        inner.set_positions(body_handle(body), vectors(positions, vertex_count, "positions"));
    });
}

pierce_status pierce_set_positions_many(pierce_world* world, const pierce_body_id* bodies,
                                        size_t body_count, const float* positions,
                                        size_t vertex_count) {
    return guarded([&] {
        auto& inner = world_of(world);
        const auto handles = body_handles(bodies, body_count, "bodies");
        inner.set_positions(handles, vectors(positions, vertex_count, "positions"));
    });
}

pierce_status pierce_set_motion(pierce_world* world, pierce_body_id body, const float* start,
                                const float* positions, size_t vertex_count) {
    return guarded([&] {
        auto& inner = world_of(world);
        inner.set_motion(body_handle(body), vectors(start, vertex_count, "start"),
                         vectors(positions, vertex_count, "positions"));
    });
}

pierce_status pierce_set_motion_poses(pierce_world* world, pierce_body_id body, const double* start,
                                      const double* pose) {
    return guarded([&] {
        auto& inner = world_of(world);
        inner.set_motion(body_handle(body), pose_of(start, "start"), pose_of(pose, "pose"));
    });
}

pierce_status pierce_forget_sides(pierce_world* world) {
    return guarded([&] { world_of(world).forget_sides(); });
}
