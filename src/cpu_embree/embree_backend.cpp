#include "pierce/embree_backend.hpp"

#include <tbb/info.h>

#include <algorithm>

#include "core/partition/resting_backend.hpp"
#include "core/step/pipeline_backend.hpp"
#include "cpu_embree/embree_api.hpp"
#include "cpu_embree/embree_tracer.hpp"
#include "pierce/error.hpp"

namespace pierce {

std::string embree_version() { return RTC_VERSION_STRING; }

std::unique_ptr<Backend> embree_backend(int threads) {
    if (threads < 0)
        throw InputError("threads must not be negative, got " + std::to_string(threads));
    const int available = tbb::info::default_concurrency();
    const int count = threads == 0 ? available : std::min(threads, available);
    return resting_backend([=] {
        return std::make_unique<PipelineBackend<TbbExecutor, EmbreeTracer>>(
            "embree " + embree_version() + ", " + std::to_string(count) +
                (count == 1 ? " thread" : " threads"),
            std::make_unique<TbbExecutor>(count), std::make_unique<EmbreeTracer>());
    });
}

}  // namespace pierce
