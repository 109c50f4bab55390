#include <pierce/embree_backend.hpp>
#include <pierce/world.hpp>

#include <cstdio>

int main() {
    pierce::MeshData box;
    for (int k = 0; k < 8; ++k)
        box.positions.push_back({k & 1 ? 1.f : 0.f, k & 2 ? 1.f : 0.f, k & 4 ? 1.f : 0.f});
    box.triangles = {{{0, 2, 3}}, {{0, 3, 1}}, {{4, 5, 7}}, {{4, 7, 6}}, {{0, 1, 5}}, {{0, 5, 4}},
                     {{2, 6, 7}}, {{2, 7, 3}}, {{0, 4, 6}}, {{0, 6, 2}}, {{1, 3, 7}}, {{1, 7, 5}}};

    pierce::World world(pierce::embree_backend());
    const pierce::MeshId mesh = world.add_mesh("box", box);
    world.add_fixed_body(mesh);  // in all worlds
    world.set_filter(world.add_rigid_body(mesh), {.world = 0});
    world.replicate(0, 99);  // worlds 1 to 99
    for (std::int32_t w : world.worlds()) {
        const double height = 0.9 + 0.002 * w;
        world.set_pose(world.bodies_of(w)[0], {{0.25, 0.25, height}, {}});
    }
    world.detect();
    const pierce::WorldOffsets offsets = world.world_offsets();
    for (std::size_t i : {0u, 49u, 60u})
        std::printf("world %d: contacts %u to %u\n", offsets.worlds[i], offsets.solids[i],
                    offsets.solids[i + 1]);
}
