#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "pierce/core/executor.hpp"

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace pierce {

/// Tells the thread sanitizer what oneTBB, which is not compiled for it, guarantees: tasks come after the stage's begin and
/// before its end. Tasks of one stage stay unordered, so that races between items are still seen. Nothing in other builds.
class StageOrder {
public:
#if defined(__SANITIZE_THREAD__)
    void stage_begins() { __tsan_release(&begin_); }
    void task_begins() { __tsan_acquire(&begin_); }
    void task_ends() { __tsan_release(&end_); }
    void stage_ends() { __tsan_acquire(&end_); }

private:
    char begin_ = 0, end_ = 0;
#else
    void stage_begins() {}
    void task_begins() {}
    void task_ends() {}
    void stage_ends() {}
#endif
};

/// Stages on oneTBB, in an arena of its own. Items are independent and every result is written to its own place, so the
/// answer is the same for any number of threads.
class TbbExecutor : public HostExecutor {
public:
    explicit TbbExecutor(int threads) : arena_(threads) {}

    template <class F>
    void for_each(const char* name, std::uint32_t n, const F& stage) {
        constexpr std::uint32_t grain = is_cheap<F>() ? cheap_grain : usual_grain;
        if (n <= grain) return serial_.for_each(name, n, stage);
        in_order([&] {
            tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, n, grain), [&](const auto& range) {
                order_.task_begins();
                for (std::uint32_t i = range.begin(); i != range.end(); ++i) stage(i);
                order_.task_ends();
            });
        });
    }

    /// Like for_each, for few items that are work enough for a task each.
    template <class F>
    void for_each_task(std::uint32_t n, const F& task) {
        in_order([&] {
            tbb::parallel_for(std::uint32_t{0}, n, [&](std::uint32_t i) {
                order_.task_begins();
                task(i);
                order_.task_ends();
            });
        });
    }

    /// Serial: adding up a step's counts takes microseconds.
    std::uint32_t exclusive_scan(const char* name, std::uint32_t n, View<const std::uint32_t> in, View<std::uint32_t> out) {
        return serial_.exclusive_scan(name, n, in, out);
    }

    /// Serial: one or two nanoseconds an item.
    template <class F>
    std::uint32_t select(const char* name, std::uint32_t n, const F& wanted, View<std::uint32_t> out) {
        return serial_.select(name, n, wanted, out);
    }

    /// Serial too: keys are few.
    void sort(const char* name, std::uint32_t n, int bits, View<std::uint64_t> keys, View<std::uint32_t> values) {
        serial_.sort(name, n, bits, keys, values);
    }

    /// Serial, so that sums of floating-point numbers do not depend on the number of threads.
    template <class F, class T>
    void reduce(const char* name, std::uint32_t n, const F& term, T& sum) {
        serial_.reduce(name, n, term, sum);
    }

private:
    // Items per task at least; smaller tasks cost more than they balance.
    static constexpr std::uint32_t usual_grain = 16;
    static constexpr std::uint32_t cheap_grain = 512;

    /// Runs `work` in the arena; what its tasks do comes after all before it and before all after it.
    template <class F>
    void in_order(const F& work) {
        order_.stage_begins();
        arena_.execute(work);
        order_.stage_ends();
    }

    tbb::task_arena arena_;
    StageOrder order_;
    SerialExecutor serial_;
};

static_assert(Executor<TbbExecutor>);

}  // namespace pierce
