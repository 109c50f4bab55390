#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "scenes/files/mesh_readers.hpp"
#include "scenes/files/text_scanner.hpp"

namespace pierce::scenes {
namespace {

constexpr std::size_t binary_header = 80, binary_begin = binary_header + sizeof(std::uint32_t);
constexpr std::size_t binary_triangle = 50;  // bytes: a normal, three corners, two of attributes

/// Makes one vertex of all corners at the same position.
class Welder {
public:
    std::uint32_t vertex_at(Vec3f p) {
        const Key key{bits(p.x), bits(p.y), bits(p.z)};
        const auto [known, is_new] = vertices_.try_emplace(
            key, static_cast<std::uint32_t>(mesh_.positions.size()));
        if (is_new) mesh_.positions.push_back(p);
        return known->second;
    }
    void add(std::span<const std::uint32_t> corners) {
        for (std::size_t k = 2; k < corners.size(); ++k)
            if (corners[0] != corners[k - 1] && corners[0] != corners[k] &&
                corners[k - 1] != corners[k])
                mesh_.triangles.push_back({{corners[0], corners[k - 1], corners[k]}});
    }
    MeshData take() { return std::move(mesh_); }

private:
    using Key = std::array<std::uint32_t, 3>;
    struct Hash {
        std::size_t operator()(const Key& key) const {
            std::uint64_t hash = 0;
            for (std::uint32_t k : key) hash = (hash ^ k) * 0x9e3779b97f4a7c15u;
            return hash ^ hash >> 32;
        }
    };
    static std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x + 0.f); }

    std::unordered_map<Key, std::uint32_t, Hash> vertices_;
    MeshData mesh_;
};

std::uint32_t count_of(std::string_view content) {
    std::uint32_t count = 0;
    for (std::size_t k = 0; k < sizeof count; ++k)
        count |= std::uint32_t{static_cast<std::uint8_t>(content[binary_header + k])} << (8 * k);
    return count;
}

/// The names of keywords are in any case.
bool is(std::string_view word, std::string_view keyword) {
    return std::ranges::equal(word, keyword, {}, [](unsigned char c) { return std::tolower(c); });
}

/// A text begins with "solid"; the header of a binary file may, too.
bool is_text(std::string_view content) {
    TextScanner text(content);
    if (!is(text.next_word(), "solid")) return false;
    if (content.size() < binary_begin) return true;
    if (content.size() == binary_begin + std::uint64_t{count_of(content)} * binary_triangle)
        return false;
    constexpr std::size_t enough = 1024;  // bytes, for a name and the first facet
    const std::string_view start = content.substr(0, enough);
    return start.find('\0') == std::string_view::npos;
}

MeshData read_binary(std::string_view content) {
    if (content.size() < binary_begin) throw InputError("it is cut short: it ends in its header");
    const std::uint64_t count = count_of(content);
    const std::size_t held = (content.size() - binary_begin) / binary_triangle;
    if (held != count)
        throw InputError(std::string(held < count ? "it is cut short: " : "") +
                         "its header promises " + std::to_string(count) + " triangles, it holds " +
                         std::to_string(held));
    Welder welder;
    for (std::uint64_t t = 0; t < count; ++t) {
        const char* at = content.data() + binary_begin + t * binary_triangle + 3 * sizeof(float);
        std::array<std::uint32_t, 3> corners{};
        for (std::uint32_t& corner : corners) {
            float x[3];
            static_assert(std::endian::native == std::endian::little);
            std::memcpy(x, at, sizeof x);
            at += sizeof x;
            corner = welder.vertex_at({x[0], x[1], x[2]});
        }
        welder.add(corners);
    }
    return welder.take();
}

/// The name of a solid may be anything, and the first facet may follow in the same line.
void skip_name(TextScanner& text) {
    for (;;) {
        const std::string_view line = text.line(), word = text.next_word_in_line();
        if (word.empty()) return;
        const bool ends = is(word, "endsolid");
        if (!ends && !(is(word, "facet") && is(text.next_word_in_line(), "normal") &&
                       number_of(text.next_word_in_line())))
            continue;
        return text.set_line(line);
    }
}

MeshData read_text(std::string_view content) {
    Welder welder;
    TextScanner text(content);
    std::vector<std::uint32_t> corners;
    bool in_solid = false, in_loop = false;
    for (std::string_view word = text.next_word(); !word.empty(); word = text.next_word()) {
        if (is(word, "solid")) {
            in_solid = true;
            skip_name(text);
        } else if (is(word, "endsolid")) {
            in_solid = false;
            text.skip_line();  // its name
        } else if (is(word, "loop")) {
            in_loop = true;
            corners.clear();
        } else if (is(word, "endloop")) {
            in_loop = false;
            welder.add(corners);
        } else if (is(word, "vertex")) {
            float at[3];
            for (float& x : at) {
                const std::optional<double> number = number_of(text.next_word());
                if (!number) text.refuse("is no vertex");
                x = static_cast<float>(*number);
            }
            if (!in_loop) text.refuse("has a vertex outside of a loop");
            corners.push_back(welder.vertex_at({at[0], at[1], at[2]}));
        }
    }
    if (in_solid) throw InputError("it is cut short: it ends before its endsolid");
    return welder.take();
}

}  // namespace

MeshData read_stl(std::string_view content) {
    return is_text(content) ? read_text(content) : read_binary(content);
}

}  // namespace pierce::scenes
