#include "scenes/files/npy.hpp"

#include <charconv>
#include <fstream>
#include <xtensor/xadapt.hpp>
#include <xtensor/xarray.hpp>
#include <xtensor/xnpy.hpp>

#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"

namespace pierce::scenes {
namespace {

/// What a header says of the type of its numbers.
std::string type_in(const std::string& header) {
    const std::string key = "'descr':";
    const std::size_t begin = header.find(key);
    if (begin == std::string::npos) return "it does not say which";
    const std::size_t from = header.find_first_not_of(' ', begin + key.size());
    if (from == std::string::npos) return "it does not say which";
    return header.substr(from, header.find(',', from) - from);
}

/// Throws unless the file is as long as its header says: xtensor allocates what the header says
/// before it reads. The format: six bytes of magic, two of version, the header's length in two or
/// four, and the header, a Python dictionary.
void check_size(std::ifstream& in, std::uintmax_t file_size) {
    char start[8] = {}, length_bytes[4] = {};
    in.read(start, sizeof start);
    const int length_size = start[6] == 1 ? 2 : 4;
    in.read(length_bytes, length_size);
    std::uint32_t length = 0;
    for (int k = 0; k < 4; ++k)
        length |= std::uint32_t{static_cast<std::uint8_t>(length_bytes[k])} << (8 * k);
    const std::uintmax_t begin = sizeof start + static_cast<unsigned>(length_size) +
                                 std::uintmax_t{length};
    if (!in || begin > file_size) throw std::runtime_error("its header is cut short");
    std::string header(length, '\0');
    in.read(header.data(), length);
    if (header.find("<f4") == std::string::npos)
        throw std::runtime_error("its numbers are of another type: " + type_in(header));
    const std::size_t name = header.find("'shape'"), open = header.find('(', name),
                      close = header.find(')', open);
    if (name == std::string::npos || open == std::string::npos || close == std::string::npos)
        throw std::runtime_error("its header has no shape");
    std::uintmax_t size = sizeof(float);
    for (const char* at = header.data() + open; at < header.data() + close;) {
        std::uintmax_t extent = 0;
        const auto [end, error] = std::from_chars(at, header.data() + close, extent);
        if (*at == '-') throw std::runtime_error("its header has a negative size");
        if (error == std::errc::invalid_argument) {
            ++at;  // skips what is between two numbers
            continue;
        }
        if (error != std::errc() || (extent > 0 && size > file_size / extent))
            throw std::runtime_error("its header promises more than it holds");
        size *= extent;
        at = end;
    }
    if (size != file_size - begin) throw std::runtime_error("its size does not fit its header");
    in.seekg(0);
}

}  // namespace

FloatArray read_npy(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError("cannot open '" + file.string() + "'");
    try {
        check_size(in, std::filesystem::file_size(file));
        const auto array = xt::load_npy<float>(in);
        return {{array.shape().begin(), array.shape().end()}, {array.begin(), array.end()}};
    } catch (const std::exception& error) {
        throw InputError("cannot read '" + file.string() + "' as float32 .npy: " + error.what());
    }
}

void write_npy(const std::filesystem::path& file, std::span<const std::size_t> shape,
               std::span<const float> values) {
    const std::vector<std::size_t> dimensions(shape.begin(), shape.end());
    const auto array = xt::adapt(values.data(), values.size(), xt::no_ownership(), dimensions);
    write_whole_file(file, [&](std::ostream& out) { out << xt::dump_npy(array); });
}

}  // namespace pierce::scenes
