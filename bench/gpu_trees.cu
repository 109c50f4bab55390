// Trees on the GPU: how fast they are built, refitted and traced, and how good they are.
//   pierce_gpu_trees COUNT...    COUNT tori of 600 triangles, out of shape, a tree each
//   pierce_gpu_trees rest:COUNT  the same at rest; rays leave through a vertex each
//   pierce_gpu_trees mesh:LEVELS one sphere
// `inward` traces the inward rays of all vertices. `predicted` traces outward rays, too, in the
// same thread; `apart` traces them as two rays, in two launches. Floors: the fewest bytes each must
// move, over what a copy moves. Prints CSV.
#include <cuda_runtime.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "core/trace/bvh/sah.hpp"
#include "gpu_cuda/cuda_executor.cuh"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce {
namespace {

/// Per vertex of a torus or sphere in its own space: the inward ray into its own body; or,
/// `against` it, the outward one.
struct AimInward {
    View<const BodyView> bodies;
    std::uint32_t vertices_per_body;
    View<Ray> rays;
    bool predicts = false;  ///< looks outward, too, as far as predictions go
    bool against = false;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t b = i / vertices_per_body, v = i % vertices_per_body;
        Ray ray;
        ray.origin = to_double(bodies[b].positions[v]);
        const double outward = constants::prediction_limit * bodies[b].mesh.mean_edge_length;
        ray.direction = (against ? 1.0 : -1.0) * normalized(to_double(bodies[b].mesh.normals[v]));
        ray.t_max = against ? outward : bodies[b].mesh.box.extent();
        ray.outward = predicts ? outward : 0;
        ray.target = b;
        ray.touch = bodies[b].touch;
        ray.excluded[0] = ray.excluded[1] = v;
        rays[i] = ray;
    }
};

struct CopyWord {
    const float4* from;
    float4* to;

    PIERCE_HD void operator()(std::uint32_t i) const { to[i] = from[i]; }
};

class Timer {
public:
    explicit Timer(cudaStream_t stream) : stream_(stream) {
        cuda::check(cudaEventCreate(&begin_), "an event");
        cuda::check(cudaEventCreate(&end_), "an event");
    }
    ~Timer() {
        cudaEventDestroy(begin_);
        cudaEventDestroy(end_);
    }

    /// Median milliseconds of `repeats` calls of `work`, each after `prepare`.
    template <class F, class P>
    double operator()(int repeats, const F& work, const P& prepare) {
        std::vector<float> times;
        for (int i = 0; i < repeats + 2; ++i) {
            prepare();
            cuda::check(cudaEventRecord(begin_, stream_), "an event");
            work();
            cuda::check(cudaEventRecord(end_, stream_), "an event");
            cuda::check(cudaEventSynchronize(end_), "an event");
            float ms = 0;
            cuda::check(cudaEventElapsedTime(&ms, begin_, end_), "a time");
            if (i >= 2) times.push_back(ms);
        }
        std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
        return static_cast<double>(times[times.size() / 2]);
    }

    template <class F>
    double operator()(int repeats, const F& work) {
        return (*this)(repeats, work, [] {});
    }

private:
    cudaStream_t stream_;
    cudaEvent_t begin_ = nullptr, end_ = nullptr;
};

double copy_rate(CudaExecutor& executor, Timer& time) {
    constexpr std::uint32_t words = 1u << 27;
    cuda::DeviceBuffer<float4> from, to;
    from.resize(words);
    to.resize(words);
    const double ms = time(20, [&] { executor.for_each(words, CopyWord{from.data(), to.data()}); });
    return 2.0 * words * sizeof(float4) / (ms * 1e-3);
}

/// A shape as a soft body in a pile has it, without symmetries; the body's number says which way.
std::vector<Vec3f> out_of_shape(const std::vector<Vec3f>& shape, std::uint32_t body) {
    constexpr float size = 0.06f;
    const float phase = 0.7f * static_cast<float>(body);
    std::vector<Vec3f> bent;
    for (const Vec3f& p : shape)
        bent.push_back(p + size * Vec3f{std::sin(3 * p.y + 1.3f * p.z + phase),
                                        std::sin(2.1f * p.x + 1.7f * p.z + 2 * phase),
                                        std::sin(2.7f * p.x + 1.1f * p.y + 3 * phase)});
    return bent;
}

