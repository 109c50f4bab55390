// Many small worlds in one step, beside a step for each of them. Prints CSV.
//   pierce_worlds KIND WORLDS BACKEND THREADS [STEPS]
// KIND tori: every world has two deforming tori of 600 triangles that overlap and sway; boxes: a
// fixed ground in all worlds and eight boxes that sway on it; box: the same with one box. Times are
// medians over all steps but the first ten; `ratio` is that of each step. `together_ms` and
// `apart_ms` are of detect() alone, `placed_ms` is of setting all places and detect() together.
// Contacts must be the same.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <vector>

#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/method.hpp"
#include "scenes/named/shapes.hpp"
#include "times.hpp"

namespace {

using namespace pierce;
constexpr int phases = 16;  ///< of the swaying, after which it repeats

/// The bodies of one world in every phase.
struct Swaying {
    std::vector<std::shared_ptr<const Mesh>> meshes;
    std::shared_ptr<const Mesh> ground;
    std::vector<std::vector<Pose>> poses;  ///< per phase and body
    std::vector<std::vector<std::vector<Vec3f>>> positions;
    bool deforms = false;

    explicit Swaying(std::string_view kind) : deforms(kind == "tori") {
        const std::size_t bodies = deforms ? 2 : kind == "boxes" ? 8 : 1;
        const auto shape = std::make_shared<const Mesh>(
            "body", deforms ? scenes::torus(0.5, 0.2, 25, 12)
                            : scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}));
        meshes.assign(bodies, shape);
        if (!deforms)
            ground = std::make_shared<const Mesh>("ground",
                                                  scenes::box({-10, -10, -1}, {20, 10, 0}));
        for (int phase = 0; phase < phases; ++phase) {
            const double angle = 2 * 3.14159265358979323846 * phase / phases;
            auto& here = poses.emplace_back();
            auto& there = positions.emplace_back();
            for (std::size_t b = 0; b < bodies; ++b) {
                const auto k = static_cast<double>(b);
                Pose pose{{(deforms ? 0.6 : 0.95) * k, 0.02 * std::sin(angle + k),
                           0.45 + 0.02 * std::cos(angle)},
                          {0.3 * k, 0.1, 0.02 * std::sin(angle), 1}};
                if (!deforms) pose.rotation = {0, 0, 0.02 * std::sin(angle + k), 1};
                here.push_back(pose);
                const Frame frame = frame_of(pose);
                auto& vertices = there.emplace_back();
                for (Vec3f p : shape->positions())
                    vertices.push_back(to_float(frame.to_parent(to_double(p))));
            }
        }
    }

    std::vector<BodyId> add_to(World& world) const {
        if (ground != nullptr) world.add_fixed_body(world.add_mesh(ground));
        std::vector<BodyId> bodies;
        for (const auto& mesh : meshes) {
            const MeshId id = world.add_mesh(mesh);
            bodies.push_back(deforms ? world.add_deforming_body(id) : world.add_rigid_body(id));
        }
        return bodies;
    }
    void place(World& world, const std::vector<BodyId>& bodies, int phase) const {
        const auto at = static_cast<std::size_t>(phase % phases);
        for (std::size_t b = 0; b < bodies.size(); ++b)
            if (deforms)
                world.set_positions(bodies[b], positions[at][b]);
            else
                world.set_pose(bodies[b], poses[at][b]);
    }
};

}  // namespace

int main(int argc, char** argv) try {
    const std::string_view kind = argc > 1 ? argv[1] : "";
    if ((argc != 5 && argc != 6) || (kind != "tori" && kind != "boxes" && kind != "box")) {
        std::fputs("usage: pierce_worlds tori|boxes|box WORLDS BACKEND THREADS [STEPS]\n", stderr);
        return 2;
    }
    const int count = std::atoi(argv[2]), steps = argc == 6 ? std::atoi(argv[5]) : 60;
    scenes::RaySettings rays;
    rays.backend = argv[3];
    rays.threads = std::atoi(argv[4]);
    const Swaying swaying(kind);

    World together(scenes::make_backend(rays), rays.world);
    for (BodyId body : swaying.add_to(together)) together.set_filter(body, {.world = 0});
    if (count > 1) together.replicate(0, static_cast<std::uint32_t>(count - 1));
    std::vector<std::vector<BodyId>> bodies;
    for (std::int32_t w : together.worlds()) bodies.push_back(together.bodies_of(w));
    std::vector<std::unique_ptr<World>> apart;
    std::vector<std::vector<BodyId>> bodies_apart;
    for (int w = 0; w < count; ++w) {
        apart.push_back(std::make_unique<World>(scenes::make_backend(rays), rays.world));
        bodies_apart.push_back(swaying.add_to(*apart.back()));
    }

    std::vector<double> together_ms, apart_ms, placed_ms, ratios;
    std::size_t contacts = 0, contacts_apart = 0;
    for (int step = 0; step < steps; ++step) {
        auto begin = Clock::now();
        for (int w = 0; w < count; ++w)
            swaying.place(together, bodies[static_cast<std::size_t>(w)], step + w);
        const double place = milliseconds_since(begin);
        begin = Clock::now();
        together.detect();
        const double one = milliseconds_since(begin);
        for (int w = 0; w < count; ++w) {
            const auto at = static_cast<std::size_t>(w);
            swaying.place(*apart[at], bodies_apart[at], step + w);
        }
        begin = Clock::now();
        for (const auto& world : apart) world->detect();
        const double many = milliseconds_since(begin);
        contacts += together.contacts().size();
        for (const auto& world : apart) contacts_apart += world->contacts().size();
        if (step < 10) continue;
        together_ms.push_back(one);
        placed_ms.push_back(place + one);
        apart_ms.push_back(many);
        ratios.push_back(many / one);
    }
    const double ms = median(together_ms), placed = median(placed_ms);
    std::puts(
        "kind,worlds,backend,threads,together_ms,placed_ms,apart_ms,ratio,world_steps_per_s,"
        "contacts,contacts_apart");
    std::printf("%s,%d,%s,%d,%.3f,%.3f,%.3f,%.2f,%.0f,%zu,%zu\n", argv[1], count, argv[3],
                rays.threads, ms, placed, median(apart_ms), median(ratios), 1000 * count / placed,
                contacts, contacts_apart);
    return contacts == contacts_apart ? 0 : 1;
} catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
}
