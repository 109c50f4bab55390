#include "support/backends.hpp"

#include "pierce/cpu_embree/embree_backend.hpp"

namespace pierce::test {

std::vector<NamedBackend> backends() {
    return {{"reference", [] { return reference_backend(); }},
            {"bvh", [] { return bvh_backend(); }},
            {"embree_1", [] { return embree_backend(1); }},
            {"embree_3", [] { return embree_backend(3); }}};
}

}  // namespace pierce::test
