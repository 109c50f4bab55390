// Steps on the GPU, places already there: times beside what was found, and Embree's answer to the
// same frames.
//   pierce_gpu_steps
//   RECORDING|lattice:COUNT|tower:COUNT|rigid:COUNT|rest:COUNT|tori:COUNT|hand:COUNT|nut:COUNT...
//       [--steps N] [--check N] [--stages] [--builder NAME] [--memory MODE]
//       [--coverage vertices|overlaps|complete] [--reproject on|off] [--devices N]
//       [--margin LENGTH] [--host-share S]
// A recording's frames are replayed. A lattice is COUNT soft tori that touch their neighbours and
// wobble; a tower is one of 25 x 25 in each layer, so that twice as many have twice as much to do;
// in `rigid` they are rigid and turn, and in `rest` they stay where they are. The last three are
// COUNT small worlds (scenes/recording/small_worlds.hpp). Places are named once and then only
// written, so that the host does nothing per body. MODE is what rays remember of the last step:
// full (nothing), walk, walk-predict or certified. With several devices, each has the places of the
// bodies that it owns. With a host's share, places are written on the host, and Embree does so much
// of one device's work beside it; 0 is for comparison. Prints CSV.
#include <cuda_runtime.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/partition/space_partition.hpp"
#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/on_device.hpp"
#include "pierce/box.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/cuda_backend.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/plan.hpp"
#include "pierce/world.hpp"
#include "scenes/recording/lattice.hpp"
#include "scenes/recording/recording.hpp"
#include "scenes/recording/small_worlds.hpp"
#include "times.hpp"

namespace pierce {
namespace {

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

    Player(const scenes::Recording& played, const std::vector<Filter>& filters,
           std::unique_ptr<Backend> backend, const Settings& settings)
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
            if (!filters.empty()) world.set_filter(bodies.back(), filters[b]);
        }
    }

    bool deforms(std::uint32_t body) const {
        return recording.bodies[body].motion == Motion::deforming;
    }

    void put(std::uint32_t frame) {
        for (std::uint32_t b = 0; b < bodies.size(); ++b)
            if (deforms(b))
                world.set_positions(bodies[b], recording.positions(b, frame));
            else if (recording.bodies[b].motion == Motion::rigid)
                world.set_pose(bodies[b], recording.pose(b, frame));
    }
};

/// An array on the current device that other devices may read.
template <class T>
class ReadableArray {
public:
    explicit ReadableArray(std::size_t count) {
        cuda::check(cudaMalloc(&data_, std::max<std::size_t>(count, 1) * sizeof(T)),
                    "an array of places");
    }
    ReadableArray(ReadableArray&& other) noexcept : data_(std::exchange(other.data_, nullptr)) {}
    ~ReadableArray() { cudaFree(data_); }

    T* data() const { return data_; }
    void write(const std::vector<T>& values) {
        cuda::check(
            cudaMemcpy(data_, values.data(), values.size() * sizeof(T), cudaMemcpyHostToDevice),
            "a frame's places");
        // A copy from pageable memory may return before it is done, and steps have other streams.
        cuda::check(cudaStreamSynchronize(nullptr), "a frame's places");
    }

private:
    T* data_ = nullptr;
};

/// The places of the moving bodies of one device, in its memory.
class DevicePlaces {
public:
    DevicePlaces(Player& player, int device, const std::vector<std::uint32_t>& bodies)
        : player_(player) {
        const cuda::OnDevice here(device);
        for (std::uint32_t b : bodies) {
            if (player.deforms(b))
                deforming_.push_back(b);
            else if (player.recording.bodies[b].motion == Motion::rigid)
                rigid_.push_back(b);
        }
        stage(0);
        device_positions_.emplace(positions_.size());
        device_poses_.emplace(poses_.size());
        player.world.set_device_positions(ids_of(deforming_), device_positions_->data());
        player.world.set_device_poses(ids_of(rigid_),
                                      static_cast<const double*>(device_poses_->data()));
    }
    void write(std::uint32_t frame) {
        stage(frame);
        device_positions_->write(positions_);
        device_poses_->write(poses_);
    }

private:
    std::vector<BodyId> ids_of(const std::vector<std::uint32_t>& some) const {
        std::vector<BodyId> ids;
        for (std::uint32_t b : some) ids.push_back(player_.bodies[b]);
        return ids;
    }
    void stage(std::uint32_t frame) {
        positions_.clear();
        poses_.clear();
        for (std::uint32_t b : deforming_) {
            const auto positions = player_.recording.positions(b, frame);
            positions_.insert(positions_.end(), positions.begin(), positions.end());
        }
        for (std::uint32_t b : rigid_) {
            const Pose p = player_.recording.pose(b, frame);
            poses_.insert(poses_.end(), {p.position.x, p.position.y, p.position.z, p.rotation.x,
                                         p.rotation.y, p.rotation.z, p.rotation.w});
        }
    }

