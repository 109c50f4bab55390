// Steps of a world over the ranks of MPI: mpirun -n RANKS pierce_ranks COUNT... [--steps N]
//   [--threads N] [--rigid] [--exchange]
// A lattice of COUNT soft tori that touch their neighbours and wobble, or rigid ones that turn;
// every rank has the same number of threads. Prints CSV: the median of what a step takes on the
// slowest rank, how much of that is detection on its own bodies, how uneven the work is, and what
// was found. With --exchange, it prints instead what it takes that every rank sends so many bytes
// to every other one, as a step does.
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "mpi/communicator.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/mpi/world.hpp"
#include "scenes/recording/lattice.hpp"
#include "times.hpp"

namespace pierce {
namespace {

/// The largest value of all ranks.
double most(double value) {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return value;
}

constexpr std::uint32_t frames = 8;

void run(std::uint32_t count, std::uint32_t steps, int threads, bool rigid) {
    const scenes::Recording lattice = scenes::lattice(
        count, frames, rigid ? scenes::LatticeMotion::rigid : scenes::LatticeMotion::soft);
    mpi::World world(MPI_COMM_WORLD, embree_backend(threads));
    const MeshId mesh = world.add_mesh("torus", lattice.meshes[0].data);
    for (std::uint32_t b = 0; b < count; ++b) {
        if (b % static_cast<std::uint32_t>(world.ranks()) !=
            static_cast<std::uint32_t>(world.rank()))
            continue;
        if (rigid)
            world.add_rigid_body(b, mesh, lattice.pose(b, 0));
        else
            world.add_deforming_body(b, mesh, lattice.positions(b, 0));
    }
    world.migrate();
    std::vector<double> whole, own;
    for (std::uint32_t step = 0; step < steps; ++step) {
        // There and back again.
        const std::uint32_t at = step % (2 * frames - 2), frame = std::min(at, 2 * frames - 2 - at);
        for (const BodyId body : world.bodies())
            if (rigid)
                world.set_pose(body, lattice.pose(body.index, frame));
            else
                world.set_positions(body, lattice.positions(body.index, frame));
        MPI_Barrier(MPI_COMM_WORLD);
        const auto begin = std::chrono::steady_clock::now();
        world.detect();
        const double took = most(milliseconds_since(begin)),
                     its_own = most(world.stats().milliseconds);
        // The first steps make trees and plans.
        if (step < 4) continue;
        whole.push_back(took);
        own.push_back(its_own);
    }
    const std::vector<Contact> all = world.gather_contacts();
    const double uneven = world.uneven();
    if (world.rank() == 0)
        std::printf("%s:%u,%d,%d,%.3f,%.3f,%.3f,%zu,%016llx\n", rigid ? "rigid" : "lattice", count,
                    world.ranks(), threads, median(whole), median(own), uneven, all.size(),
                    static_cast<unsigned long long>(contact_hash(all)));
}

void exchange(std::size_t bytes, std::uint32_t times) {
    const mpi::Communicator comm(MPI_COMM_WORLD);
    std::vector<double> took;
    for (std::uint32_t i = 0; i < times; ++i) {
        std::vector<std::string> to(static_cast<std::size_t>(comm.size()), std::string(bytes, 'x'));
        MPI_Barrier(MPI_COMM_WORLD);
        const auto begin = std::chrono::steady_clock::now();
        mpi::Exchange(comm, std::move(to)).finish();
        took.push_back(most(milliseconds_since(begin)));
    }
    if (comm.rank() == 0)
        std::printf("%d,%zu,%.1f\n", comm.size(), bytes, 1e3 * median(std::move(took)));
}

}  // namespace
}  // namespace pierce

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    int rank = 0, threads = 1;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    std::uint32_t steps = 40;
    bool rigid = false, exchanges = false;
    std::vector<std::uint32_t> counts;
    const auto number = [](const char* text) {
        return static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
    };
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--rigid")
            rigid = true;
        else if (word == "--exchange")
            exchanges = true;
        else if (word == "--steps" && i + 1 < argc)
            steps = number(argv[++i]);
        else if (word == "--threads" && i + 1 < argc)
            threads = static_cast<int>(number(argv[++i]));
        else
            counts.push_back(number(argv[i]));
    }
    if (exchanges) {
        if (rank == 0) std::puts("ranks,bytes,us");
        for (const std::uint32_t bytes : counts) pierce::exchange(bytes, steps);
        MPI_Finalize();
        return 0;
    }
    if (rank == 0) std::printf("scene,ranks,threads,ms,own_ms,uneven,contacts,hash\n");
    for (const std::uint32_t count : counts) pierce::run(count, steps, threads, rigid);
    MPI_Finalize();
}
