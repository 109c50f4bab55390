#pragma once

#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "app/plot.hpp"

namespace pierce::app {

/// A report's page, report.md in a folder, with its pictures and CSV files beside it.
class Page {
public:
    /// Makes the folder; throws InputError if it or the page cannot be written, here and later.
    explicit Page(const std::filesystem::path& folder);

    template <class... T>
    void line(fmt::format_string<T...> format, T&&... values) {
        out_ << fmt::format(format, std::forward<T>(values)...) << '\n';
    }
    /// Curves, HeatMap or Scatter: NAME.csv, and NAME.svg shown on the page.
    template <class Plot>
    void plot(const Plot& plot, const std::string& name) {
        show(write_plot(plot, folder_, name), name);
    }
    /// NAME.csv.
    void csv(const Table& table, const std::string& name) const;
    /// Says where the page is.
    void close();

private:
    std::filesystem::path file() const { return folder_ / "report.md"; }
    void show(bool drawn, const std::string& name);

    std::filesystem::path folder_;
    std::ofstream out_;
};

}  // namespace pierce::app
