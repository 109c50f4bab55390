// Two groups of threads share a world; the first one takes two thirds of the work.
#include <pierce/embree_backend.hpp>
#include <pierce/partitioned_backend.hpp>
#include <pierce/world.hpp>

#include <cstdio>
#include <utility>
#include <vector>

int main() {
    std::vector<pierce::Part> parts;
    parts.push_back({.backend = pierce::embree_backend(1), .share = 2});
    parts.push_back({.backend = pierce::embree_backend(1), .share = 1});
    pierce::World world(pierce::partitioned_backend(std::move(parts)));

    const pierce::MeshId mesh = world.add_mesh(
        "octahedron",
        {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
         {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}});
    for (int n = 0; n < 12; ++n) world.add_rigid_body(mesh, {{1.9 * n, 0, 0}, {}});
    world.detect();

    std::printf("%zu contacts\n", world.contacts().size());
    for (const pierce::PlannedPart& part : world.plan().parts)
        std::printf("%s: %u bodies and %u ghosts\n", part.backend.c_str(), part.bodies,
                    part.ghosts);
}
