#include "core/mesh_build/mesh_cache.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <fstream>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/archive.hpp"
#include "core/base/whole_file.hpp"
#include "core/mesh_build/slab_grid.hpp"
#include "pierce/error.hpp"

namespace pierce {

template <class A>
void transfer(A& archive, MeshNeeds& n) {
    transfer_all(archive, n.clearance, n.rings, n.slabs, n.stars, n.own_exits);
}

namespace {

constexpr std::uint64_t mark = 0x6873656d63727000;  // "prcmesh"
/// To be raised when anything is measured in another way; MeshCacheTest notices.
constexpr std::uint32_t version = 2;

/// Two numbers that differ for different surfaces.
std::array<std::uint64_t, 2> key_of(const MeshView& mesh) {
    std::array<std::uint64_t, 2> key = {0xcbf29ce484222325ull, 0x9e3779b97f4a7c15ull};
    const auto add = [&](std::uint32_t word) {
        for (std::uint64_t& k : key) k = (k ^ word) * 0x100000001b3ull;
        key[1] ^= key[1] >> 29;
    };
    add(mesh.positions.size);
    for (Vec3f p : mesh.positions)
        for (int r = 0; r < 3; ++r) add(std::bit_cast<std::uint32_t>(p[r]));
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t.vertex) add(v);
    for (Cover cover : mesh.covered) add(static_cast<std::uint32_t>(cover));
    return key;
}

/// Elements as they are in memory.
template <class T>
void write(ArchiveWriter& archive, std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    transfer_length(archive, values.size());
    archive.number(values.data(), values.size_bytes());
}

template <class T>
void read(ArchiveReader& archive, std::vector<T>& values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (transfer_length(archive, 0) != count || count * sizeof(T) > archive.left())
        throw InputError("a measured mesh has arrays of another length");
    values.resize(count);
    archive.number(values.data(), count * sizeof(T));
}

std::size_t cells_of(const ClearanceGridLayout& layout) {
    std::size_t cells = 1;
    for (std::int32_t size : layout.size) cells *= static_cast<std::size_t>(size);
    return cells;
}

/// The grids of a mesh.
struct Grids {
    ClearanceGridLayout clearance, slabs;

    explicit Grids(const MeshView& mesh) {
        const std::span positions(mesh.positions.data, mesh.positions.size);
        const std::span triangles(mesh.triangles.data, mesh.triangles.size);
        clearance = clearance_layout(positions, triangles);
        slabs = clearance_layout(positions, triangles, slab_resolution(triangles.size()));
    }
};

constexpr std::size_t header_bytes = 2 * sizeof(std::uint64_t) + sizeof(std::uint32_t);

/// [byte] No file of the mesh is longer.
std::size_t most_bytes(const MeshView& mesh, const Grids& grids) {
    constexpr std::size_t numbers = 128;  // the key, what there is, and lengths
    const auto per = [](const auto& list) { return sizeof(list.data[0]); };
    const std::size_t slab_cells = cells_of(grids.slabs);
    return header_bytes + numbers + cells_of(grids.clearance) * per(mesh.clearance_steps) +
           mesh.triangles.size * per(mesh.rings) +
           mesh.positions.size * (per(mesh.star_clearance) + per(mesh.own_exit)) +
           slab_cells * per(mesh.slab_cells) + (slab_cells + 1) * per(mesh.slabs);
}

/// Empty for what is no file, or is longer.
std::string content_of(const std::filesystem::path& file, std::size_t most) {
    std::error_code failed;
    if (!std::filesystem::is_regular_file(file, failed)) return {};
    const std::uintmax_t size = std::filesystem::file_size(file, failed);
    if (failed || size > most) return {};
    std::string bytes(static_cast<std::size_t>(size), '\0');
    std::ifstream in(file, std::ios::binary);
    if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return {};
    return bytes;
}

}  // namespace

MeshCache::MeshCache(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::error_code failed;
    std::filesystem::create_directories(folder_, failed);
    if (!std::filesystem::is_directory(folder_, failed))
        throw InputError("there is no folder '" + folder_.string() +
                         "' for measured meshes, and none can be made");
}

