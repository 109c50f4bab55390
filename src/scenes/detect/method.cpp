#include "scenes/detect/method.hpp"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/reference_backends.hpp"
#if PIERCE_HAS_CUDA
#include "pierce/cuda_backend.hpp"
#endif

namespace pierce::scenes {

void FrameResult::name_stages(const std::vector<StageTime>& its_stages) {
    for (const StageTime& t : its_stages) times.push_back({name_of(t.stage), t.milliseconds});
}

Method method_named(const std::string& name) {
    std::string known;
    for (const auto& [text, method] : method_names) {
        if (name == text) return method;
        known += (known.empty() ? "" : ", ") + std::string(text);
    }
    throw InputError("unknown method '" + name + "'; there are: " + known);
}

namespace {

#if PIERCE_HAS_CUDA
std::unique_ptr<Backend> make_cuda(const RaySettings& settings) {
    CudaOptions options{.rebuild = settings.rebuild, .graph = settings.graph};
    options.builder = settings.builder.value_or(options.builder);
    for (int device = 0; settings.parts > 1 && device < settings.parts; ++device)
        options.devices.push_back(device);
    if (settings.host_share > 0)
        return cuda_backend(options, embree_backend(settings.threads), settings.host_share);
    return cuda_backend(options);
}
#else
std::unique_ptr<Backend> make_cuda(const RaySettings&) {
    throw InputError("the cuda backend cannot run here: this build has no CUDA (PIERCE_CUDA=ON)");
}
#endif

std::unique_ptr<Backend> make_bvh(const RaySettings& settings) {
    TreeOptions options{.rebuild = settings.rebuild};
    options.builder = settings.builder.value_or(options.builder);
    return bvh_backend(options);
}

std::unique_ptr<Backend> make_on_host(const RaySettings& settings) {
    if (settings.backend == "embree" || settings.backend == "automatic")
        return embree_backend(settings.threads);
    if (settings.backend == "reference") return reference_backend();
    if (settings.backend == "bvh") return make_bvh(settings);
    throw InputError("unknown backend '" + settings.backend +
                     "'; there are: automatic, embree, cuda, bvh, reference");
}

std::unique_ptr<Backend> make_parts(const RaySettings& settings) {
    return partitioned_backend(static_cast<std::uint32_t>(settings.parts), settings.threads,
                               [&](int threads) {
                                   RaySettings of_part = settings;
                                   of_part.threads = threads;
                                   return make_on_host(of_part);
                               });
}

std::unique_ptr<Backend> make_own(const RaySettings& settings) {
    if (settings.parts < 1) throw InputError("a world has at least one part");
    const bool has_devices = settings.backend == "cuda" || settings.backend == "automatic";
    if (settings.host_share != 0 && !(settings.host_share > 0 && has_devices))
        throw InputError("a share of the host is positive, and beside cuda");
    if (settings.backend == "cuda" || (settings.backend == "automatic" && cuda_can_run()))
        return make_cuda(settings);
    return settings.parts > 1 ? make_parts(settings) : make_on_host(settings);
}

}  // namespace

bool cuda_can_run() {
#if PIERCE_HAS_CUDA
    return cuda_problem().empty();
#else
    return false;
#endif
}

std::unique_ptr<Backend> make_backend(const RaySettings& settings) {
    std::unique_ptr<Backend> own = make_own(settings);
    return settings.shared ? settings.shared(std::move(own)) : std::move(own);
}

void FrameResult::forget_times() {
    for (NamedTime& time : times) time.milliseconds = 0;
    milliseconds = update_ms = narrow_ms = response_ms = total_ms = 0;
}

}  // namespace pierce::scenes
