#include "scenes/recording/small_worlds.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

/// A body of one world: its mesh, and where it is at a time that repeats after 1.
struct Part {
    std::uint32_t mesh = 0;
    Motion motion = Motion::rigid;
    std::uint32_t chain = 0;
    std::function<Pose(double)> pose;
};

struct Parts {
    std::vector<SceneMesh> meshes;
    std::vector<Part> parts;
};

Quaternion turn(Vec3d axis, double angle) {
    const Vec3d v = std::sin(angle / 2) * normalized(axis);
    return {v.x, v.y, v.z, std::cos(angle / 2)};
}

Parts tori() {
    Parts world{{{"torus", torus(0.5, 0.2, 25, 12), {}}}, {}};
    for (int k = 0; k < 2; ++k)
        world.parts.push_back({0, Motion::deforming, 0, [k](double t) {
                                   return Pose{{0.6 * k, 0.02 * std::sin(two_pi * t + k),
                                                0.02 * std::cos(two_pi * t)},
                                               {0.3 * k, 0.1, 0.02 * std::sin(two_pi * t), 1}};
                               }});
    return world;
}

/// A palm, five fingers of three links with a claw each but for the thumb's, all of one chain, and
/// a ring in their grip.
Parts hand() {
    Parts world{{{"palm", box({-0.5, -0.45, -0.1}, {0.5, 0.45, 0.1}), {}},
                 {"link", capsule(0.09, 0.14, 12, 6), {}},
                 {"claw", torus(0.12, 0.05, 16, 8), {}},
                 {"ring", torus(0.42, 0.16, 30, 12), {}}},
                {}};
    const auto add = [&](std::uint32_t mesh, std::uint32_t chain,
                         const std::function<Pose(double)>& pose) {
        world.parts.push_back({mesh, Motion::rigid, chain, pose});
    };
    add(0, 1, [](double) { return Pose{}; });
    for (int finger = 0; finger < 5; ++finger) {
        const double around = two_pi * finger / 5;
        const auto joint = [around](double t, int link, double radius) {
            const double grip = 0.06 * std::sin(two_pi * t + around);
            const double r = radius - grip * link;
            return Pose{{r * std::cos(around), r * std::sin(around), 0.25 + 0.4 * link},
                        turn({-std::sin(around), std::cos(around), 0}, -0.25 * link + grip)};
        };
        for (int link = 0; link < 3; ++link)
            add(1, 1, [joint, link](double t) { return joint(t, link, 0.62); });
        if (finger < 4) add(2, 1, [joint](double t) { return joint(t, 2, 0.5); });
    }
    add(3, 0, [](double t) {
        return Pose{{0.03 * std::sin(two_pi * t), 0.03 * std::cos(two_pi * t), 0.62},
                    turn({1, 1, 0}, 0.1 * std::sin(two_pi * t))};
    });
    return world;
}

/// How a thread goes in and out along its pitch, between 0 and 1.
double ridge(double turns) {
    const double at = turns - std::floor(turns);
    return 1 - std::fabs(2 * at - 1);
}

/// Rings of vertices one after the other, with quads between them; `closed`: also from the last to
/// the first.
MeshData rings_mesh(std::uint32_t around, std::uint32_t rings, bool closed,
                    const std::function<Vec3d(double, std::uint32_t)>& place) {
    MeshData mesh;
    for (std::uint32_t r = 0; r < rings; ++r)
        for (std::uint32_t k = 0; k < around; ++k)
            mesh.positions.push_back(to_float(place(two_pi * k / around, r)));
    for (std::uint32_t r = 0; r + (closed ? 0 : 1) < rings; ++r)
        for (std::uint32_t k = 0; k < around; ++k) {
            const std::uint32_t next = (k + 1) % around, above = (r + 1) % rings;
            const std::uint32_t a = r * around + k, b = r * around + next,
                                c = above * around + next, d = above * around + k;
            mesh.triangles.push_back({{a, b, c}});
            mesh.triangles.push_back({{a, c, d}});
        }
    return mesh;
}

constexpr std::uint32_t thread_around = 48;
constexpr double pitch = 0.25, thread_depth = 0.12, thread_radius = 0.5;

