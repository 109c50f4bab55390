#include "fuzz/hostile_files.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "core/base/archive.hpp"
#include "fuzz/generator.hpp"
#include "fuzz/player.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/files/npy.hpp"
#include "scenes/files/sheet_truth_file.hpp"
#include "scenes/files/truth_file.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr const char* names[] = {"obj",       "ply",   "stl",         "off",         "npy",
                                 "recording", "truth", "sheet_truth", "saved_world", "program"};
static_assert(std::size(names) == static_cast<std::size_t>(Reader::count));

/// A folder of this process, gone with it.
const fs::path& folder() {
    struct Folder {
        fs::path path = fs::temp_directory_path() / ("pierce_fuzz_" + std::to_string(getpid()));
        Folder() { fs::create_directories(path); }
        ~Folder() {
            std::error_code ignored;
            fs::remove_all(path, ignored);
        }
    };
    static const Folder made;
    return made.path;
}

fs::path put(const char* name, const std::string& content) {
    const fs::path path = folder() / name;
    std::ofstream(path, std::ios::binary) << content;
    return path;
}

std::string content_of(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
void append(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

constexpr const char* square_obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

std::string binary_ply() {
    std::string ply =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float "
        "y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    for (float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f}) append(ply, x);
    for (const auto& t : {std::array{0, 1, 2}, {0, 2, 3}}) {
        append(ply, std::uint8_t{3});
        for (int v : t) append(ply, v);
    }
    return ply;
}

std::string binary_stl() {
    std::string stl(80, ' ');
    append(stl, std::uint32_t{1});
    for (float x : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) append(stl, x);
    append(stl, std::uint16_t{0});
    return stl;
}

std::string saved_world(std::uint64_t seed) {
    const std::vector<std::uint8_t> bytes = bytes_of(seed);
    Choices choices(bytes);
    const Program program = random_program(choices);
    try {
        Player player([] { return reference_backend(); }, program.settings);
        for (const Call& call : program.calls) player.play(call);
        return player.save();
    } catch (const InputError&) {  // its settings
        return Player([] { return reference_backend(); }, {}).save();
    }
}

/// The checksum of a saved world made right again, so that what is behind it is looked at, too.
std::string sealed(std::string saved) {
    constexpr std::size_t header = 28;
    if (saved.size() < header) return saved;
    const std::uint64_t length = saved.size() - header, sum = checksum(saved.substr(header));
    std::memcpy(saved.data() + 12, &length, sizeof length);
    std::memcpy(saved.data() + 20, &sum, sizeof sum);
    return saved;
}

void play_on(const std::string& saved) {
    std::istringstream in(saved);
    World world = World::restore(in, reference_backend());
    for (int step = 0; step < 2; ++step) world.detect();
}

}  // namespace

const char* name_of(Reader reader) { return names[static_cast<std::size_t>(reader)]; }

std::string sound_file(Reader reader, std::uint64_t seed) {
    const bool other = seed % 2 == 1;
    switch (reader) {
        case Reader::obj:
            return other ? std::string(square_obj) + "vn 0 0 1\nvt 0 0\nf 1/1/1 2//1 3\n"
                         : square_obj;
        case Reader::ply:
            return other ? binary_ply()
                         : "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
                           "float y\nproperty float z\n"
                           "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 "
                           "0 0\n1 0 0\n0 1 0\n3 0 1 "
                           "2\n";
        case Reader::stl:
            return other ? binary_stl()
                         : "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                           "0\nvertex 0 1 0\nendloop\n"
                           "endfacet\nendsolid a\n";
        case Reader::off:
            return "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        case Reader::npy: {
            const std::vector<float> values(14, 0.5f);
            const std::size_t shape[] = {2, 7};
            scenes::write_npy(folder() / "a.npy", shape, values);
            return content_of(folder() / "a.npy");
        }
        case Reader::recording:
            return R"({"format": "pierce-recording", "version": 1, "dt": 0.01, 
  "meshes": [{"name": "m", "file": "m.obj"}],
 "bodies": [{"name": "b", "mesh": "m", "motion": "rigid", "poses": "p.npy"},
 {"name": "c", "mesh": "m", "motion": "static", "poses": "p.npy", "ground": true,
   "collision": {"self": "on", "sheet": true}}]})";
        case Reader::truth:
            return R"({"format": "pierce-truth", "version": 1,
  "frames": [{"frame": 0, "overlapping": [[0, 1]],
 "inside": [[0, 1, 2, 0.5, 1, 0, 0]]}]})";
        case Reader::sheet_truth:
            return R"({"format": "pierce-sheet-truth", "version": 1,
  "frames": [{"frame": 1, "meetings": [[1, 0, 1, 2, 3]],
 "piercings": [[0, 1, 2, 3, 0.5]]}]})";
        case Reader::saved_world:
            return saved_world(seed);
        case Reader::program: {
            const std::vector<std::uint8_t> bytes = bytes_of(seed);
            Choices choices(bytes);
            return to_text(random_program(choices));
        }
        case Reader::count:
            break;
    }
    return {};
}

