#pragma once

#include <tbb/task_arena.h>

#include "pierce/core/executor.hpp"
#include "pierce/cpu_embree/team.hpp"

namespace pierce {

/// Stages on oneTBB's threads, in an arena of its own. Items are independent and every result is written to its own place,
/// so the answer is the same for any number of threads.
class TbbExecutor : public HostExecutor {
public:
    explicit TbbExecutor(int threads) : arena_(threads), team_(arena_, threads) {}

    /// Inside the arena, so that whatever libraries do in parallel takes no more threads either.
    template <class Work>
    void run(const Work& work) {
        arena_.execute(work);
    }

    template <class F>
    void for_each(const char* name, std::uint32_t n, const F& stage) {
        constexpr std::uint32_t grain = is_cheap<F>() ? cheap_grain : usual_grain;
        if (n <= grain) return serial_.for_each(name, n, stage);
        share(n, grain, stage);
    }

    /// Like for_each, for few items that are work enough for a task each.
    template <class F>
    void for_each_task(std::uint32_t n, const F& task) {
        if (n > 0) share(n, 1, task);
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

    template <class F>
    void share(std::uint32_t n, std::uint32_t grain, const F& item) {
        team_.share(n, grain, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t i = begin; i != end; ++i) item(i);
        });
    }

    tbb::task_arena arena_;
    Team team_;
    SerialExecutor serial_;
};

static_assert(Executor<TbbExecutor>);

}  // namespace pierce
