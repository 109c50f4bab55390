#pragma once

#include <fmt/core.h>

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/output/plot.hpp"
#include "app/output/scatter_plot.hpp"

namespace pierce::app {

/// A report: report.md in a folder, with its pictures and CSV files beside it, and report.html, one
/// file that holds all of it. Every file says what it was made with.
class Page {
public:
    /// Makes the folder, and begins the page with its title and what it is made with: machine,
    /// versions, commit, and `settings`. Throws InputError if a file cannot be written, here and
    /// later.
    Page(const std::filesystem::path& folder, const std::string& title,
         const nlohmann::json& settings);

    template <class... T>
    void line(fmt::format_string<T...> format, T&&... values) {
        text_ += fmt::format(format, std::forward<T>(values)...) + '\n';
    }
    /// Curves, HeatMap or Scatter: NAME.csv, and NAME.svg shown on the page.
    template <class Plot>
    void plot(const Plot& plot, const std::string& name) {
        show(write_plot(plot, folder_, name, made_with_), name);
    }
    /// NAME.csv.
    void csv(const Table& table, const std::string& name) const;
    /// Shows a picture of the folder, NAME.
    void picture(const std::string& name, const std::string& caption);
    /// Where pictures go.
    const std::filesystem::path& folder() const { return folder_; }
    /// Writes report.md and report.html, and says where they are.
    void close();

private:
    void show(bool drawn, const std::string& name);

    std::filesystem::path folder_;
    std::string title_, made_with_, text_;
};

}  // namespace pierce::app
