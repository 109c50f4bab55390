// Steps on the GPU, positions already there: times beside what was found, and Embree's answer to
// the same frames.
//   pierce_gpu_steps RECORDING|lattice:COUNT|rigid:COUNT|rest:COUNT...
//       [--steps N] [--check N] [--stages] [--builder NAME] [--memory MODE]
//       [--coverage vertices|overlaps|complete] [--reproject on|off]
// A recording's frames are replayed. A lattice is COUNT soft tori that touch their neighbours and
// wobble; in `rigid` they are rigid and turn, and in `rest` they stay where they are. MODE is what
// rays remember of the last step: full (nothing), walk, walk-predict or certified. Prints CSV.
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
#include "scenes/recording/lattice.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce {
namespace {

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

double mean(const std::vector<double>& values) {
    double sum = 0;
    for (double value : values) sum += value;
    return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// A world of a recording's bodies.
struct Player {
    const scenes::Recording& recording;
    World world;
    std::vector<BodyId> bodies;

    Player(const scenes::Recording& played, std::unique_ptr<Backend> backend,
           const Settings& settings)
        : recording(played), world(std::move(backend), settings) {
        std::vector<MeshId> meshes;
        for (const auto& mesh : recording.meshes)
            meshes.push_back(world.add_mesh(mesh.name, mesh.data));
        for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
            const MeshId mesh = meshes[recording.bodies[b].mesh];
            if (deforms(b))
                bodies.push_back(world.add_deforming_body(mesh, recording.positions(b, 0)));
            else
                bodies.push_back(recording.bodies[b].motion == Motion::fixed
                                     ? world.add_fixed_body(mesh, recording.pose(b, 0))
                                     : world.add_rigid_body(mesh, recording.pose(b, 0)));
        }
    }

    bool deforms(std::uint32_t body) const {
        return recording.bodies[body].motion == Motion::deforming;
    }

    void put_rigid(std::uint32_t frame) {
        for (std::uint32_t b = 0; b < bodies.size(); ++b)
            if (recording.bodies[b].motion == Motion::rigid)
                world.set_pose(bodies[b], recording.pose(b, frame));
    }
    void put(std::uint32_t frame) {
        put_rigid(frame);
        for (std::uint32_t b = 0; b < bodies.size(); ++b)
            if (deforms(b)) world.set_positions(bodies[b], recording.positions(b, frame));
    }
};

struct Options {
    std::uint32_t steps = 64, checks = 8;
    bool stages = false;
    std::string builder = "trbvh", memory = "certified";
    Coverage coverage = Settings{}.coverage;
    bool reproject = Settings{}.reproject;
};

Settings settings_of(const Options& options) {
    Settings settings{.coverage = options.coverage, .reproject = options.reproject};
    if (options.memory == "full") settings.temporal = Temporal::off;
    if (options.memory.starts_with("walk")) {
        settings.temporal = Temporal::paper;
        settings.predict = options.memory == "walk-predict";
    }
    return settings;
}

Coverage coverage_named(const std::string& name) {
    if (name == "vertices") return Coverage::vertices;
    return name == "overlaps" ? Coverage::overlaps : Coverage::complete;
}

const char* name_of(Coverage coverage) {
    return coverage == Coverage::vertices   ? "vertices"
           : coverage == Coverage::overlaps ? "overlaps"
                                            : "complete";
}

TreeBuilder builder_named(const std::string& name) {
    if (name == "lbvh") return TreeBuilder::lbvh;
    if (name == "hlbvh") return TreeBuilder::hlbvh;
    return name == "ploc" ? TreeBuilder::ploc : TreeBuilder::trbvh;
}

void run(const std::string& name, const scenes::Recording& recording, const Options& options) {
    const auto& [steps, checks, stages, builder, memory, coverage, reproject] = options;
    Player gpu(recording, cuda_backend({.builder = builder_named(builder), .graph = !stages}),
               settings_of(options));
    std::size_t vertices = 0, triangles = 0;
    std::vector<std::size_t> first;
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        first.push_back(vertices);
        const MeshData& mesh = recording.meshes[recording.bodies[b].mesh].data;
        triangles += mesh.triangles.size();
        if (gpu.deforms(b)) vertices += mesh.positions.size();
    }
    // Two frames in device memory by turns: what is read does not change while it is read.
    cuda::DeviceBuffer<Vec3f> device[2];
    std::vector<Vec3f> staged(vertices);
    for (auto& buffer : device) buffer.resize(static_cast<std::uint32_t>(vertices));