void run(const std::string& name, const MeshData& data, std::uint32_t count, bool bent,
         double bytes_per_second, CudaExecutor& executor, Timer& time) {
    const Mesh mesh("mesh", data);
    const MeshView host = mesh.view();
    const std::uint32_t vertices = host.positions.size, triangles = host.triangles.size;
    cuda::DeviceBuffer<Vec3f> positions, normals;
    cuda::DeviceBuffer<Triangle> corners;
    cuda::DeviceBuffer<bvh::Leaf> leaves;
    std::vector<Vec3f> all;
    std::vector<Box> boxes(count);
    for (std::uint32_t b = 0; b < count; ++b) {
        const std::vector<Vec3f> shape = bent ? out_of_shape(data.positions, b) : data.positions;
        all.insert(all.end(), shape.begin(), shape.end());
        for (const Vec3f& p : shape) boxes[b].extend(to_double(p));
    }
    executor.upload(std::span<const Vec3f>(all), positions);
    executor.upload(std::span<const Vec3f>(mesh.normals()), normals);
    executor.upload(mesh.triangles(), corners);
    executor.upload(std::span<const bvh::Leaf>(host.leaves.begin(), host.leaves.end()), leaves);
    std::vector<BodyView> bodies(count);
    for (std::uint32_t b = 0; b < count; ++b) {
        BodyView& body = bodies[b];
        body.mesh = host;
        body.mesh.triangles = view_of(std::as_const(corners));
        body.mesh.leaves = view_of(std::as_const(leaves));
        body.mesh.normals = view_of(std::as_const(normals));
        body.positions = {positions.data() + std::size_t{b} * vertices, vertices};
        body.motion = Motion::deforming;
        body.mesh_key = 1;
        body.world_box = body.fit_box = boxes[b];
        body.touch = constants::touch_tolerance * host.box.extent();
        body.positions_version = 1;
    }
    cuda::DeviceBuffer<BodyView> there;
    const auto send = [&] {
        for (BodyView& body : bodies) ++body.positions_version;
        executor.upload(std::span<const BodyView>(bodies), there);
    };
    send();
    const View<const BodyView> views = view_of(std::as_const(there));
    cuda::DeviceBuffer<Ray> rays;
    cuda::DeviceBuffer<Hit> hits;
    cuda::DeviceBuffer<std::uint32_t> wanted;
    const std::uint32_t ray_count = count * vertices;
    rays.resize(ray_count);
    hits.resize(ray_count);
    executor.assign(wanted, count, 1u);

    const double all_triangles = static_cast<double>(count) * triangles;
    const double all_leaves = static_cast<double>(count) * host.leaves.size;
    for (const auto& [builder, label] :
         {std::pair{TreeBuilder::lbvh, "lbvh"}, std::pair{TreeBuilder::hlbvh, "hlbvh"},
          std::pair{TreeBuilder::trbvh, "trbvh"}, std::pair{TreeBuilder::ploc, "ploc"}}) {
        BvhTracer<CudaExecutor> tracer({builder});
        tracer.arrange(executor, view_of(std::as_const(bodies)));
        const double build = time(9, [&] { tracer.build(executor, views); });
        const double refit = time(
            9, [&] { tracer.update(executor, views, view_of(std::as_const(wanted))); }, send);
        const auto trace_all = [&] {
            tracer.closest_hits(executor, views, ray_count, view_of(std::as_const(rays)),
                                view_of(hits));
        };
        const auto time_of = [&](bool predicts, bool against) {
            executor.for_each(ray_count,
                              AimInward{views, vertices, view_of(rays), predicts, against});
            return time(9, trace_all);
        };
        const double trace = time_of(false, false), predicted = time_of(true, false);
        const double apart = trace + time_of(false, true);
        // A triangle: half a vertex. A leaf: a node; its corners are its mesh's. A ray: itself and
        // its hit.
        const double bytes = all_triangles * 0.5 * sizeof(Vec3f) + all_leaves * sizeof(bvh::Node);
        const double build_floor = bytes / bytes_per_second * 1e3;
        const double trace_floor = ray_count * static_cast<double>(sizeof(Ray) + sizeof(Hit)) /
                                   bytes_per_second * 1e3;
        std::printf("%s,%.0f,%s,%.4f,%.1f,%.4f,%.4f,%.1f,%u,%.4f,%.3f,%.4f,%.4f,%.4f\n",
                    name.c_str(), all_triangles, label, build, all_triangles / build * 1e-3,
                    build_floor, refit, all_triangles / refit * 1e-3, ray_count, trace,
                    ray_count / trace * 1e-6, trace_floor, predicted, apart);
        std::fflush(stdout);
    }
}

}  // namespace
}  // namespace pierce

int main(int argc, char** argv) {
    pierce::CudaExecutor executor;
    executor.begin_exact(0);
    pierce::Timer time(executor.stream());
    const double rate = pierce::copy_rate(executor, time);
    std::printf("# a copy moves %.2f TB/s\n", rate * 1e-12);
    std::puts(
        "scene,triangles,builder,build_ms,build_mtri_s,build_floor_ms,refit_ms,refit_mtri_s,rays,"
        "inward_ms,inward_gray_s,"
        "inward_floor_ms,predicted_ms,apart_ms");
    for (int i = 1; i < argc; ++i) {
        const std::string scene = argv[i];
        if (scene.starts_with("mesh:"))
            pierce::run(scene, pierce::scenes::sphere(1, std::stoi(scene.substr(5))), 1, false,
                        rate, executor, time);
        else {
            const bool rests = scene.starts_with("rest:");
            pierce::run(rests ? scene : "tori:" + scene, pierce::scenes::torus(2, 0.5, 30, 10),
                        static_cast<std::uint32_t>(std::stoul(rests ? scene.substr(5) : scene)),
                        !rests, rate, executor, time);
        }
    }
}
