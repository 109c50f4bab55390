#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

namespace pierce {

/// Threads that stand ready for the same work again and again, each with its number; the caller is
/// number 0.
class Crew {
public:
    explicit Crew(std::size_t members)
        : stays_awake_(2 * members <= std::thread::hardware_concurrency()), failures_(members) {
        try {
            for (std::size_t member = 1; member < members; ++member)
                others_.emplace_back([this, member] { stand_by(member); });
        } catch (...) {
            end();  // of those that have begun
            throw;
        }
    }
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;
    ~Crew() { end(); }

    /// Calls work(member) for every member at the same time, and waits for all of them. Throws what
    /// the first of them has thrown.
    void run(const std::function<void(std::size_t member)>& work) {
        work_ = &work;
        left_ = others_.size();
        call_out();
        try_one(0);
        for (std::size_t left = left_; left > 0; left = left_) await(left_, left);
        for (std::exception_ptr& failure : failures_)
            if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
    }

private:
    void end() {
        ends_ = true;
        call_out();
    }
    void call_out() {
        ++calls_;
        calls_.notify_all();
    }
    /// Waits until the value is another one. A thread that sleeps takes some 50 microseconds to
    /// wake, so where there are processors to spare, it stays awake for longer than the caller
    /// takes between two calls of a step.
    void await(const std::atomic<std::size_t>& value, std::size_t known) const {
        if (stays_awake_) {
            const auto end = std::chrono::steady_clock::now() + patience;
            while (value == known && std::chrono::steady_clock::now() < end) {
            }
        }
        value.wait(known);
    }
    void stand_by(std::size_t member) {
        for (std::size_t heard = 0;;) {
            await(calls_, heard);
            heard = calls_;
            if (ends_) return;
            try_one(member);
            if (--left_ == 0) left_.notify_one();
        }
    }
    void try_one(std::size_t member) {
        try {
            failures_[member] = nullptr;
            (*work_)(member);
        } catch (...) {
            failures_[member] = std::current_exception();
        }
    }

    static constexpr std::chrono::microseconds patience{500};

    bool stays_awake_;
    const std::function<void(std::size_t)>* work_ = nullptr;
    std::vector<std::exception_ptr> failures_;
    std::atomic<std::size_t> calls_ = 0, left_ = 0;
    std::atomic<bool> ends_ = false;
    std::vector<std::jthread> others_;
};

}  // namespace pierce
