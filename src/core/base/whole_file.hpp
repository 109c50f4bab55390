#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>

namespace pierce {

/// A file that is there as a whole or not at all: it is written under another name beside its own,
/// and takes its own when it is kept. What was there before stays until then. A link stays one.
/// Devices and pipes, files of /proc, and files in folders that nothing can be added to, are
/// written as they are.
class WholeFile {
public:
    explicit WholeFile(std::filesystem::path file);
    /// Removes what was not kept.
    ~WholeFile();
    WholeFile(const WholeFile&) = delete;
    WholeFile& operator=(const WholeFile&) = delete;

    /// Where to write.
    const std::filesystem::path& part() const { return part_; }
    /// All is written, and closed. Throws InputError if it cannot be put in its place.
    void keep();

private:
    std::filesystem::path file_, part_;
    bool kept_ = false;
};

/// Writes a WholeFile. Throws InputError if not all of it can be written.
void write_whole_file(const std::filesystem::path& file,
                      const std::function<void(std::ostream&)>& write);

/// True if a WholeFile can be put there. What is there is neither opened nor changed.
bool can_be_written(const std::filesystem::path& file);

/// Throws InputError that says that a file cannot be written.
[[noreturn]] void refuse_to_write(const std::filesystem::path& file);

}  // namespace pierce
