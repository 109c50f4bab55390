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
    world.add_fixed_body(mesh);
    const pierce::BodyId above = world.add_rigid_body(mesh);
    world.set_pose(above, {.position = {0.25, 0.25, 0.9}, .rotation = {0, 0, 0, 1}});
    world.detect();
    for (const pierce::Contact& c : world.contacts())
        std::printf("vertex %u, depth %.3f, at %.2f %.2f %.2f\n", c.vertex, c.penetration_depth(),
                    c.point_b.x, c.point_b.y, c.point_b.z);
}
