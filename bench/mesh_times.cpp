// How long it takes until a mesh is ready, and how much memory that takes. Prints CSV.
//   pierce_mesh_times THREADS TRIANGLES...
// The mesh is a torus with bumps through which a small copy goes. `add` is add_mesh;
// `first` is that and the first step with inward rays of vertices alone (no edges, no closest
// points, no memory); `certified` is that and the first step with the default settings; `cached` is
// the same if what is measured of the mesh lies in a cache on disk. Each is
// measured three times, with meshes of its own; the least counts. Memory is the most that the
// process has had, with both worlds.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "pierce/embree_backend.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"

namespace {

using namespace pierce;

MeshData bumpy_torus(double triangles) {
    // Five triangles along the ring for each two around the tube are about as high as wide.
    const auto around = static_cast<std::uint32_t>(std::sqrt(triangles / 5)),
               along = static_cast<std::uint32_t>(triangles / 2 / around);
    MeshData mesh = scenes::torus(1, 0.4, along, around);
    for (Vec3f& p : mesh.positions) {
        const Vec3d at = to_double(p);
        const double a = std::atan2(at.y, at.x), b = std::atan2(at.z, std::hypot(at.x, at.y) - 1);
        const Vec3d middle{std::cos(a), std::sin(a), 0};
        p = to_float(middle + (1 + 0.05 * std::sin(7 * a + 3 * b)) * (at - middle));
    }
    return mesh;
}

struct Times {
    double add = std::numeric_limits<double>::infinity();
    double ready = std::numeric_limits<double>::infinity();
};

/// [s] Until the mesh is added, and until a step has run.
Times measure(const MeshData& data, const MeshData& small, int threads, const Settings& settings,
              const std::filesystem::path& cache = {}) {
    using Clock = std::chrono::steady_clock;
    Times best;
    for (int run = 0; run < 3; ++run) {
        World world(embree_backend(threads), settings);
        world.add_rigid_body(world.add_mesh("small", small), {{1.2, 0, 0}, {}});
        world.detect();
        MeshData copy = data;
        const auto seconds = [begin = Clock::now()] {
            return std::chrono::duration<double>(Clock::now() - begin).count();
        };
        const MeshId mesh = world.add_mesh(
            "torus", std::move(copy),
            {.cache = cache, .threads = static_cast<std::uint32_t>(threads)});
        best.add = std::min(seconds(), best.add);
        world.add_rigid_body(mesh, {{0.1, 0, 0}, {}});
        world.detect();
        best.ready = std::min(seconds(), best.ready);
    }
    return best;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fputs("usage: pierce_mesh_times THREADS TRIANGLES...\n", stderr);
        return 2;
    }
    const int threads = std::atoi(argv[1]);
    const MeshData small = bumpy_torus(2000);
    std::puts("triangles,threads,add_ms,first_ms,certified_ms,cached_ms,most_memory_mb");
    const std::filesystem::path cache = std::filesystem::temp_directory_path() /
                                        "pierce_mesh_times";
    for (int k = 2; k < argc; ++k) {
        const MeshData data = bumpy_torus(std::atof(argv[k]));
        const Times first = measure(data, small, threads,
                                    {.coverage = Coverage::vertices,
                                     .reproject = false,
                                     .temporal = Temporal::off}),
                    certified = measure(data, small, threads, {}),
                    cached = measure(data, small, threads, {}, cache);
        std::filesystem::remove_all(cache);
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        std::printf("%zu,%d,%.1f,%.1f,%.1f,%.1f,%.0f\n", data.triangles.size(), threads,
                    1e3 * std::min(first.add, certified.add), 1e3 * first.ready,
                    1e3 * certified.ready, 1e3 * cached.ready,
                    static_cast<double>(usage.ru_maxrss) / 1024);
        std::fflush(stdout);
    }
}
