#include <algorithm>
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
namespace {

/// A ray of a probe: inward it looks for the way out of a body, outward for the way in.
struct ProbeRay {
    std::size_t probe = 0;
    bool inward = false;
    double start = 0;  ///< [length] how far from the point it starts
};

}  // namespace

std::vector<std::optional<ProbeContact>> World::probe(std::span<const Vec3d> points,
                                                      std::span<const Vec3d> normals, double radius,
                                                      std::span<const BodyId> others) {
    state_->check_stepped("probe");
    if (points.size() != normals.size())
        throw InputError("there are " + std::to_string(points.size()) + " points and " +
                         std::to_string(normals.size()) + " normals");
    const auto usable = [](Vec3d v) { return is_finite(v); };
    if (!std::ranges::all_of(points, usable) || !std::ranges::all_of(normals, usable))
        throw InputError("probe needs points and normals that are finite");
    if (!(radius >= 0) || std::isinf(radius))
        throw InputError("the radius of a probe is negative or not finite");
    for (const BodyId other : others) (void)state_->bodies.get(other, "body");

    state_->bring_places(state_->used_bodies());
    state_->backend->fetch_bodies(view_of(state_->views));
    const auto& views = state_->views;
    std::vector<std::uint32_t> targets;
    for (std::uint32_t b = 0; b < views.size(); ++b)
        if (views[b].active && views[b].is_solid() &&
            (others.empty() || std::ranges::find(others, state_->ids[b]) != others.end()))
            targets.push_back(b);

    std::vector<Ray> rays;
    std::vector<ProbeRay> of_probe;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d normal = unit_along(normals[i]);
        if (length_squared(normal) == 0) continue;
        for (const std::uint32_t b : targets) {
            const Frame to_fit = relative_frame({}, views[b].fit);
            const Box box = views[b].fit_box.inflated(views[b].touch);
            const double away = box.distance(to_fit.to_parent(points[i]));
            if (away > radius) continue;
            const Frame to_space = relative_frame({}, views[b].space);
            const auto add = [&](bool inward, double start, double t_max) {
                Ray ray;
                ray.origin = to_space.to_parent(points[i] + start * normal);
                ray.direction = to_space.rotation * (inward ? -normal : normal);
                ray.t_max = t_max;
                ray.target = b;
                ray.touch = views[b].touch;
                rays.push_back(ray);
                of_probe.push_back({i, inward, start});
            };
            if (away == 0) add(true, 0, box.extent());
            const double start = start_near(views[b].fit_box, to_fit.to_parent(points[i]),
                                            to_fit.rotation * normal, views[b].touch);
            if (start <= radius) add(false, start, radius - start);
        }
    }
    std::vector<Hit> hits(rays.size());
    state_->backend->closest_hits(view_of(views), view_of(std::as_const(rays)), view_of(hits));

    std::vector<std::optional<ProbeContact>> found(points.size());
    for (std::size_t r = 0; r < rays.size(); ++r) {
        if (hits[r].triangle == no_triangle) continue;
        const BodyView& body = views[rays[r].target];
        const Meeting m = meet(rays[r], body.surface(), hits[r].triangle);
        // From outside, the inward ray meets nothing that is pressed against the probe; from
        // inside, the outward ray leaves the body at its far side.
        const auto [probe, inward, start] = of_probe[r];
        if (m.exit != inward) continue;
        const double distance = inward ? -m.t : start + m.t;
        std::optional<ProbeContact>& best = found[probe];
        if (best && best->distance <= distance) continue;
        best = ProbeContact{.body = state_->ids[rays[r].target],
                            .triangle = hits[r].triangle,
                            .distance = distance,
                            .normal = body.space.rotation *
                                      triangle_normal(body.mesh, body.positions, hits[r].triangle)};
    }
    return found;
}

}  // namespace pierce
