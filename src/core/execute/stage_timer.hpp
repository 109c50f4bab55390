#pragma once

#include <chrono>

#include "pierce/plan.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {

/// Runs the stages that the plan asks for and notes how long they take. The times of a stage in
/// several parts are added up. Where an executor does not wait for its stages, settle() says when
/// they are over.
template <class E>
class StageTimer {
public:
    StageTimer(const E& executor, const Plan& plan, StepStats& stats)
        : executor_(executor), plan_(plan), stats_(stats) {}

    template <class F>
    void operator()(StageId stage, F&& work) {
        if (!plan_.needs(stage)) return;
        const auto begin = std::chrono::steady_clock::now();
        work();
        executor_.settle();
        const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() -
                                                                  begin;
        add_time(stats_.stages, stage, elapsed.count());
    }

private:
    const E& executor_;
    const Plan& plan_;
    StepStats& stats_;
};

}  // namespace pierce
