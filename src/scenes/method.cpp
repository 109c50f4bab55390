#include "scenes/method.hpp"

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

#if !PIERCE_HAS_CUDA
std::string cuda_problem() { return "this build has no CUDA (PIERCE_CUDA=ON)"; }

std::unique_ptr<Backend> cuda_backend() {
    throw InputError("the cuda backend cannot run here: " + cuda_problem());
}
#endif

}  // namespace

std::unique_ptr<Backend> make_backend(const RaySettings& settings) {
    if (settings.backend == "automatic")
        return cuda_problem().empty() ? cuda_backend() : embree_backend(settings.threads);
    if (settings.backend == "cuda") return cuda_backend();
    if (settings.backend == "embree") return embree_backend(settings.threads);
    if (settings.backend == "reference") return reference_backend();
    if (settings.backend == "bvh") return bvh_backend();
    throw InputError("unknown backend '" + settings.backend +
                     "'; there are: automatic, embree, cuda, bvh, reference");
}

}  // namespace pierce::scenes
