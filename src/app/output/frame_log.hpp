#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "scenes/detect/method.hpp"

namespace pierce::app {

/// Median, 95th percentile and maximum.
struct Spread {
    double median = 0, p95 = 0, max = 0;
};

/// Of an unsorted list; zeros if it is empty.
Spread spread_of(std::vector<double> values);

/// The results of all frames, and what is said about them at the end.
class FrameLog {
public:
    void add(const scenes::FrameResult& frame);

    std::size_t size() const { return frames_.size(); }
    const std::vector<scenes::FrameResult>& frames() const { return frames_; }
    /// What is written of the last frame.
    nlohmann::json last_json() const;
    /// A number of every frame.
    std::vector<double> column(double scenes::FrameResult::*member) const;
    std::vector<double> column(std::uint32_t scenes::FrameResult::*member) const;
    std::vector<double> touching_pairs() const;
    /// Milliseconds of a stage in every frame.
    std::vector<double> stage(const std::string& name) const;
    /// Names of the stages, in the order they ran.
    std::vector<std::string> stage_names() const;

    /// The table on standard output.
    void print() const;
    /// `machine`, `versions`, `settings`, `summary` and `frames`; throws InputError if the file
    /// cannot be written.
    void write_json(const std::filesystem::path& file, const nlohmann::json& settings) const;

private:
    std::vector<scenes::FrameResult> frames_;
};

}  // namespace pierce::app
