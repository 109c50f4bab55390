#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "scenes/files/mesh_readers.hpp"
#include "scenes/files/text_scanner.hpp"

namespace pierce::scenes {
namespace {

enum class Type : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::optional<Type> type_of(std::string_view name) {
    constexpr std::array<std::array<std::string_view, 2>, 8> names = {{{"char", "int8"},
                                                                       {"uchar", "uint8"},
                                                                       {"short", "int16"},
                                                                       {"ushort", "uint16"},
                                                                       {"int", "int32"},
                                                                       {"uint", "uint32"},
                                                                       {"float", "float32"},
                                                                       {"double", "float64"}}};
    for (std::size_t k = 0; k < names.size(); ++k)
        if (name == names[k][0] || name == names[k][1]) return static_cast<Type>(k);
    return std::nullopt;
}

struct Property {
    std::string name;
    std::optional<Type> length;  ///< of a list
    Type type = Type::float32;   ///< of a number, or of those in a list
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

enum class Format : std::uint8_t { text, little_endian, big_endian };

struct Header {
    Format format = Format::text;
    std::vector<Element> elements;
};

/// The file's numbers, one after the other.
class Numbers {
public:
    Numbers(Format format, TextScanner text) : format_(format), text_(text), bytes_(text.rest()) {}

    double next(Type type) {
        if (format_ == Format::text) return next_in_text();
        switch (type) {
            case Type::int8:
                return next_bytes<std::int8_t>();
            case Type::uint8:
                return next_bytes<std::uint8_t>();
            case Type::int16:
                return next_bytes<std::int16_t>();
            case Type::uint16:
                return next_bytes<std::uint16_t>();
            case Type::int32:
                return next_bytes<std::int32_t>();
            case Type::uint32:
                return next_bytes<std::uint32_t>();
            case Type::float32:
                return static_cast<double>(next_bytes<float>());
            case Type::float64:
                return next_bytes<double>();
        }
        throw InputError("its header is damaged");
    }

    /// Throws InputError if the file goes on: its counts are wrong.
    void end() {
        if (format_ == Format::text) {
            if (!text_.next_word().empty()) text_.refuse("is more than the header promises");
        } else if (bytes_.find_first_not_of(std::string_view("\0\t\n\r ", 5)) != bytes_.npos) {
            throw InputError("it holds more than its header promises");
        }
    }

private:
    double next_in_text() {
        const std::string_view word = text_.next_word();
        if (word.empty()) throw InputError("it is cut short: its header promises more");
        const std::optional<double> number = number_of(word);
        if (!number) text_.refuse("has what is no number: " + std::string(word));
        return *number;
    }
    template <class T>
    T next_bytes() {
        if (bytes_.size() < sizeof(T))
            throw InputError("it is cut short: its header promises more");
        std::array<char, sizeof(T)> bytes{};
        std::memcpy(bytes.data(), bytes_.data(), sizeof(T));
        bytes_.remove_prefix(sizeof(T));
        static_assert(std::endian::native == std::endian::little);
        if (format_ == Format::big_endian) std::ranges::reverse(bytes);
        return std::bit_cast<T>(bytes);
    }

    Format format_;
    TextScanner text_;
    std::string_view bytes_;
};

Header read_header(TextScanner& text) {
    Header header;
    const auto refuse = [&] { text.refuse("of its header is damaged"); };
    if (!text.next_line() || text.next_word_in_line() != "ply")
        throw InputError("it does not begin with ply");
    for (;;) {
        if (!text.next_line()) throw InputError("it is cut short: it ends in its header");
        const std::string_view keyword = text.next_word_in_line();
        if (keyword == "end_header") return header;
        if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
        if (keyword == "format") {
            const std::string_view name = text.next_word_in_line();
            if (name != "ascii" && name != "binary_little_endian" && name != "binary_big_endian")
                refuse();
            header.format = name == "ascii"                  ? Format::text
                            : name == "binary_little_endian" ? Format::little_endian
                                                             : Format::big_endian;
        } else if (keyword == "element") {
            Element element{std::string(text.next_word_in_line()), 0, {}};
            const auto count = whole_number_of<std::uint64_t>(text.next_word_in_line());
            if (!count) refuse();
            element.count = *count;
            header.elements.push_back(std::move(element));
        } else if (keyword == "property") {
            if (header.elements.empty()) refuse();
            Property property;
            std::string_view type = text.next_word_in_line();
            if (type == "list") {
                property.length = type_of(text.next_word_in_line());
                if (!property.length) refuse();
                type = text.next_word_in_line();
            }
            const std::optional<Type> known = type_of(type);
            property.name = text.next_word_in_line();
            if (!known || property.name.empty()) refuse();
            property.type = *known;
            header.elements.back().properties.push_back(std::move(property));
        } else {
            refuse();
        }
    }
}

class PlyReader {
public:
    PlyReader(const Header& header, const TextScanner& text)
        : header_(header), numbers_(header.format, text) {}

    MeshData read() {
        for (const Element& element : header_.elements) {
            if (element.properties.empty()) continue;
            if (element.name == "vertex") check_vertex(element);
            for (std::uint64_t i = 0; i < element.count; ++i) {
                Vec3f position;
                for (const Property& property : element.properties)
                    if (property.length)
                        read_list(element, property);
                    else
                        set(property, static_cast<float>(numbers_.next(property.type)), position);
                if (element.name == "vertex") mesh_.positions.push_back(position);
            }
        }
        numbers_.end();
        return std::move(mesh_);
    }

private:
    static void check_vertex(const Element& element) {
        for (std::string_view name : {"x", "y", "z"})
            if (std::ranges::none_of(element.properties, [&](const Property& p) {
                    return p.name == name && !p.length;
                }))
                throw InputError("its vertices have no " + std::string(name));
    }
    static void set(const Property& property, float value, Vec3f& position) {
        if (property.name == "x") position.x = value;
        if (property.name == "y") position.y = value;
        if (property.name == "z") position.z = value;
    }

    void read_list(const Element& element, const Property& property) {
        const double length = numbers_.next(*property.length);
        if (!(length >= 0) || length != std::floor(length))
            throw InputError("a list in it has no length");
        const bool is_face = element.name == "face" &&
                             (property.name == "vertex_indices" || property.name == "vertex_index");
        corners_.clear();
        for (double k = 0; k < length; ++k) {
            const double value = numbers_.next(property.type);
            if (is_face) corners_.push_back(index(value));
        }
        add_polygon(corners_, mesh_);
    }

    static std::uint32_t index(double value) {
        if (!(value >= 0 && value <= 0xffffffff) || value != std::floor(value))
            throw InputError("a face in it names vertex " + std::to_string(value));
        return static_cast<std::uint32_t>(value);
    }

    const Header& header_;
    Numbers numbers_;
    std::vector<std::uint32_t> corners_;
    MeshData mesh_;
};

}  // namespace

MeshData read_ply(std::string_view content) {
    TextScanner text(content);
    const Header header = read_header(text);
    return PlyReader(header, text).read();
}

}  // namespace pierce::scenes
