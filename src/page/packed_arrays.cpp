#include "page/packed_arrays.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "page/base64.hpp"

namespace pierce::page {
namespace {

static_assert(std::endian::native == std::endian::little, "pages hold little-endian numbers");

/// The bits of number `i`, less those of the number `stride` before it.
std::uint64_t difference(const unsigned char* numbers, std::size_t width, std::size_t i,
                         std::size_t stride) {
    std::uint64_t now = 0, before = 0;
    std::memcpy(&now, numbers + i * width, width);
    if (stride > 0 && i >= stride) std::memcpy(&before, numbers + (i - stride) * width, width);
    return now - before;
}

/// So many bytes are deflated between two calls of those who are told.
constexpr std::size_t deflated_at_once = std::size_t{1} << 20;

std::string deflated(std::vector<unsigned char> bytes,
                     const std::function<void(double)>& progress) {
    z_stream stream{};
    if (deflateInit(&stream, Z_DEFAULT_COMPRESSION) != Z_OK)
        throw std::runtime_error("zlib cannot compress a page's numbers");
    std::string result;
    std::vector<unsigned char> part(deflated_at_once);
    for (std::size_t begin = 0, end = 0; begin < bytes.size(); begin = end) {
        end = std::min(begin + deflated_at_once, bytes.size());
        stream.next_in = bytes.data() + begin;
        stream.avail_in = static_cast<uInt>(end - begin);
        do {
            stream.next_out = part.data();
            stream.avail_out = static_cast<uInt>(part.size());
            deflate(&stream, end < bytes.size() ? Z_NO_FLUSH : Z_FINISH);
            result.append(reinterpret_cast<const char*>(part.data()),
                          part.size() - stream.avail_out);
        } while (stream.avail_out == 0);
        if (progress) progress(static_cast<double>(end) / static_cast<double>(bytes.size()));
    }
    deflateEnd(&stream);
    return result;
}

}  // namespace

void PackedArrays::add(const std::string& name, const std::string& type, const void* numbers,
                       std::size_t count, std::size_t width, std::size_t stride) {
    const std::size_t offset = bytes_.size();
    directory_[name] = {{"type", type}, {"count", count}, {"stride", stride}, {"offset", offset}};
    bytes_.resize(offset + count * width);
    const auto* from = static_cast<const unsigned char*>(numbers);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t bits = difference(from, width, i, stride);
        for (std::size_t rank = 0; rank < width; ++rank)
            bytes_[offset + rank * count + i] = static_cast<unsigned char>(bits >> (8 * rank));
    }
}

std::string PackedArrays::text(nlohmann::json description,
                               const std::function<void(double)>& progress) const {
    description["arrays"] = directory_;
    // What is no UTF-8, such as a file's name, is shown with replacement characters.
    const std::string head = description.dump(-1, ' ', false,
                                              nlohmann::json::error_handler_t::replace);
    const auto size = static_cast<std::uint32_t>(head.size());
    std::vector<unsigned char> all(sizeof size + head.size());
    std::memcpy(all.data(), &size, sizeof size);
    std::memcpy(all.data() + sizeof size, head.data(), head.size());
    all.insert(all.end(), bytes_.begin(), bytes_.end());
    return base64(deflated(std::move(all), progress));
}

}  // namespace pierce::page
