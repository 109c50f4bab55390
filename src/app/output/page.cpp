#include "app/output/page.hpp"

#include <nlohmann/json.hpp>
#include <ranges>

#include "app/output/draw_plots.hpp"
#include "app/output/interrupt.hpp"
#include "app/output/json_file.hpp"
#include "app/output/provenance.hpp"
#include "app/output/self_contained.hpp"
#include "pierce/error.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

Page::Page(const fs::path& folder, const std::string& title, const nlohmann::json& settings,
           const fs::path& html)
    : folder_(folder), html_(html.empty() ? folder / "report.html" : html), title_(title) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw InputError("cannot make folder '" + folder.string() + "': " + error.message());
    const nlohmann::json made_with{
        {"machine", machine_json()}, {"versions", versions_json()}, {"settings", settings}};
    made_with_ = made_with.dump();
    line("# {}\n", title);
    line("| | |\n|---|---|");
    for (const auto& [part, values] : made_with.items())
        for (const auto& [key, value] : values.items())
            line("| {} | {} |", key, value.is_string() ? value.get<std::string>() : value.dump());
    line("");
    // A long run shall not end with a page that cannot be written.
    write_text_file(folder_ / "report.md", text_);
    check_writable(html_);
}

void Page::csv(const Table& table, const std::string& name) const {
    table.write_csv(folder_ / (name + ".csv"), made_with_);
}

void Page::picture(const std::string& name, const std::string& caption) {
    line("\n![{}]({})\n", caption, name);
}

void Page::write(std::span<const Part> parts) {
    const InterruptDelay delay;
    std::size_t done = 0;
    const auto stop = until_interrupted([&] {
        for (const Part& part : parts) {
            part.write();
            ++done;
            if (should_stop() && done < parts.size())
                throw Interrupted("stopped after the part " + part.name);
        }
    });
    if (stop) {
        std::string missing;
        for (const Part& part : parts.subspan(done))
            missing += (missing.empty() ? "" : ", ") + part.name;
        const std::string line = fmt::format("{}: these parts are missing, or not complete: {}",
                                             stop->what(), missing);
        fmt::print(stderr, "pierce: {}\n", line);
        this->line("\n**This report was {}.**", line);
    }
    close();
}

void Page::close() {
    show_plots();
    const fs::path markdown = folder_ / "report.md";
    write_text_file(markdown, text_);
    write_text_file(html_, self_contained_html(title_, text_, folder_));
    fmt::print("report: {}\n", fs::absolute(markdown).string());
    fmt::print("in one file: {}\n", fs::absolute(html_).string());
}

void Page::show_plots() {
    const std::string problem = draw_plots(descriptions_);
    // From the last one: where the others stand does not change.
    for (const auto& [name, at] : plots_ | std::views::reverse)
        text_.insert(at, problem.empty() ? fmt::format("\n![{0}]({0}.svg)\n\n", name)
                                         : fmt::format("\n[{0}.csv]({0}.csv) (no picture: {1})\n\n",
                                                       name, problem));
    plots_.clear();
    descriptions_.clear();
}

}  // namespace pierce::app
