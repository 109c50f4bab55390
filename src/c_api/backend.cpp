#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/settings.hpp"
#include "c_api/versioned.hpp"
#include "pierce/backend.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/reference_backends.hpp"
#ifdef PIERCE_HAS_EMBREE
#include "pierce/embree_backend.hpp"
#endif
#ifdef PIERCE_HAS_CUDA
#include "pierce/cuda_backend.hpp"
#endif

namespace pierce::c {
namespace {

constexpr pierce_backend_options default_options{.struct_size = sizeof(pierce_backend_options),
                                                 .kind = PIERCE_BACKEND_DEFAULT,
                                                 .threads = 0,
                                                 .tree_builder = PIERCE_TREES_DEFAULT,
                                                 .rebuild = 0,
                                                 .stage_by_stage = 0,
                                                 .parts = 0,
                                                 .host_share = 0};

TreeBuilder builder_of(const pierce_backend_options& options, TreeBuilder otherwise) {
    switch (enumerated(options.tree_builder, PIERCE_TREES_PLOC, "backend.tree_builder")) {
        case PIERCE_TREES_DEFAULT:
            return otherwise;
        case PIERCE_TREES_LBVH:
            return TreeBuilder::lbvh;
        case PIERCE_TREES_HLBVH:
            return TreeBuilder::hlbvh;
        case PIERCE_TREES_TRBVH:
            return TreeBuilder::trbvh;
        case PIERCE_TREES_PLOC:
            return TreeBuilder::ploc;
    }
    return otherwise;
}

std::unique_ptr<Backend> own_trees(const pierce_backend_options& options) {
    return bvh_backend(
        {.builder = builder_of(options, TreeOptions{}.builder), .rebuild = options.rebuild != 0});
}

#ifdef PIERCE_HAS_EMBREE
constexpr bool has_embree = true;
std::unique_ptr<Backend> embree(const pierce_backend_options& options) {
    return embree_backend(options.threads);
}
#else
constexpr bool has_embree = false;
std::unique_ptr<Backend> embree(const pierce_backend_options&) {
    throw NotBuilt("this library was built without Embree");
}
#endif

/// Where steps run on the host.
std::unique_ptr<Backend> host_of(const pierce_backend_options& options) {
    return has_embree ? embree(options) : own_trees(options);
}

#ifdef PIERCE_HAS_CUDA
std::string problem_of_cuda() { return cuda_problem(); }
std::unique_ptr<Backend> cuda(const pierce_backend_options& options) {
    CudaOptions cuda{.builder = builder_of(options, CudaOptions{}.builder),
                     .rebuild = options.rebuild != 0,
                     .graph = options.stage_by_stage == 0};
    for (std::uint32_t device = 0; options.parts > 1 && device < options.parts; ++device)
        cuda.devices.push_back(static_cast<int>(device));
    if (options.host_share > 0)
        return cuda_backend(std::move(cuda), host_of(options), options.host_share);
    return cuda_backend(std::move(cuda));
}
#else
constexpr const char* no_cuda = "this library was built without CUDA";
std::string problem_of_cuda() { throw NotBuilt(no_cuda); }
std::unique_ptr<Backend> cuda(const pierce_backend_options&) { throw NotBuilt(no_cuda); }
#endif

std::unique_ptr<Backend> one_backend(const pierce_backend_options& options,
                                     pierce_backend_kind kind) {
    switch (kind) {
        case PIERCE_BACKEND_DEFAULT:
            return host_of(options);
        case PIERCE_BACKEND_REFERENCE:
            return reference_backend();
        case PIERCE_BACKEND_BVH:
            return own_trees(options);
        case PIERCE_BACKEND_EMBREE:
            return embree(options);
        case PIERCE_BACKEND_CUDA:
            return cuda(options);
    }
    return nullptr;
}

void check_backend(pierce_backend_kind kind) {
    if (kind == PIERCE_BACKEND_EMBREE && !has_embree) embree(default_options);
    if (kind != PIERCE_BACKEND_CUDA) return;
    const std::string problem = problem_of_cuda();
    if (!problem.empty()) throw InputError(problem);
}

}  // namespace

std::unique_ptr<Backend> backend_of(const pierce_backend_options* given) {
    const pierce_backend_options options = given == nullptr
                                               ? default_options
                                               : read_struct(given, default_options, "backend");
    // Of every backend, so that a mistake does not wait for another machine.
    builder_of(options, TreeBuilder::lbvh);
    const auto kind = enumerated(options.kind, PIERCE_BACKEND_CUDA, "backend.kind");
    if (options.host_share != 0 && (kind != PIERCE_BACKEND_CUDA || !(options.host_share > 0)))
        throw InputError("backend.host_share is positive, and for CUDA");
    if (options.parts > most_parts)
        throw InputError("backend.parts is more than " + std::to_string(most_parts));
    if (options.parts <= 1 || kind == PIERCE_BACKEND_CUDA) return one_backend(options, kind);
    return partitioned_backend(options.parts, options.threads, [&](int threads) {
        pierce_backend_options of_part = options;
        of_part.threads = threads;
        return one_backend(of_part, kind);
    });
}

}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_default_backend_options(pierce_backend_options* options, size_t struct_size) {
    return guarded([&] { write_defaults(default_options, options, struct_size, "options"); });
}

pierce_status pierce_check_backend(uint32_t kind) {
    return guarded([&] { check_backend(enumerated(kind, PIERCE_BACKEND_CUDA, "kind")); });
}
