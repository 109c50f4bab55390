#include "app/output/json_file.hpp"

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/output/waiting.hpp"
#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

void write_json_file(const fs::path& file, const nlohmann::json& content) {
    const Waiting waiting("writing " + file.string());
    write_text_file(file, content.dump(1) + '\n');
}

void write_text_file(const fs::path& file, const std::string& text) {
    WholeFile whole(file);
    {
        std::ofstream out(whole.part(), std::ios::binary);
        out << text;
        if (!out.flush()) refuse_to_write(file);
    }
    whole.keep();
}

void check_folder_writable(const fs::path& folder) {
    if (folder.empty()) return;
    std::error_code failed;
    fs::create_directories(folder, failed);
    check_writable(folder / "scene.json");
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
