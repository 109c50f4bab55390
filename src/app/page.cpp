#include "page.hpp"

#include "pierce/core/error.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

Page::Page(const fs::path& folder) : file_(folder / "report.md") {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw InputError("cannot make folder '" + folder.string() + "': " + error.message());
    out_.open(file_);
    if (!out_) throw InputError("cannot write '" + file_.string() + "'");
}

void Page::picture(bool made, const std::string& name) {
    if (made)
        line("\n![{0}]({0}.svg)\n", name);
    else
        line("\n[{0}.csv]({0}.csv) (no picture: gnuplot is not installed)\n", name);
}

void Page::close() {
    if (!out_.flush()) throw InputError("cannot write '" + file_.string() + "'");
    fmt::print("report: {}\n", fs::absolute(file_).string());
}

}  // namespace pierce::app
