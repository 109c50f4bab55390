#include "scenes/files/mesh_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <string>

#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"
#include "scenes/files/mesh_readers.hpp"

namespace pierce::scenes {
namespace {

constexpr std::size_t enough = 1 << 16;  // bytes to write at once

std::string content_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::error_code failed;
    if (!in || !std::filesystem::is_regular_file(file, failed))
        throw InputError("cannot open '" + file.string() + "'");
    std::string content(std::filesystem::file_size(file), '\0');
    if (!in.read(content.data(), static_cast<std::streamsize>(content.size())))
        throw InputError("cannot read '" + file.string() + "'");
    return content;
}

MeshData read(const std::string& kind, const std::string& content) {
    if (kind == ".obj") return read_obj(content);
    if (kind == ".ply") return read_ply(content);
    if (kind == ".stl") return read_stl(content);
    if (kind == ".off") return read_off(content);
    throw InputError("its name does not end with .obj, .ply, .stl or .off");
}

}  // namespace

MeshData read_mesh(const std::filesystem::path& file) {
    const std::string content = content_of(file);
    std::string kind = file.extension().string();
    std::ranges::transform(kind, kind.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    MeshData mesh;
    try {
        mesh = read(kind, content);
    } catch (const InputError& error) {
        throw InputError("cannot read '" + file.string() + "': " + error.what());
    }
    if (mesh.triangles.empty()) throw InputError("'" + file.string() + "' holds no triangles");
    return mesh;
}

void write_obj(const std::filesystem::path& file, const MeshData& mesh) {
    write_whole_file(file, [&](std::ostream& out) {
        fmt::memory_buffer text;
        const auto write = [&] {
            out.write(text.data(), static_cast<std::streamsize>(text.size()));
            text.clear();
        };
        for (Vec3f p : mesh.positions) {
            fmt::format_to(std::back_inserter(text), "v {} {} {}\n", p.x, p.y, p.z);
            if (text.size() > enough) write();
        }
        for (const Triangle& t : mesh.triangles) {
            fmt::format_to(std::back_inserter(text), "f {} {} {}\n", t.vertex[0] + 1,
                           t.vertex[1] + 1, t.vertex[2] + 1);
            if (text.size() > enough) write();
        }
        write();
    });
}

}  // namespace pierce::scenes
