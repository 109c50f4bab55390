// Rays aimed at vertices and edges from inside a closed mesh: how many slip out. Prints CSV.
//   pierce_leaks [rays [kernel_rays]]
// First the library's tracer, `rays` in all (default 10^7), at the origin and at 1e5. Then single
// triangle tests, `kernel_rays` each (default 20000), at offsets of 0 and 2^0 to 2^24.
#include "scenes/measure/leaks.hpp"

#include <cstdio>
#include <cstdlib>

namespace {

using pierce::scenes::Aim;
using pierce::scenes::LeakCount;

void print(const LeakCount& c) {
    std::printf("%.0f,%s,%s,%s,%zu,%zu\n", c.offset, c.kernel.c_str(), c.fma ? "on" : "off",
                c.aim == Aim::vertices ? "vertices" : "edges", c.rays, c.leaks);
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    const std::size_t rays = argc > 1 ? static_cast<std::size_t>(std::atoll(argv[1])) : 10'000'000;
    const std::size_t kernel_rays = argc > 2 ? static_cast<std::size_t>(std::atoll(argv[2]))
                                             : 20'000;
    std::puts("offset,kernel,fma,target,rays,leaks");
    for (double offset : {0.0, 1e5})
        for (Aim aim : {Aim::vertices, Aim::edges})
            print(pierce::scenes::count_tracer_leaks(offset, aim, rays / 4));
    for (double offset : pierce::scenes::leak_offsets())
        for (Aim aim : {Aim::vertices, Aim::edges})
            for (const LeakCount& count :
                 pierce::scenes::count_kernel_leaks(offset, aim, kernel_rays))
                print(count);
}
