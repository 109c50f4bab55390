#include "pierce/scenes/method.hpp"

#include "pierce/core/error.hpp"
#include "pierce/cpu_embree/embree_backend.hpp"

namespace pierce::scenes {

Method method_named(const std::string& name) {
    std::string known;
    for (const auto& [text, method] : method_names) {
        if (name == text) return method;
        known += (known.empty() ? "" : ", ") + std::string(text);
    }
    throw InputError("unknown method '" + name + "'; there are: " + known);
}

std::unique_ptr<Backend> make_backend(const RaySettings& settings) {
    if (settings.backend == "embree") return embree_backend(settings.threads);
    if (settings.backend == "reference") return reference_backend();
    if (settings.backend == "bvh") return bvh_backend();
    throw InputError("unknown backend '" + settings.backend + "'; there are: embree, reference, bvh");
}

}  // namespace pierce::scenes
