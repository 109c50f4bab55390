#pragma once

#include <fmt/core.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "app/output/plot.hpp"

namespace pierce::app {

/// A report: report.md in a folder, with its pictures and CSV files beside it, and report.html, one
/// file that holds all of it. Every file says what it was made with.
class Page {
public:
    /// Makes the folder, and begins the page with its title and what it is made with: machine,
    /// versions, commit, and `settings`. `html`: the one file, in place of the folder's
    /// report.html; empty: none. Throws InputError if a file cannot be written, here and later.
    Page(const std::filesystem::path& folder, const std::string& title,
         const nlohmann::json& settings, const std::filesystem::path& html);

    template <class... T>
    void line(fmt::format_string<T...> format, T&&... values) {
        text_ += fmt::format(format, std::forward<T>(values)...) + '\n';
    }
    /// Curves, HeatMap or Scatter: NAME.csv, and NAME.svg shown here on the page. close() draws all
    /// plots at once, when nothing is measured any more.
    template <class Plot>
    void plot(const Plot& plot, const std::string& name) {
        csv(plot.table, name);
        descriptions_.push_back(description_of(plot, folder_ / (name + ".svg")));
        plots_.push_back({name, text_.size()});
    }
    /// NAME.csv.
    void csv(const Table& table, const std::string& name) const;
    /// Shows a picture of the folder, NAME.
    void picture(const std::string& name, const std::string& caption);
    /// Where pictures go.
    const std::filesystem::path& folder() const { return folder_; }
    /// A part of a report, and what writes it.
    struct Part {
        std::string name;
        std::function<void()> write;
    };
    /// Writes parts in their order, and closes the page. If a signal stops one, the page says which
    /// parts are missing.
    void write(std::span<const Part> parts);
    /// Draws the plots, writes report.md and report.html, and says where they are. Without
    /// matplotlib the page says that there are no pictures.
    void close();

private:
    void show_plots();

    struct Shown {
        std::string name;
        std::size_t at;  ///< in the text
    };

    std::filesystem::path folder_, html_;
    std::string title_, made_with_, text_;
    std::vector<Shown> plots_;
    std::vector<std::string> descriptions_;
};

}  // namespace pierce::app
