#include "scenes/detect/method.hpp"

#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
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

}  // namespace

bool cuda_can_run() {
#if PIERCE_HAS_CUDA
    return cuda_problem().empty();
#else
    return false;
#endif
}

std::unique_ptr<Backend> make_backend(const RaySettings& settings) {
    if (settings.backend == "automatic")
        return cuda_can_run() ? make_cuda(settings) : embree_backend(settings.threads);
    if (settings.backend == "cuda") return make_cuda(settings);
    if (settings.backend == "embree") return embree_backend(settings.threads);
    if (settings.backend == "reference") return reference_backend();
    if (settings.backend == "bvh") return make_bvh(settings);
    throw InputError("unknown backend '" + settings.backend +
                     "'; there are: automatic, embree, cuda, bvh, reference");
}

void FrameResult::forget_times() {
    for (NamedTime& time : times) time.milliseconds = 0;
    milliseconds = update_ms = narrow_ms = response_ms = total_ms = 0;
}

}  // namespace pierce::scenes
