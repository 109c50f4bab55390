// A row of octahedra over several processes: mpirun -n 3 ./ranks
#include <pierce/embree_backend.hpp>
#include <pierce/mpi/world.hpp>

#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

pierce::MeshData octahedron() {
    return {
        {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

void run() {
    pierce::mpi::World world(MPI_COMM_WORLD, pierce::embree_backend(1));
    const pierce::MeshId mesh = world.add_mesh("octahedron", octahedron());
    // Body n belongs to rank n % ranks at first.
    for (int n = world.rank(); n < 12; n += world.ranks())
        world.add_rigid_body(static_cast<std::uint32_t>(n), mesh, {{1.9 * n, 0, 0}, {}});
    // Neighbours together: every rank gets a piece of the row.
    world.migrate();
    for (int step = 0; step < 3; ++step) {
        for (const pierce::BodyId body : world.bodies())
            world.set_pose(body, {{1.9 * body.index, 0.01 * step, 0}, {}});
        world.detect();
        const std::vector<pierce::Contact> all = world.gather_contacts();
        if (world.rank() == 0) std::printf("step %d: %zu contacts\n", step, all.size());
    }
}

}  // namespace

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    run();  // the world ends before MPI does
    MPI_Finalize();
}
