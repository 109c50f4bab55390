#pragma once

#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <thread>
#include <utility>

#include "cpu_embree/tsan_order.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// Threads of oneTBB that stay together for a while. They take their shares of one stage after
/// another without a new call. Measured on two cores: a stage through tbb::parallel_for costs 10 to
/// 15 microseconds beyond its work, and a step of less than a millisecond has thirty stages.
///
/// Every thread has a range of its own, the same part of every stage. So a thread mostly reads what
/// it wrote in the stage before, from its own cache. A thread that is done helps the others. The
/// caller does all that no helper takes, so it never waits for a helper to arrive.
class Team {
public:
    /// Makes a team of `size` threads in all, the caller's among them; the helpers come from
    /// `arena`.
    Team(tbb::task_arena& arena, int size) : arena_(arena), board_(size) {}
    Team(const Team&) = delete;
    ~Team() {
        board_.closed.store(true, std::memory_order_relaxed);
        arena_.execute([&] { helpers_.wait(); });  // tasks that no thread has begun run here and
                                                   // end at once
        TsanOrder::pass();
    }

    /// Calls `work(begin, end)` for ranges that make up [0, count), most of `grain` items or more.
    /// When all ranges are done, throws what the first range to fail has thrown.
    template <class Work>
    void share(std::uint32_t count, std::uint32_t grain, const Work& work) {
        Board& board = board_;
        board.work.store(&work, std::memory_order_relaxed);
        board.run.store([](const void* w, std::uint32_t begin,
                           std::uint32_t end) { (*static_cast<const Work*>(w))(begin, end); },
                        std::memory_order_relaxed);
        board.count.store(count, std::memory_order_relaxed);
        board.grain.store(grain, std::memory_order_relaxed);
        board.done.store(0, std::memory_order_relaxed);
        call_helpers();  // it may throw: nobody has the work yet
        ++stage_;
        // From here on helpers may take shares.
        for (std::uint32_t k = 0; k < board.size; ++k)
            board.members[k].left.store(
                std::uint64_t{stage_} << 32 | (board.end_of(k, count) - board.end_of(k - 1, count)),
                std::memory_order_release);
        board.take_part(stage_, 0);
        for (std::uint32_t pauses = 0; board.done.load(std::memory_order_acquire) != count;
             ++pauses)
            pause(pauses);
        if (board.failed.load(std::memory_order_relaxed)) {
            board.failed.store(false, std::memory_order_relaxed);
            std::rethrow_exception(std::exchange(board.failure, {}));
        }
    }

private:
    // A helper that has found nothing to do for this many pauses, 0.2 to 0.8 milliseconds, goes
    // back to oneTBB. That is long enough to be still there when steps follow each other. A helper
    // that is called anew comes 20 to 50 microseconds late. Measured on two cores, steps of 0.75
    // milliseconds then took 8 % longer.
    static constexpr std::uint32_t patience = 1u << 14;
    // A thread that has waited for longer may be in the way of the thread that it waits for.
    static constexpr std::uint32_t pauses_before_yield = 1u << 9;
    // A share is this part of what is left of a range, at least `grain` items. Small shares come
    // last, so that all threads end together.
    static constexpr std::uint32_t share_of_rest = 8;

    static void pause(std::uint32_t pauses) {
        if (pauses > pauses_before_yield) return std::this_thread::yield();
#if defined(__x86_64__)
        __builtin_ia32_pause();
#elif defined(__aarch64__)
        asm volatile("yield");
#endif
    }

    /// One thread: the caller, or a helper.
    ///
    /// `left` holds the stage's number and the number of items of the thread's range that are not
    /// yet taken. A thread reads the board before it takes items. If `left` is unchanged since
    /// then, and not zero, the stage was not over and the board held this stage's work.
    struct alignas(64) Member {
        std::atomic<std::uint64_t> left = 0;
        std::atomic<bool> present = false;  ///< in the team, or on its way
    };

    /// What the caller and its helpers see.
    struct Board {
        explicit Board(int threads)
            : size(static_cast<std::uint32_t>(threads)),
              members(std::make_unique<Member[]>(size)) {}

        const std::uint32_t size;
        const std::unique_ptr<Member[]> members;
        std::atomic<const void*> work = nullptr;
        std::atomic<void (*)(const void*, std::uint32_t, std::uint32_t)> run = nullptr;
        std::atomic<std::uint32_t> count = 0, grain = 1;
        std::atomic<bool> closed = false, failed = false;
        std::exception_ptr failure;
        alignas(64) std::atomic<std::uint32_t> done = 0;

        std::uint32_t end_of(std::uint32_t member, std::uint32_t items) const {
            return static_cast<std::uint32_t>(std::uint64_t{items} * (member + 1) / size);
        }

        /// True if there was something to do in this stage.
        bool take_part(std::uint32_t stage, std::uint32_t self) {
            bool took = false;
            for (std::uint32_t k = 0; k < size; ++k) took |= take_from((self + k) % size, stage);
            return took;
        }

        bool take_from(std::uint32_t member, std::uint32_t stage) {
            bool took = false;
            std::atomic<std::uint64_t>& left = members[member].left;
            for (std::uint64_t seen = left.load(std::memory_order_acquire);;) {
                const auto items = static_cast<std::uint32_t>(seen);
                if (seen >> 32 != stage || items == 0) return took;
                const std::uint32_t begin = end_of(member, count.load(std::memory_order_relaxed)) -
                                            items;
                const std::uint32_t share = min_of(
                    items, max_of(grain.load(std::memory_order_relaxed), items / share_of_rest));
                const auto function = run.load(std::memory_order_relaxed);
                const void* const its_work = work.load(std::memory_order_relaxed);
                if (!left.compare_exchange_weak(seen, seen - share, std::memory_order_acq_rel,
                                                std::memory_order_acquire))
                    continue;
                took = true;
                try {
                    function(its_work, begin, begin + share);
                } catch (...) {
                    if (!failed.exchange(true, std::memory_order_relaxed))
                        failure = std::current_exception();
                }
                done.fetch_add(share, std::memory_order_acq_rel);
                seen = left.load(std::memory_order_acquire);
            }
        }

        void help(std::uint32_t self) {
            const std::atomic<std::uint64_t>& left = members[self].left;
            for (std::uint32_t idle = 0; idle < patience && !closed.load(std::memory_order_relaxed);
                 ++idle) {
                if (take_part(
                        static_cast<std::uint32_t>(left.load(std::memory_order_acquire) >> 32),
                        self))
                    idle = 0;
                pause(0);
            }
            members[self].present.store(false, std::memory_order_relaxed);
        }
    };

    void call_helpers() {
        for (std::uint32_t k = 1; k < board_.size; ++k) {
            if (board_.members[k].present.load(std::memory_order_relaxed)) continue;
            board_.members[k].present.store(true, std::memory_order_relaxed);
            const auto help = [first = TsanOrder(), board = &board_, k, last = TsanOrder()] {
                TsanOrder::pass();
                board->help(k);
            };
            // A deferred task is complete before its last TsanOrder is copied; run(help) would
            // write on.
            try {
                arena_.execute([&] { helpers_.run(helpers_.defer(help)); });
            } catch (...) {
                board_.members[k].present.store(false, std::memory_order_relaxed);
                throw;
            }
        }
    }

    tbb::task_arena& arena_;
    tbb::task_group helpers_;
    Board board_;
    std::uint32_t stage_ = 0;
};

}  // namespace pierce
