#include "app/page.hpp"

#include "pierce/error.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

Page::Page(const fs::path& folder) : folder_(folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw InputError("cannot make folder '" + folder.string() + "': " + error.message());
    out_.open(file());
    if (!out_) throw InputError("cannot write '" + file().string() + "'");
}

void Page::csv(const Table& table, const std::string& name) const {
    table.write_csv(folder_ / (name + ".csv"));
}

void Page::close() {
    if (!out_.flush()) throw InputError("cannot write '" + file().string() + "'");
    fmt::print("report: {}\n", fs::absolute(file()).string());
}

void Page::show(bool drawn, const std::string& name) {
    if (drawn)
        line("\n![{0}]({0}.svg)\n", name);
    else
        line("\n[{0}.csv]({0}.csv) (no picture: gnuplot is not installed)\n", name);
}

}  // namespace pierce::app
