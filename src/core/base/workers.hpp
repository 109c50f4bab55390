#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace pierce {

/// Threads for work that is done once, and whom to tell how far it is.
class Workers {
public:
    /// What is being done, and the share of it that is done, from 0 to 1.
    using Progress = std::function<void(std::string_view what, double share)>;

    /// `threads`: 0 is one per processor. `progress` may be empty; it is called by one thread at a
    /// time, now and then, once the workers have been at work for `patience`, and at last with 1.
    explicit Workers(std::uint32_t threads, Progress progress = {})
        : threads_(threads > 0 ? threads : std::max(std::thread::hardware_concurrency(), 1u)),
          progress_(std::move(progress)) {}

    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;
    /// Tells that all is done, if anything was told.
    ~Workers() {
        if (!told_.empty()) progress_(told_, 1.0);
    }

    std::uint32_t threads() const { return threads_; }

    /// Calls work(begin, end) for parts of [0, count), `part` each, on all threads, this one among
    /// them. Throws what a call has thrown; the other calls are made nevertheless.
    template <class Work>
    void share_out(std::string_view what, std::uint32_t count, std::uint32_t part,
                   const Work& work) {
        std::atomic<std::uint64_t> next = 0;
        std::exception_ptr failure;
        std::mutex lock;
        const auto take_parts = [&] {
            for (std::uint64_t begin; (begin = next.fetch_add(part)) < count;) try {
                    const std::uint64_t end = std::min<std::uint64_t>(begin + part, count);
                    work(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end));
                    tell(what, static_cast<double>(end) / count);
                } catch (...) {
                    const std::lock_guard guard(lock);
                    if (!failure) failure = std::current_exception();
                }
        };
        {
            std::vector<std::jthread> helpers;
            const std::uint64_t parts = (std::uint64_t{count} + part - 1) / part;
            const std::uint64_t wanted = std::min<std::uint64_t>(threads_, parts);
            for (std::uint64_t helper = 1; helper < wanted; ++helper)
                helpers.emplace_back(take_parts);
            take_parts();
        }
        if (failure) std::rethrow_exception(failure);
    }

    /// Calls some functions, each once, on all threads.
    template <class... Jobs>
    void side_by_side(std::string_view what, const Jobs&... jobs) {
        share_out(what, sizeof...(Jobs), 1, [&](std::uint32_t begin, std::uint32_t) {
            std::uint32_t place = 0;
            const auto run = [&](const auto& job) {
                if (place++ == begin) job();
            };
            (run(jobs), ...);
        });
    }

private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::milliseconds patience{200}, pause{50};

    void tell(std::string_view what, double share) {
        if (!progress_) return;
        const std::lock_guard guard(telling_);
        const Clock::time_point now = Clock::now();
        if (now < next_) return;
        next_ = now + pause;
        told_ = what;
        progress_(what, share);
    }

    std::uint32_t threads_;
    Progress progress_;
    std::mutex telling_;
    std::string told_;  ///< what progress was told of last
    Clock::time_point next_ = Clock::now() + patience;
};

}  // namespace pierce
