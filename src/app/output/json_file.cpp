#include "app/output/json_file.hpp"

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pierce/error.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

void write_json_file(const fs::path& file, const nlohmann::json& content) {
    std::ofstream out(file);
    out << content.dump(1) << '\n';
    if (!out.flush()) throw InputError("cannot write '" + file.string() + "'");
}

void check_writable(const fs::path& file) {
    if (file.empty()) return;
    const bool existed = fs::exists(file);
    std::FILE* opened = std::fopen(file.c_str(), "ab");
    if (opened == nullptr) throw InputError("cannot write '" + file.string() + "'");
    std::fclose(opened);
    if (!existed) fs::remove(file);
}

}  // namespace pierce::app
