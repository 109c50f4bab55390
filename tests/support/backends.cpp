#include "support/backends.hpp"

#include <utility>

#include "core/partition/resting_backend.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/reference_backends.hpp"
#if PIERCE_HAS_TEST_EXECUTORS
#include "support/executor_backends.hpp"
#endif
#if PIERCE_HAS_CUDA
#include "pierce/cuda_backend.hpp"
#endif

namespace pierce::test {
namespace {

/// The first part, which has ghosts of the second one, is shared by two itself.
std::unique_ptr<Backend> two_parts() {
    std::vector<Part> parts;
    parts.push_back(
        {.backend = partitioned_backend(2, 1, [](int) { return bvh_backend(); }), .share = 2});
    parts.push_back({.backend = embree_backend(1)});
    return partitioned_backend(std::move(parts));
}

/// Bodies that rest for a step become a part of their own at once.
std::unique_ptr<Backend> resting() {
    return resting_backend([] { return bvh_backend(); },
                           {.bodies = 2, .steps = 1, .patience = 1, .most_patience = 1});
}

#if PIERCE_HAS_CUDA
/// Two devices, or one that takes both parts.
std::unique_ptr<Backend> cuda_parts() {
    const bool has_two = [] {
        try {
            cuda_backend({.devices = {1}});
            return true;
        } catch (const InputError&) {
            return false;
        }
    }();
    return cuda_backend({.devices = {0, has_two ? 1 : 0}});
}

std::vector<NamedBackend> cuda_backends() {
    return {{"cuda", [] { return cuda_backend(); }},
            {"cuda_stepwise", [] { return cuda_backend({.graph = false}); }},
            {"cuda_parts", cuda_parts}};
}
#endif

}  // namespace

std::vector<NamedBackend> known_backends() {
    std::vector<NamedBackend> all = {{"reference", [] { return reference_backend(); }},
                                     {"bvh", [] { return bvh_backend(); }},
                                     {"embree_1", [] { return embree_backend(1); }},
                                     {"embree_3", [] { return embree_backend(3); }},
                                     {"two_parts", two_parts},
                                     {"resting", resting}};
#if PIERCE_HAS_TEST_EXECUTORS
    all.push_back({"shuffled", [] { return shuffled_backend(); }});
    all.push_back({"parallel", [] { return parallel_backend(); }});
#endif
#if PIERCE_HAS_CUDA
    for (const NamedBackend& cuda : cuda_backends()) all.push_back(cuda);
#endif
    return all;
}

std::vector<NamedBackend> backends() {
    std::vector<NamedBackend> all = known_backends();
#if PIERCE_HAS_CUDA
    if (!cuda_problem().empty()) all.resize(all.size() - cuda_backends().size());
#endif
    return all;
}

}  // namespace pierce::test
