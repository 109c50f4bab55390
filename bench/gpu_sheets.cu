// Layers of cloth on the GPU, positions already there: times beside what was found, and Embree's
// answer to the same steps.
//   pierce_gpu_sheets [--steps N] [--check N] [--stages] [--sheets N] [--nodes N]
// A step's two ends are frames of 1/120 s of the scene `layers`. Prints CSV.
#include <cuda_runtime.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "gpu_cuda/device_buffer.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/cuda_backend.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/world.hpp"
#include "scenes/named/layers.hpp"
#include "scenes/named/shapes.hpp"
#include "times.hpp"

namespace pierce {
namespace {

constexpr double frame_time = 1.0 / 120;

struct Options {
    std::uint32_t steps = 64, checks = 2, nodes = 0;
    bool stages = false;
};

std::vector<BodyId> add_sheets(World& world, const scenes::Layers& layers,
                               const std::vector<Vec3f>& positions) {
    const MeshId mesh = world.add_mesh(
        "sheet", scenes::grid(layers.width, layers.depth, layers.along, layers.across));
    std::vector<BodyId> bodies;
    for (std::uint32_t s = 0; s < layers.sheets; ++s) {
        const std::span<const Vec3f> of_sheet{positions.data() + s * layers.vertex_count(),
                                              layers.vertex_count()};
        bodies.push_back(world.add_deforming_body(mesh, of_sheet));
        world.set_collision(bodies.back(), {SelfCollision::on, true, layers.thickness});
    }
    return bodies;
}

void run(const scenes::Layers& layers, const Options& options) {
    const std::uint32_t vertices = layers.vertex_count();
    std::vector<std::vector<Vec3f>> frames(options.steps + 1);
    std::vector<cuda::DeviceBuffer<Vec3f>> device(frames.size());
    for (std::uint32_t f = 0; f < frames.size(); ++f) {
        frames[f].resize(std::size_t{layers.sheets} * vertices);
        for (std::uint32_t s = 0; s < layers.sheets; ++s)
            layers.positions(s, f * frame_time, {frames[f].data() + s * vertices, vertices});
        device[f].resize(static_cast<std::uint32_t>(frames[f].size()));
        cuda::check(cudaMemcpy(device[f].data(), frames[f].data(), frames[f].size() * sizeof(Vec3f),
                               cudaMemcpyHostToDevice),
                    "a frame's positions");
    }

    World gpu(cuda_backend({.graph = !options.stages}));
    const std::vector<BodyId> bodies = add_sheets(gpu, layers, frames[0]);
    std::vector<double> wall, on_device;
    std::map<std::string, std::vector<double>> by_stage;
    std::vector<std::uint64_t> hashes;
    StepStats last;
    for (std::uint32_t i = 0; i < options.steps; ++i) {
        for (std::uint32_t s = 0; s < layers.sheets; ++s)
            gpu.set_device_motion(bodies[s], device[i].data() + s * vertices,
                                  device[i + 1].data() + s * vertices);
        last = gpu.detect();
        if (i < options.checks) hashes.push_back(contact_hash(gpu.contacts()));
        if (i < 8) continue;  // trees, buffers and graphs come into being
        wall.push_back(last.milliseconds);
        on_device.push_back(last.device_milliseconds);
        for (const StageTime& t : last.stages) {
            by_stage[name_of(t.stage)].push_back(t.milliseconds);
        }
    }

    std::uint32_t differ = 0;
    std::vector<double> embree;
    if (options.checks > 0) {
        World cpu(embree_backend());
        const std::vector<BodyId> same = add_sheets(cpu, layers, frames[0]);
        for (std::uint32_t i = 0; i < options.checks; ++i) {
            for (std::uint32_t s = 0; s < layers.sheets; ++s)
                cpu.set_motion(same[s], std::span(frames[i]).subspan(s * vertices, vertices),
                               std::span(frames[i + 1]).subspan(s * vertices, vertices));
            embree.push_back(cpu.detect().milliseconds);
            differ += contact_hash(cpu.contacts()) != hashes[i];
        }
    }
    std::printf("%u,%u,%s,%u,%u,%u,%u,%.4f,%.4f,%.4f,%u,%u\n", layers.sheets,
                layers.sheets * layers.triangle_count(), options.stages ? "stages" : "graph",
                last.triangle_pairs, last.feature_pairs, last.contacts, last.crossings,
                median(on_device), median(wall), median(embree), options.checks, differ);
    if (options.stages)
        for (const auto& [stage, times] : by_stage)
            std::printf("# %s %.4f ms\n", stage.c_str(), median(times));
    std::fflush(stdout);
}

}  // namespace
}  // namespace pierce

int main(int argc, char** argv) {
    pierce::Options options;
    std::uint32_t sheets = 50;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        const auto number = [&] {
            return i + 1 < argc ? static_cast<std::uint32_t>(std::stoul(argv[++i])) : 0;
        };
        if (argument == "--steps") options.steps = number();
        if (argument == "--check") options.checks = number();
        if (argument == "--nodes") options.nodes = number();
        if (argument == "--sheets") sheets = number();
        if (argument == "--stages") options.stages = true;
    }
    options.checks = std::min(options.checks, options.steps);
    std::puts(
        "sheets,triangles,mode,triangle_pairs,feature_pairs,contacts,crossings,device_ms,wall_ms,"
        "embree_ms,checked,differ");
    pierce::scenes::Layers layers = pierce::scenes::layers_with(options.nodes);
    layers.sheets = sheets;
    pierce::run(layers, options);
}
