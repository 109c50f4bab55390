#pragma once

#include <memory>
#include <string>

#include "pierce/backend.hpp"
#include "pierce/tree_builder.hpp"

namespace pierce {

/// How steps run on the GPU.
struct CudaOptions {
    TreeBuilder builder = TreeBuilder::trbvh;
    bool graph = true;  ///< steady steps are one captured graph; else stage after stage, each timed
};

/// What keeps CUDA from being used here, for people; empty if nothing does.
std::string cuda_problem();

/// The GPU backend: every stage on the device, with trees of our own. Throws InputError if there is
/// no device to use.
std::unique_ptr<Backend> cuda_backend(CudaOptions options = {});

}  // namespace pierce
