#include <cmath>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/direction.hpp"
#include "core/mesh/edge_normal.hpp"
#include "core/trace/meeting.hpp"
#include "core/world/ray_start.hpp"
#include "core/world/world_state.hpp"
#include "pierce/error.hpp"

namespace pierce {

std::vector<std::optional<RayHit>> World::cast_rays(Vec3d origin,
                                                    std::span<const Vec3d> directions) {
    state_->check_stepped("cast_rays");
    const auto usable = [](Vec3d v) { return is_finite(v); };
    if (!usable(origin) || !std::ranges::all_of(directions, usable))
        throw InputError("cast_rays needs an origin and directions that are finite");
    state_->bring_places(state_->used_bodies());
    state_->backend->fetch_bodies(view_of(state_->views));
    const auto& views = state_->views;
    std::vector<Ray> rays;
    std::vector<std::size_t> line;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const Vec3d direction = unit_along(directions[i]);
        if (length_squared(direction) == 0) continue;
        for (std::uint32_t b = 0; b < views.size(); ++b) {
            if (!views[b].active) continue;
            const Frame to_fit = relative_frame({}, views[b].fit);
            const double start = start_near(views[b].fit_box, to_fit.to_parent(origin),
                                            to_fit.rotation * direction, views[b].touch);
            if (std::isinf(start)) continue;
            const Frame to_space = relative_frame({}, views[b].space);
            Ray ray;
            ray.origin = to_space.to_parent(origin + start * direction);
            ray.direction = to_space.rotation * direction;
            ray.t_max = views[b].fit_box.extent() + 2 * start_before(start, views[b].touch);
            ray.target = b;
            ray.touch = views[b].touch;
            rays.push_back(ray);
            line.push_back(i);
        }
    }
    std::vector<Hit> hits(rays.size());
    state_->backend->closest_hits(view_of(views), view_of(std::as_const(rays)), view_of(hits));

    std::vector<std::optional<RayHit>> nearest(directions.size());
    for (std::size_t r = 0; r < rays.size(); ++r) {
        if (hits[r].triangle == no_triangle) continue;
        const BodyView& body = views[rays[r].target];
        const Meeting m = meet(rays[r], body.surface(), hits[r].triangle);
        const Vec3d at = body.space.to_parent(rays[r].origin + m.t * rays[r].direction);
        const double t = length(at - origin);
        std::optional<RayHit>& best = nearest[line[r]];
        if (best && best->t <= t) continue;
        best = RayHit{.body = state_->ids[rays[r].target],
                      .triangle = hits[r].triangle,
                      .t = t,
                      .normal = body.space.rotation *
                                triangle_normal(body.mesh, body.positions, hits[r].triangle)};
    }
    return nearest;
}

}  // namespace pierce
