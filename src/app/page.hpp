#pragma once

#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace pierce::app {

/// report.md in a folder, written line by line.
class Page {
public:
    /// Makes the folder. Throws InputError if folder or file cannot be written.
    explicit Page(const std::filesystem::path& folder);

    template <class... T>
    void line(fmt::format_string<T...> format, T&&... values) {
        out_ << fmt::format(format, std::forward<T>(values)...) << '\n';
    }
    /// Shows NAME.svg or, if it was not `made`, names NAME.csv.
    void picture(bool made, const std::string& name);
    /// Says where the page is. Throws InputError if it could not be written.
    void close();

private:
    std::filesystem::path file_;
    std::ofstream out_;
};

}  // namespace pierce::app
