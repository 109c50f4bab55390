#include "physical/scene.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "pierce/error.hpp"
#include "scenes/named/bunny.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::physical {
namespace {

using scenes::SceneMesh;

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;
constexpr double major_radius = 2, minor_radius = 0.5;  ///< of a torus
constexpr std::uint32_t tori = 10;

/// 30 vertices around the hole, and 10 around the tube, with a flat ring on top and below.
SceneMesh torus_mesh() { return scenes::make_scene("tori", {.count = 1}).meshes[1]; }

double torus_half_height() { return minor_radius * std::sin(72 * degree); }

/// A box whose upper side is z = 0.
SceneMesh ground_mesh() { return {"ground", scenes::box({-40, -40, -4}, {40, 40, 0}), {}}; }

Quaternion turn(Vec3d axis, double angle) {
    const Vec3d v = std::sin(angle / 2) * normalized(axis);
    return {v.x, v.y, v.z, std::cos(angle / 2)};
}

/// First `q`, then `p`.
Quaternion operator*(const Quaternion& p, const Quaternion& q) {
    return {p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
            p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x,
            p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w,
            p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z};
}

Vec3d axis_of(const Pose& pose) { return frame_of(pose).rotation * Vec3d{0, 0, 1}; }

Verdict judge_stack(const Ending& ending) {
    bool in_order = true;
    double tilt = 0, aside = 0, last = -std::numeric_limits<double>::infinity();
    for (const Pose& pose : ending.poses.subspan(1)) {
        in_order &= pose.position.z > last + torus_half_height();
        last = pose.position.z;
        tilt = std::max(tilt, std::acos(std::clamp(axis_of(pose).z, -1.0, 1.0)) / degree);
        aside = std::max(aside, std::hypot(pose.position.x, pose.position.y));
    }
    const double full = (2 * tori - 1) * torus_half_height();
    return {in_order && tilt < 5 && aside < minor_radius,
            fmt::format("tilt {:.2f} deg, aside {:.4f}, top {:+.4f}", tilt, aside, last - full)};
}

/// Ten tori, one above the other, with gaps; each is turned about the axis by another angle.
Scene stack(std::uint32_t start) {
    constexpr double gap = 0.1;
    Scene scene{.name = "stack",
                .meshes = {ground_mesh(), torus_mesh()},
                .bodies = {{.mesh = 0, .pose = {}, .fixed = true}},
                .has_ground = true,
                .judge = judge_stack};
    for (std::uint32_t i = 0; i < tori; ++i) {
        const double z = (2 * i + 1) * torus_half_height() + (i + 1) * gap;
        scene.bodies.push_back(
            {.mesh = 1, .pose = {{0, 0, z}, turn({0, 0, 1}, (7.3 + 0.4 * start) * degree * i)}});
    }
    return scene;
}

double reach(const MeshData& mesh, Vec3d direction) {
    double farthest = 0;
    for (Vec3f p : mesh.positions) farthest = std::max(farthest, dot(to_double(p), direction));
    return farthest;
}

/// The direction in which a body reaches least far from its centre of mass: on a horizontal plane
/// it lies on this side with the least energy. Of many directions that are spread evenly.
Vec3d lowest_side(const MeshData& mesh) {
    constexpr int count = 20000;
    Vec3d best;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, angle = 2 * pi * std::numbers::phi * i;
        const double r = std::sqrt(1 - z * z);
        const Vec3d direction{r * std::cos(angle), r * std::sin(angle), z};
        const double here = reach(mesh, direction);
        if (here < least) best = direction;
        least = std::min(least, here);
    }
    return best;
}

Verdict judge_slope(const Ending& ending) {
    constexpr double still = 0.01;
    const Pose &slope = ending.poses[0], &body = ending.poses[1];
    const double height = frame_of(slope).to_local(body.position).z;
    return {ending.moved < still && height > 0,
            fmt::format("height {:.3f}, slid to x {:.3f}", height, body.position.x)};
}

