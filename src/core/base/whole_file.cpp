#include "core/base/whole_file.hpp"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include "pierce/error.hpp"

namespace pierce {

namespace fs = std::filesystem;

namespace {

/// False for what has no place of its own in a folder: another file cannot take that.
bool can_be_replaced(const fs::path& file) {
    const std::string name = fs::absolute(file).lexically_normal().string();
    // Of /dev, only its folder for shared memory has files like others.
    if (name.starts_with("/proc/") || (name.starts_with("/dev/") && !name.starts_with("/dev/shm/")))
        return false;
    std::error_code failed;
    const fs::file_status status = fs::status(file, failed);
    return !fs::exists(status) || fs::is_regular_file(status);
}

/// The file itself, if `file` is a link to it. It need not be there.
fs::path behind_links(fs::path file) {
    constexpr int most_links = 40;  // as many as Linux follows
    std::error_code failed;
    for (int k = 0; k < most_links && fs::is_symlink(file, failed); ++k) {
        const fs::path next = fs::read_symlink(file, failed);
        if (failed) break;
        file = file.parent_path() / next;
    }
    return file;
}

/// Nobody else writes to a file with this ending: processes of two containers may have one number.
std::string unique_ending() {
    static std::atomic<std::uint64_t> next = 0;
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    return ".part-" + std::to_string(::getpid()) + "-" + std::to_string(now) + "-" +
           std::to_string(next++);
}

}  // namespace

WholeFile::WholeFile(fs::path file) : file_(std::move(file)), part_(file_) {
    if (!can_be_replaced(file_)) return;
    file_ = behind_links(file_);
    part_ = file_;
    part_ += unique_ending();
    if (!std::ofstream(part_)) part_ = file_;
}

WholeFile::~WholeFile() {
    std::error_code ignored;
    if (!kept_ && part_ != file_) fs::remove(part_, ignored);
}

void WholeFile::keep() {
    std::error_code failed;
    if (part_ != file_) {
        const fs::file_status before = fs::status(file_, failed);
        if (fs::exists(before)) fs::permissions(part_, before.permissions(), failed);
        fs::rename(part_, file_, failed);
        if (failed) refuse_to_write(file_);
    }
    kept_ = true;
}

void write_whole_file(const fs::path& file, const std::function<void(std::ostream&)>& write) {
    WholeFile whole(file);
    std::ofstream out(whole.part(), std::ios::binary);
    write(out);
    out.close();
    if (!out) refuse_to_write(file);
    whole.keep();
}

bool can_be_written(const fs::path& file) {
    std::error_code failed;
    const fs::file_status status = fs::status(file, failed);
    if (fs::is_directory(status)) return false;
    if (fs::exists(status)) return ::access(file.c_str(), W_OK) == 0;
    const WholeFile trial(file);  // goes again, as it is not kept
    return fs::exists(trial.part(), failed);
}

void refuse_to_write(const fs::path& file) {
    throw InputError("cannot write '" + file.string() + "'");
}

}  // namespace pierce