std::filesystem::path MeshCache::file_of(const MeshView& mesh) const {
    constexpr const char* digits = "0123456789abcdef";
    std::string name;
    for (std::uint64_t k : key_of(mesh))
        for (int shift = 60; shift >= 0; shift -= 4) name += digits[k >> shift & 15];
    return folder_ / (name + ".mesh");
}

MeshNeeds MeshCache::load(const MeshView& mesh, MeshArrays<MeshVector>& arrays,
                          MeshShape& shape) const {
    const Grids grids(mesh);
    const std::string bytes = content_of(file_of(mesh), most_bytes(mesh, grids));
    if (bytes.size() < header_bytes) return {};
    try {
        ArchiveReader archive(bytes);
        std::uint64_t its_mark = 0, sum = 0;
        std::uint32_t its_version = 0;
        transfer_all(archive, its_mark, its_version, sum);
        if (its_mark != mark || its_version != version ||
            sum != checksum(bytes.substr(header_bytes)))
            return {};
        std::uint64_t key[2] = {};
        MeshNeeds has;
        bool simple = false;
        transfer_all(archive, key, has, simple);
        if (!std::ranges::equal(key, key_of(mesh))) return {};
        MeshArrays<MeshVector> found;
        if (has.clearance) read(archive, found.clearance_steps, cells_of(grids.clearance));
        if (has.rings) read(archive, found.rings, mesh.triangles.size);
        if (has.stars) read(archive, found.star_clearance, mesh.positions.size);
        if (has.own_exits) read(archive, found.own_exit, mesh.positions.size);
        if (has.slabs) {
            read(archive, found.slab_cells, cells_of(grids.slabs));
            std::uint64_t slabs = 0;
            transfer(archive, slabs);
            read(archive, found.slabs, slabs);
            if (!std::ranges::all_of(found.slab_cells, [&](const SlabCell& cell) {
                    return cell.slab < found.slabs.size();
                }))
                return {};
        }
        if (archive.left() != 0) return {};
        if (has.clearance) {
            arrays.clearance_steps = std::move(found.clearance_steps);
            shape.clearance_at = grids.clearance;
        }
        if (has.rings) {
            arrays.rings = std::move(found.rings);
            shape.simple = simple;
        }
        if (has.stars) arrays.star_clearance = std::move(found.star_clearance);
        if (has.own_exits) arrays.own_exit = std::move(found.own_exit);
        if (has.slabs) {
            arrays.slab_cells = std::move(found.slab_cells);
            arrays.slabs = std::move(found.slabs);
            shape.slabs_at = grids.slabs;
        }
        return has;
    } catch (const InputError&) {
        return {};  // as if there were no file: the mesh is measured
    }
}

void MeshCache::store(const MeshView& mesh, const MeshNeeds& made) const {
    ArchiveWriter archive;
    const std::array<std::uint64_t, 2> key = key_of(mesh);
    std::uint64_t first = key[0], second = key[1], slabs = mesh.slabs.size;
    MeshNeeds has = made;
    bool simple = mesh.simple;
    transfer_all(archive, first, second, has, simple);
    const auto put = [&](const auto& view) { write(archive, std::span(view.data, view.size)); };
    if (has.clearance) put(mesh.clearance_steps);
    if (has.rings) put(mesh.rings);
    if (has.stars) put(mesh.star_clearance);
    if (has.own_exits) put(mesh.own_exit);
    if (has.slabs) {
        put(mesh.slab_cells);
        transfer(archive, slabs);
        put(mesh.slabs);
    }
    std::uint64_t its_mark = mark, sum = checksum(archive.bytes());
    std::uint32_t its_version = version;
    ArchiveWriter header;
    transfer_all(header, its_mark, its_version, sum);

    // A link may lead elsewhere, and what is no file may keep the program waiting.
    std::error_code failed;
    const std::filesystem::file_status there = std::filesystem::symlink_status(file_of(mesh),
                                                                               failed);
    if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) return;
    try {
        // Others may read or write the file at the same time, so it appears as a whole.
        write_whole_file(file_of(mesh),
                         [&](std::ostream& out) { out << header.bytes() << archive.bytes(); });
    } catch (const InputError&) {
        return;  // the next program measures the mesh again
    }
}

}  // namespace pierce