/// A threaded rod, closed by fans.
MeshData bolt() {
    constexpr std::uint32_t rings = 60;
    MeshData mesh = rings_mesh(thread_around, rings, false, [](double angle, std::uint32_t r) {
        const double z = 2.0 * r / (rings - 1) - 1;
        const double radius = thread_radius + thread_depth * ridge(z / pitch - angle / two_pi);
        return Vec3d{radius * std::cos(angle), radius * std::sin(angle), z};
    });
    const auto below = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back({0, 0, -1});
    mesh.positions.push_back({0, 0, 1});
    const std::uint32_t last = (rings - 1) * thread_around;
    for (std::uint32_t k = 0; k < thread_around; ++k) {
        const std::uint32_t next = (k + 1) % thread_around;
        mesh.triangles.push_back({{below, next, k}});
        mesh.triangles.push_back({{below + 1, last + k, last + next}});
    }
    return mesh;
}

/// A ring with the same thread inside, a little wider.
MeshData nut() {
    constexpr std::uint32_t inner = 40, outer = 16;
    constexpr double half = 0.5, gap = 0.004;
    return rings_mesh(thread_around, inner + outer, true, [](double angle, std::uint32_t r) {
        // The hole from its top to its bottom, and back along the outside.
        const bool in_hole = r < inner;
        const double z = in_hole ? half - 2 * half * r / (inner - 1)
                                 : -half + 2 * half * (r - inner) / (outer - 1);
        const double radius = in_hole ? thread_radius + gap +
                                            thread_depth * ridge(z / pitch - angle / two_pi)
                                      : 1.0;
        return Vec3d{radius * std::cos(angle), radius * std::sin(angle), z};
    });
}

Parts nut_on_bolt() {
    Parts world{{{"bolt", bolt(), {}}, {"nut", nut(), {}}}, {}};
    world.parts.push_back({0, Motion::rigid, 0, [](double) { return Pose{}; }});
    // It turns back and forth along the thread, and hangs on it by its weight.
    world.parts.push_back(
        {1, Motion::rigid, 0, [](double t) {
             const double angle = 0.3 * std::sin(two_pi * t);
             return Pose{{0, 0, pitch * angle / two_pi - 0.012}, turn({0, 0, 1}, angle)};
         }});
    return world;
}

}  // namespace

std::optional<SmallWorld> small_world_named(std::string_view name) {
    if (name == "tori") return SmallWorld::tori;
    if (name == "hand") return SmallWorld::hand;
    if (name == "nut") return SmallWorld::nut;
    return {};
}

SmallWorlds small_worlds(SmallWorld kind, std::uint32_t count, std::uint32_t frames) {
    const Parts world = kind == SmallWorld::tori   ? tori()
                        : kind == SmallWorld::hand ? hand()
                                                   : nut_on_bolt();
    SmallWorlds made;
    made.recording.dt = SceneSetup{}.dt;
    made.recording.frame_count = frames;
    made.recording.meshes = world.meshes;
    for (std::uint32_t w = 0; w < count; ++w)
        for (const Part& part : world.parts) {
            RecordedBody body{.name = world.meshes[part.mesh].name,
                              .mesh = part.mesh,
                              .motion = part.motion,
                              .values = {}};
            for (std::uint32_t f = 0; f < frames; ++f) {
                const Pose pose = part.pose(static_cast<double>((f + w) % frames) / frames);
                if (part.motion != Motion::deforming) {
                    for (double value :
                         {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x,
                          pose.rotation.y, pose.rotation.z, pose.rotation.w})
                        body.values.push_back(static_cast<float>(value));
                    continue;
                }
                const Frame frame = frame_of(pose);
                for (Vec3f p : world.meshes[part.mesh].data.positions) {
                    const Vec3d q = frame.to_parent(to_double(p));
                    for (int k = 0; k < 3; ++k) body.values.push_back(static_cast<float>(q[k]));
                }
            }
            made.recording.bodies.push_back(std::move(body));
            made.filters.push_back({.chain = part.chain, .world = static_cast<std::int32_t>(w)});
        }
    return made;
}

}  // namespace pierce::scenes
