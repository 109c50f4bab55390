#include "app/output/json_file.hpp"

#include <nlohmann/json.hpp>
#include <ostream>
#include <set>
#include <system_error>

#include "app/output/interrupt.hpp"
#include "app/output/waiting.hpp"
#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"

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

void check_different(const std::vector<fs::path>& files) {
    std::set<fs::path> seen;
    for (const fs::path& file : files) {
        std::error_code failed;
        // To a terminal or a pipe, one can be written after the other.
        if (file.empty() || (fs::exists(file, failed) && !fs::is_regular_file(file, failed)))
            continue;
        if (!seen.insert(fs::weakly_canonical(file, failed)).second)
            throw InputError("two files are to be written as '" + file.string() + "'");
    }
}

}  // namespace pierce::app