    Player& player_;
    std::vector<std::uint32_t> deforming_, rigid_;
    std::vector<Vec3f> positions_;
    std::vector<double> poses_;
    std::optional<ReadableArray<Vec3f>> device_positions_;
    std::optional<ReadableArray<double>> device_poses_;
};

/// The bodies of each device: those that it will own.
std::vector<std::vector<std::uint32_t>> bodies_of_devices(const scenes::Recording& recording,
                                                          std::uint32_t devices) {
    std::vector<WeightedPoint> points;
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        Box box;
        if (recording.bodies[b].motion == Motion::deforming)
            for (const Vec3f p : recording.positions(b, 0)) box.extend(to_double(p));
        else
            box.extend(recording.pose(b, 0).position);
        points.push_back({box.center(), 1});
    }
    const std::vector<std::uint32_t> parts = divide_space(points,
                                                          std::vector<double>(devices, 1.0));
    std::vector<std::vector<std::uint32_t>> bodies(devices);
    for (std::uint32_t b = 0; b < parts.size(); ++b) bodies[parts[b]].push_back(b);
    return bodies;
}

struct Options {
    std::uint32_t steps = 64, checks = 8, devices = 1;
    bool stages = false;
    std::optional<double> host_share = std::nullopt;  ///< none: places are on the device
    std::string builder = "trbvh", memory = "certified";
    Coverage coverage = Settings{}.coverage;
    bool reproject = Settings{}.reproject;
    double margin = 0;  ///< [length]
};

