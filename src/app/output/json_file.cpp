#include "app/output/json_file.hpp"

#include <nlohmann/json.hpp>
#include <ostream>

#include "app/output/interrupt.hpp"
#include "app/output/waiting.hpp"
#include "core/base/whole_file.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

void write_json_file(const fs::path& file, const nlohmann::json& content) {
    const Waiting waiting("writing " + file.string());
    // Names of files need not be UTF-8.
    write_text_file(file,
                    content.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
}

void write_text_file(const fs::path& file, const std::string& text) {
    const InterruptDelay delay;
    write_whole_file(file, [&](std::ostream& out) { out << text; });
}

void check_folder_writable(const fs::path& folder) {
    if (folder.empty()) return;
    std::error_code failed;
    fs::create_directories(folder, failed);
    check_writable(folder / "scene.json");
}

void check_writable(const fs::path& file) {
    if (file.empty()) return;
    if (!can_be_written(file)) refuse_to_write(file);
}

}  // namespace pierce::app
