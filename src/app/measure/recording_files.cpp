#include "app/measure/recording_files.hpp"

#include "app/output/progress.hpp"

namespace pierce::app {

scenes::Recording load_recording(const std::filesystem::path& folder) {
    return scenes::read_recording(folder, show_share("reading " + folder.string()));
}

void save_recording(const scenes::Recording& recording, const std::filesystem::path& folder) {
    scenes::write_recording(recording, folder, show_share("writing " + folder.string()));
}

}  // namespace pierce::app
