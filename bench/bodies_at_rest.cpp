// What bodies at rest cost. Prints CSV.
//   pierce_bodies_at_rest BODIES THREADS [STEPS]
// Rigid tori of 600 triangles on a grid, turned and shifted at random (seed 1), so that each
// overlaps its neighbours. All of them, a hundredth, one, or none sway by a thousandth of their
// width. Times are medians over all steps but the first ones: the step, and the call that reads all
// contacts after it.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "times.hpp"

namespace {

using namespace pierce;

/// Not measured: caches fill, the step after a motion; and bodies come to rest.
constexpr int first_steps = 3, steps_to_rest = 40;

}  // namespace

int main(int argc, char** argv) try {
    if (argc != 3 && argc != 4) {
        std::fputs("usage: pierce_bodies_at_rest BODIES THREADS [STEPS]\n", stderr);
        return 2;
    }
    const int count = std::atoi(argv[1]), threads = std::atoi(argv[2]),
              steps = argc == 4 ? std::atoi(argv[3]) : 13;
    World world(embree_backend(threads));
    const MeshId mesh = world.add_mesh("torus", scenes::torus(0.5, 0.2, 25, 12));
    std::mt19937 random(1);
    std::uniform_real_distribution<double> one(-1, 1);
    std::vector<BodyId> bodies;
    std::vector<Pose> poses;
    const int side = static_cast<int>(std::ceil(std::cbrt(count)));
    for (int i = 0; i < count; ++i) {
        const std::array<int, 3> place{i % side, i / side % side, i / (side * side)};
        Pose pose;
        for (int k = 0; k < 3; ++k)
            pose.position[k] = 0.85 * place[static_cast<std::size_t>(k)] + 0.1 * one(random);
        pose.rotation = {one(random), one(random), one(random), 1};
        poses.push_back(pose);
        bodies.push_back(world.add_rigid_body(mesh, pose));
    }
    std::puts("bodies,moving,threads,pairs,contacts,step_ms,contacts_ms");
    for (const int moving : {count, count / 100, 1, 0}) {
        std::vector<double> times, reading;
        const int first = moving == count ? first_steps : steps_to_rest;
        for (int step = 0; step < steps + first; ++step) {
            for (int i = 0; i < moving; ++i) {
                const auto k = static_cast<std::size_t>(i);
                poses[k].position.x += step % 2 == 0 ? 0.0014 : -0.0014;
                world.set_pose(bodies[k], poses[k]);
            }
            const double ms = world.detect().milliseconds;
            const auto begin = std::chrono::steady_clock::now();
            if (world.contacts().size() != world.stats().contacts)
                throw InputError("the step does not count its contacts");
            if (step < first) continue;
            times.push_back(ms);
            reading.push_back(
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                    .count());
        }
        std::printf("%d,%d,%d,%u,%u,%.2f,%.2f\n", count, moving, threads, world.stats().pairs,
                    world.stats().contacts, median(times), median(reading));
    }
    return 0;
} catch (const pierce::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