Settings settings_of(const Options& options) {
    Settings settings{
        .coverage = options.coverage, .reproject = options.reproject, .margin = options.margin};
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

std::unique_ptr<Backend> backend_of(const Options& options) {
    CudaOptions cuda{.builder = builder_named(options.builder), .graph = !options.stages};
    for (std::uint32_t d = 0; d < options.devices; ++d) cuda.devices.push_back(static_cast<int>(d));
    if (options.host_share.value_or(0) > 0)
        return cuda_backend(cuda, embree_backend(), *options.host_share);
    return cuda_backend(cuda);
}

/// Says on stderr where the contacts of a step begin to differ from Embree's.
void describe_difference(std::uint32_t step, std::span<const Contact> gpu,
                         std::span<const Contact> embree) {
    std::size_t k = 0;
    while (k < gpu.size() && k < embree.size() &&
           contact_hash(gpu.subspan(k, 1)) == contact_hash(embree.subspan(k, 1)))
        ++k;
    std::fprintf(stderr, "step %u: %zu contacts and Embree's %zu; the first that differ:\n", step,
                 gpu.size(), embree.size());
    for (const std::span<const Contact> list : {gpu, embree}) {
        if (k >= list.size()) continue;
        const Contact& c = list[k];
        std::fprintf(stderr,
                     "  %zu: bodies %u %u, source %d, vertex %u-%u, edge %u chord %u, triangle %u, "
                     "found %d, reprojected %d, age %u, distance %.17g, at %.9g %.9g %.9g\n",
                     k, c.a.index, c.b.index, static_cast<int>(c.source), c.vertex, c.edge_end,
                     c.edge, c.chord, c.triangle, static_cast<int>(c.found), c.reprojected, c.age,
                     c.distance, c.point_a.x, c.point_a.y, c.point_a.z);
    }
}

void run(const std::string& name, const scenes::Recording& recording, const Options& options,
         const std::vector<Filter>& filters = {}) {
    const auto& [steps, checks, devices, stages, host_share, builder, memory, coverage, reproject,
                 margin] = options;
    Player gpu(recording, filters, backend_of(options), settings_of(options));
    std::size_t triangles = 0;
    for (const auto& body : recording.bodies)
        triangles += recording.meshes[body.mesh].data.triangles.size();
    std::vector<std::unique_ptr<DevicePlaces>> places;
    for (const auto& bodies : bodies_of_devices(recording, devices)) {
        if (host_share) break;
        places.push_back(
            std::make_unique<DevicePlaces>(gpu, static_cast<int>(places.size()), bodies));
    }

    std::vector<double> wall, on_device, full_rays, walks, lost;
    std::map<std::string, std::vector<double>> by_stage;
    std::vector<std::string> order;
    std::vector<std::vector<Contact>> found;
    StepStats last;
    const auto frame_of_step = [&](std::uint32_t i) { return i % recording.frame_count; };
    for (std::uint32_t i = 0; i < steps; ++i) {
        for (const auto& of_device : places) of_device->write(frame_of_step(i));
        if (host_share) gpu.put(frame_of_step(i));
        last = gpu.world.detect();
        if (i < checks) {
            const std::span<const Contact> contacts = gpu.world.contacts();
            found.emplace_back(contacts.begin(), contacts.end());
        }
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
        Player cpu(recording, filters, embree_backend(), settings_of(options));
        for (std::uint32_t i = 0; i < checks; ++i) {
            cpu.put(frame_of_step(i));
            embree.push_back(cpu.world.detect().milliseconds);
            if (contact_hash(cpu.world.contacts()) == contact_hash(found[i])) continue;
            ++differ;
            describe_difference(i, found[i], cpu.world.contacts());
        }
    }
    std::printf(
        "%s,%zu,%zu,%s,%s,%u,%u,%u,%u,%.4f,%.4f,%.4f,%u,%u,%s,%.4f,%.4f,%.0f,%.0f,%.0f,%s,"
        "%s,%u,%s,%g\n",
        name.c_str(), recording.bodies.size(), triangles, builder.c_str(),
        stages ? "stages" : "graph", last.pairs, last.rays + last.own_rays, last.contacts,
        last.touching_pairs, median(on_device), median(wall), median(embree), checks, differ,
        memory.c_str(), mean(on_device), mean(wall), mean(full_rays), mean(walks), mean(lost),
        name_of(coverage), reproject ? "on" : "off", devices,
        host_share ? std::to_string(*host_share).c_str() : "", margin);
    for (const PlannedPart& part : gpu.world.plan().parts)
        std::printf("# %s: %u bodies, %u ghosts, %llu triangles\n", part.backend.c_str(),
                    part.bodies, part.ghosts, static_cast<unsigned long long>(part.triangles));
    for (const double ms : last.part_milliseconds) std::printf("# part %.4f ms\n", ms);
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
        else if (argument == "--margin" && i + 1 < argc)
            options.margin = std::stod(argv[++i]);
        else if (argument == "--devices" && i + 1 < argc)
            options.devices = static_cast<std::uint32_t>(std::stoul(argv[++i]));
        else if (argument == "--host-share" && i + 1 < argc)
            options.host_share = std::stod(argv[++i]);
        else if (argument == "--stages")
            options.stages = true;
        else
            scenes.push_back(argument);
    }
    options.checks = std::min(options.checks, options.steps);
    std::puts(
        "scene,bodies,triangles,builder,mode,pairs,rays,contacts,touching_pairs,device_ms,wall_ms,"
        "embree_ms,checked,differ,memory,device_mean_ms,wall_mean_ms,mean_full_rays,mean_walks,"
        "mean_lost,coverage,reproject,devices,host_share,margin");
    for (const std::string& scene : scenes) {
        using pierce::scenes::LatticeMotion;
        const std::size_t colon = scene.find(':');
        const std::string kind = scene.substr(0, colon);
        if (kind == "lattice" || kind == "tower" || kind == "rigid" || kind == "rest") {
            const auto count = static_cast<std::uint32_t>(std::stoul(scene.substr(colon + 1)));
            const LatticeMotion motion = kind == "rigid"  ? LatticeMotion::rigid
                                         : kind == "rest" ? LatticeMotion::rest
                                                          : LatticeMotion::soft;
            const std::uint32_t frames = motion != LatticeMotion::soft ? 32
                                         : count > 2000                ? 4
                                                                       : 16,
                                side = kind == "tower" ? 25 : 0;
            pierce::run(scene, pierce::scenes::lattice(count, frames, motion, side), options);
        } else if (const auto small = pierce::scenes::small_world_named(kind)) {
            const auto count = static_cast<std::uint32_t>(std::stoul(scene.substr(colon + 1)));
            const auto worlds = pierce::scenes::small_worlds(*small, count, 4);
            pierce::run(scene, worlds.recording, options, worlds.filters);
        } else {
            const auto recording = pierce::scenes::as_deforming(
                pierce::scenes::read_recording(scene));
            pierce::scenes::require_lasting_meshes(recording, "pierce_gpu_steps");
            pierce::run(scene.substr(scene.find_last_of('/') + 1), recording, options);
        }
    }
}
