#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>
#include <string>

#include "app/output/interrupt.hpp"

namespace pierce::app {

/// Calls work(i) for i < count, on all threads of the machine. For work whose time is not measured,
/// and that itself uses one thread. If it should stop, begins no other work and throws Interrupted.
template <class Work>
void in_parallel(const std::string& what, std::size_t count, const Work& work) {
    const InterruptDelay delay;
    const auto work_on = [&](std::size_t i) {
        if (!should_stop()) work(i);
    };
    tbb::parallel_for(std::size_t{0}, count, work_on, tbb::simple_partitioner());
    if (should_stop()) throw Interrupted("stopped while " + what);
}

}  // namespace pierce::app