    std::vector<double> wall, on_device, full_rays, walks, lost;
    std::map<std::string, std::vector<double>> by_stage;
    std::vector<std::string> order;
    std::vector<std::uint64_t> hashes;
    StepStats last;
    const auto frame_of_step = [&](std::uint32_t i) { return i % recording.frame_count; };
    for (std::uint32_t i = 0; i < steps; ++i) {
        gpu.put_rigid(frame_of_step(i));
        for (std::uint32_t b = 0; b < recording.bodies.size(); ++b)
            if (gpu.deforms(b))
                std::ranges::copy(recording.positions(b, frame_of_step(i)),
                                  staged.begin() + static_cast<std::ptrdiff_t>(first[b]));
        cuda::check(cudaMemcpy(device[i % 2].data(), staged.data(), vertices * sizeof(Vec3f),
                               cudaMemcpyHostToDevice),
                    "a frame's positions");
        for (std::uint32_t b = 0; b < recording.bodies.size(); ++b)
            if (gpu.deforms(b))
                gpu.world.set_device_positions(gpu.bodies[b], device[i % 2].data() + first[b]);
        last = gpu.world.detect();
        if (i < checks) hashes.push_back(contact_hash(gpu.world.contacts()));
        if (i < 8) continue;  // trees, buffers and graphs come into being
        wall.push_back(last.milliseconds);
        on_device.push_back(last.device_milliseconds);
        full_rays.push_back(last.rays);
        walks.push_back(last.walks);
        lost.push_back(last.lost_walks);
        for (const StageTime& t : last.stages) {
            if (by_stage[name_of(t.stage)].empty()) order.push_back(name_of(t.stage));
            by_stage[name_of(t.stage)].push_back(t.milliseconds);
        }
    }

    std::uint32_t differ = 0;
    std::vector<double> embree;
    if (checks > 0) {
        Player cpu(recording, embree_backend(), settings_of(options));
        for (std::uint32_t i = 0; i < checks; ++i) {
            cpu.put(frame_of_step(i));
            embree.push_back(cpu.world.detect().milliseconds);
            differ += contact_hash(cpu.world.contacts()) != hashes[i];
        }
    }
    std::printf(
        "%s,%zu,%zu,%s,%s,%u,%u,%u,%u,%.4f,%.4f,%.4f,%u,%u,%s,%.4f,%.4f,%.0f,%.0f,%.0f,%s,"
        "%s\n",
        name.c_str(), recording.bodies.size(), triangles, builder.c_str(),
        stages ? "stages" : "graph", last.pairs, last.rays + last.own_rays, last.contacts,
        last.touching_pairs, median(on_device), median(wall), median(embree), checks, differ,
        memory.c_str(), mean(on_device), mean(wall), mean(full_rays), mean(walks), mean(lost),
        name_of(coverage), reproject ? "on" : "off");
    if (stages)
        for (const std::string& stage : order)
            std::printf("# %s %.4f ms\n", stage.c_str(), median(by_stage[stage]));
    std::fflush(stdout);
}

}  // namespace
}  // namespace pierce

int main(int argc, char** argv) {
    pierce::Options options;
    std::vector<std::string> scenes;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--steps" && i + 1 < argc)
            options.steps = static_cast<std::uint32_t>(std::stoul(argv[++i]));
        else if (argument == "--check" && i + 1 < argc)
            options.checks = static_cast<std::uint32_t>(std::stoul(argv[++i]));
        else if (argument == "--builder" && i + 1 < argc)
            options.builder = argv[++i];
        else if (argument == "--memory" && i + 1 < argc)
            options.memory = argv[++i];
        else if (argument == "--coverage" && i + 1 < argc)
            options.coverage = pierce::coverage_named(argv[++i]);
        else if (argument == "--reproject" && i + 1 < argc)
            options.reproject = std::string(argv[++i]) == "on";
        else if (argument == "--stages")
            options.stages = true;
        else
            scenes.push_back(argument);
    }
    options.checks = std::min(options.checks, options.steps);
    std::puts(
        "scene,bodies,triangles,builder,mode,pairs,rays,contacts,touching_pairs,device_ms,wall_ms,"
        "embree_ms,checked,differ,memory,device_mean_ms,wall_mean_ms,mean_full_rays,mean_walks,"
        "mean_lost,coverage,reproject");
    for (const std::string& scene : scenes) {
        using pierce::scenes::LatticeMotion;
        const std::size_t colon = scene.find(':');
        const std::string kind = scene.substr(0, colon);
        if (kind == "lattice" || kind == "rigid" || kind == "rest") {
            const auto count = static_cast<std::uint32_t>(std::stoul(scene.substr(colon + 1)));
            const LatticeMotion motion = kind == "lattice" ? LatticeMotion::soft
                                         : kind == "rigid" ? LatticeMotion::rigid
                                                           : LatticeMotion::rest;
            const std::uint32_t frames = kind != "lattice" ? 32 : count > 2000 ? 4 : 16;
            pierce::run(scene, pierce::scenes::lattice(count, frames, motion), options);
        } else {
            const auto recording = pierce::scenes::as_deforming(
                pierce::scenes::read_recording(scene));
            pierce::scenes::require_lasting_meshes(recording, "pierce_gpu_steps");
            pierce::run(scene.substr(scene.find_last_of('/') + 1), recording, options);
        }
    }
}
