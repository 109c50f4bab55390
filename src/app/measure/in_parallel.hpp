#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>

namespace pierce::app {

/// Calls work(i) for i < count, on all threads of the machine. For work whose time is not measured,
/// and that itself uses one thread.
template <class Work>
void in_parallel(std::size_t count, const Work& work) {
    tbb::parallel_for(std::size_t{0}, count, work, tbb::simple_partitioner());
}

}  // namespace pierce::app
