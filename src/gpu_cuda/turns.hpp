#pragma once

#include <mutex>

namespace pierce::cuda {

/// CUDA forbids waiting for a device while any thread captures a stream of it, and such a wait ends
/// the capture. So captures and waits of all backends of the process take turns.
inline std::recursive_mutex& captures_and_waits() {
    static std::recursive_mutex turns;
    return turns;
}

}  // namespace pierce::cuda
