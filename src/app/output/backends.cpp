#include "app/output/backends.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "app/output/provenance.hpp"
#include "pierce/backend.hpp"
#include "pierce/error.hpp"
#include "scenes/detect/method.hpp"

namespace pierce::app {

std::vector<BackendState> backends() {
    std::vector<BackendState> all;
    for (const char* name : {"embree", "bvh", "reference", "cuda"}) {
        BackendState state{.name = name, .description = {}, .problem = {}};
        scenes::RaySettings settings;
        settings.backend = name;
        try {
            state.description = scenes::make_backend(settings)->description();
        } catch (const InputError& error) {
            state.problem = error.what();
        }
        all.push_back(std::move(state));
    }
    return all;
}

std::string automatic_backend() { return scenes::cuda_can_run() ? "cuda" : "embree"; }

std::string version_text() {
    const nlohmann::json versions = versions_json();
    const auto of = [&](const char* key) { return versions[key].get<std::string>(); };
    std::string text = fmt::format("pierce {}\ncommit     {}\nbuild      {}, compiler {}",
                                   of("pierce"), of("commit"), of("build"), of("compiler"));
    for (const BackendState& backend : backends())
        text += fmt::format("\n{:<10} {}", backend.name,
                            backend.runs() ? backend.description : backend.problem);
    return text;
}

}  // namespace pierce::app
