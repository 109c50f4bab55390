#pragma once

#include <chrono>

#include "pierce/step_stats.hpp"

namespace pierce {

/// Times stages into a StepStats; a stage that runs twice adds up. Stages of an executor that does
/// not wait for them are over when it says so.
template <class E>
class StageTimer {
public:
    StageTimer(const E& executor, StepStats& stats) : executor_(executor), stats_(stats) {}

    template <class F>
    void operator()(const char* name, F&& stage) {
        const auto begin = std::chrono::steady_clock::now();
        stage();
        executor_.settle();
        const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() -
                                                                  begin;
        for (StepStats::Stage& s : stats_.stages)
            if (s.name == name) {
                s.milliseconds += elapsed.count();
                return;
            }
        stats_.stages.push_back({name, elapsed.count()});
    }

private:
    const E& executor_;
    StepStats& stats_;
};

}  // namespace pierce
