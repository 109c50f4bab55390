#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pierce/backend.hpp"
#include "pierce/tree_builder.hpp"

namespace pierce {

/// How steps run on the GPU.
struct CudaOptions {
    TreeBuilder builder = TreeBuilder::trbvh;
    bool rebuild = false;  ///< every step builds all trees anew; such steps are never a graph
    bool graph = true;  ///< true: steady steps run as one captured graph; false: stage after stage,
                        ///< each timed
    std::vector<int> devices = {};  ///< by their numbers; several share a world (docs/scale.md);
                                    ///< empty: the calling thread's current one
};

/// The reason, for people, why CUDA cannot be used here; empty if it can be used.
std::string cuda_problem();

/// The GPU backend: every stage runs on the device, with trees of our own. Throws InputError if no
/// device can be used, or if one of several cannot read what another one has.
std::unique_ptr<Backend> cuda_backend(CudaOptions options = {});

/// The same devices in one world with the host, which gets `share` of the work of one of them
/// (docs/scale.md). Throws InputError for a share that is not positive and finite, too.
std::unique_ptr<Backend> cuda_backend(CudaOptions options, std::unique_ptr<Backend> host,
                                      double share);

}  // namespace pierce
