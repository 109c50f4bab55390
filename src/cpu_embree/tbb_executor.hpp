#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "pierce/core/executor.hpp"

namespace pierce {

/// Stages on oneTBB, in an arena of its own. Items are independent and every result is written to its own place, so the
/// answer is the same for any number of threads.
class TbbExecutor {
public:
    template <class T>
    using Buffer = HostBuffer<T>;

    explicit TbbExecutor(int threads) : arena_(threads) {}

    template <class F>
    void for_each(const char*, std::uint32_t n, const F& stage) {
        if (n == 0) return;
        arena_.execute([&] {
            tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, n, grain), [&](const auto& range) {
                for (std::uint32_t i = range.begin(); i != range.end(); ++i) stage(i);
            });
        });
    }

    /// Like for_each, for few items that are work enough for a task each.
    template <class F>
    void for_each_task(std::uint32_t n, const F& task) {
        arena_.execute([&] { tbb::parallel_for(std::uint32_t{0}, n, task); });
    }

    /// Serial: adding up a step's counts takes microseconds.
    std::uint32_t exclusive_scan(const char* name, View<const std::uint32_t> in, View<std::uint32_t> out) {
        return serial_.exclusive_scan(name, in, out);
    }

    void sort(const char*, View<std::uint64_t> keys, View<std::uint32_t> values) { host_sort(keys, values); }

private:
    static constexpr std::uint32_t grain = 16;  ///< items per task at least; smaller tasks cost more than they balance

    tbb::task_arena arena_;
    SerialExecutor serial_;
};

static_assert(Executor<TbbExecutor>);

}  // namespace pierce