bool read(Reader reader, const std::string& content) {
    try {
        switch (reader) {
            case Reader::obj:
                scenes::read_mesh(put("m.obj", content));
                break;
            case Reader::ply:
                scenes::read_mesh(put("m.ply", content));
                break;
            case Reader::stl:
                scenes::read_mesh(put("m.stl", content));
                break;
            case Reader::off:
                scenes::read_mesh(put("m.off", content));
                break;
            case Reader::npy:
                scenes::read_npy(put("a.npy", content));
                break;
            case Reader::recording: {
                put("m.obj", square_obj);
                const std::vector<float> values = {0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1};
                const std::size_t shape[] = {2, 7};
                scenes::write_npy(folder() / "p.npy", shape, values);
                put("scene.json", content);
                scenes::read_recording(folder());
                break;
            }
            case Reader::truth:
                scenes::read_truth(put("t.json", content));
                break;
            case Reader::sheet_truth:
                scenes::read_sheet_truth(put("t.json", content));
                break;
            case Reader::saved_world:
                play_on(sealed(content));
                break;
            case Reader::program:
                try {
                    program_of(content);
                } catch (const std::exception& error) {
                    throw InputError(error.what());
                }
                break;
            case Reader::count:
                break;
        }
        return true;
    } catch (const InputError&) {
        return false;
    }
}

std::string spoiled(std::string content, std::uint64_t seed) {
    std::mt19937_64 engine(seed);
    const auto below = [&](std::size_t count) {
        return static_cast<std::size_t>(engine() % std::max<std::size_t>(count, 1));
    };
    static constexpr const char* words[] = {
        "-1", "0",  "4294967295",   "18446744073709551615", "1e400", "nan",  "-inf",
        "\n", " ",  "999999999999", "2147483648",           "uint",  "char", "[",
        "{",  "\"", "null"};
    for (std::size_t left = 1 + below(4); left > 0 && !content.empty(); --left) {
        const std::size_t at = below(content.size()),
                          length = std::min(below(16) + 1, content.size() - at);
        switch (below(8)) {
            case 0:
                content[at] = static_cast<char>(content[at] ^ (1 << below(8)));
                break;
            case 1:
                content[at] = static_cast<char>(engine());
                break;
            case 2:
                content.resize(at);
                break;
            case 3:
                content.erase(at, length);
                break;
            case 4:
                content.insert(at, content.substr(at, length));
                break;
            case 5:
                content.insert(at, words[below(std::size(words))]);
                break;
            case 6: {
                // A number in place of another.
                const std::size_t digit = content.find_first_of("0123456789", at);
                if (digit == std::string::npos) break;
                const std::size_t end = content.find_first_not_of("0123456789.", digit);
                content.replace(digit, std::min(end, content.size()) - digit,
                                words[below(std::size(words))]);
                break;
            }
            default:
                for (std::size_t k = at; k < std::min(at + 4, content.size()); ++k)
                    content[k] = below(2) ? '\xff' : static_cast<char>(engine());
        }
    }
    return content;
}

}  // namespace pierce::fuzz