/// A bunny is let go on a slope of 15 degrees, a little above it, lowest side first.
Scene slope(std::uint32_t start) {
    constexpr double angle = 15 * degree;
    const double gap = 0.1 + 0.01 * start;
    Scene scene{.name = "slope",
                .meshes = {ground_mesh(), scenes::bunny_mesh()},
                .bodies = {{.mesh = 0, .pose = {{}, turn({0, 1, 0}, angle)}, .fixed = true}},
                .has_ground = true,
                .judge = judge_slope};
    const MeshData& bunny = scene.meshes[1].data;
    const Vec3d side = lowest_side(bunny), below{0, 0, -1};
    const Quaternion upright = turn(cross(side, below), std::acos(dot(side, below)));
    const Frame frame = frame_of(scene.bodies[0].pose);
    scene.bodies.push_back({.mesh = 1,
                            .pose = {frame.to_parent({0, 0, reach(bunny, side) + gap}),
                                     scene.bodies[0].pose.rotation * upright}});
    return scene;
}

/// True if the middle circles of two tori are linked: one of the two points in which the second
/// circle meets the first one's plane is inside the first circle, and the other is not.
bool are_linked(const Pose& a, const Pose& b) {
    const Vec3d normal = axis_of(a), across = axis_of(b), apart = b.position - a.position;
    const double slope = length(cross(normal, across)), height = dot(apart, normal);
    const double along = slope > 0 ? -height / slope : 0;
    if (!(std::fabs(along) < major_radius) || !(slope > 0)) return false;
    const Vec3d line = normalized(cross(normal, across)), up = cross(across, line);
    const double half = std::sqrt(major_radius * major_radius - along * along);
    const Vec3d middle = apart + along * up;
    const bool first = length(middle + half * line) < major_radius;
    return first != (length(middle - half * line) < major_radius);
}

Verdict judge_chain(const Ending& ending) {
    double farthest = 0;
    std::size_t linked = 0;
    for (std::size_t i = 1; i < ending.poses.size(); ++i) {
        const Pose &a = ending.poses[i - 1], &b = ending.poses[i];
        farthest = std::max(farthest, length(b.position - a.position));
        linked += are_linked(a, b);
    }
    constexpr double taut = 2 * (major_radius - minor_radius);
    return {linked + 1 == ending.poses.size(),
            fmt::format("{} of {} linked, centres {:.3f} (taut {:.1f})", linked,
                        ending.poses.size() - 1, farthest, taut)};
}

/// Ten links in a straight line, 20 degrees to the side of the first one, which is fixed.
Scene chain(std::uint32_t start) {
    constexpr double spacing = 2.9;
    const double side = (20 + 0.5 * start) * degree;
    Scene scene{.name = "chain", .meshes = {torus_mesh()}, .bodies = {}, .judge = judge_chain};
    const Quaternion tilt = turn({0, 1, 0}, side);
    const Vec3d down = rotation_matrix(tilt) * Vec3d{0, 0, -1};
    for (std::uint32_t i = 0; i < tori; ++i) {
        const Vec3d hinge = i % 2 == 0 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
        scene.bodies.push_back(
            {.mesh = 0, .pose = {spacing * i * down, tilt * turn(hinge, pi / 2)}, .fixed = i == 0});
    }
    return scene;
}

Verdict judge_free(const Ending& ending) {
    const double apart = length(ending.poses[1].position - ending.poses[0].position);
    return {true, fmt::format("centres {:.2f} apart", apart)};
}

/// Two tori meet without gravity: the edge of one comes near the hole of the other. Sleep would
/// take their momentum.
Scene free_flight(std::uint32_t start) {
    return {.name = "free",
            .meshes = {torus_mesh()},
            .bodies = {{.mesh = 0,
                        .pose = {{-4, 0.4 + 0.05 * start, 0.3}, turn({1, 0.2, 0.1}, 70 * degree)},
                        .velocity = {3, 0, 0}},
                       {.mesh = 0,
                        .pose = {{4, -0.8, 0}, turn({0.1, 1, 0.3}, 65 * degree)},
                        .velocity = {-2, 0, 0.1}}},
            .gravity = 0,
            .may_sleep = false,
            .judge = judge_free};
}

}  // namespace

std::span<const std::string> scene_names() {
    static const std::array<std::string, 4> names = {"stack", "slope", "chain", "free"};
    return names;
}

Scene make_scene(const std::string& name, std::uint32_t start) {
    if (name == "stack") return stack(start);
    if (name == "slope") return slope(start);
    if (name == "chain") return chain(start);
    if (name == "free") return free_flight(start);
    throw InputError("unknown scene '" + name + "'");
}

}  // namespace pierce::physical
