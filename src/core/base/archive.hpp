#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pierce/error.hpp"
#include "pierce/vec3.hpp"

/// The bytes of a saved world: numbers as they are in memory, least significant byte first, and
/// lists after their length. For every type one function, `transfer(archive, thing)`, lists the
/// type's parts. It writes with an ArchiveWriter and reads with an ArchiveReader.
namespace pierce {

static_assert(std::endian::native == std::endian::little,
              "archives are written as numbers are in memory");

/// Appends what it is given to an archive.
class ArchiveWriter {
public:
    static constexpr bool reads = false;

    void number(const void* value, std::size_t size) {
        bytes_.append(static_cast<const char*>(value), size);
    }
    const std::string& bytes() const { return bytes_; }
    std::string take() && { return std::move(bytes_); }

private:
    std::string bytes_;
};

/// Fills what it is given from an archive that is not trusted. Throws InputError where the archive
/// ends too soon or holds an impossible value. Makes nothing larger than the archive.
class ArchiveReader {
public:
    static constexpr bool reads = true;

    explicit ArchiveReader(std::string bytes) : bytes_(std::move(bytes)) {}

    void number(void* value, std::size_t size) {
        if (size > left()) throw InputError("a saved world ends too soon");
        std::memcpy(value, bytes_.data() + at_, size);
        at_ += size;
    }
    std::size_t left() const { return bytes_.size() - at_; }

private:
    std::string bytes_;
    std::size_t at_ = 0;
};

template <class Archive, class T>
requires(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) void transfer(Archive& archive,
                                                                            T& value) {
    archive.number(&value, sizeof value);
}

template <class Archive>
void transfer(Archive& archive, bool& value) {
    std::uint8_t byte = value;
    archive.number(&byte, 1);
    if (byte > 1)
        throw InputError("a saved world holds neither yes nor no where there must be one");
    if constexpr (Archive::reads) value = byte != 0;
}

/// Transfers a value of an enumeration whose last value is `last`.
template <class Archive, class Enum>
requires std::is_enum_v<Enum>
void transfer(Archive& archive, Enum& value, Enum last) {
    auto number = static_cast<std::underlying_type_t<Enum>>(value);
    transfer(archive, number);
    if (number > static_cast<std::underlying_type_t<Enum>>(last))
        throw InputError("a saved world holds an unknown choice");
    if constexpr (Archive::reads) value = static_cast<Enum>(number);
}

template <class Archive, class T>
void transfer(Archive& archive, Vec3<T>& v) {
    transfer(archive, v.x);
    transfer(archive, v.y);
    transfer(archive, v.z);
}

template <class Archive, class T, std::size_t size>
void transfer(Archive& archive, T (&values)[size]) {
    for (T& value : values) transfer(archive, value);
}

/// Transfers a list's length. A reader refuses a length above the bytes that are left, as every
/// element takes at least one byte.
template <class Archive>
std::uint64_t transfer_length(Archive& archive, std::uint64_t length) {
    transfer(archive, length);
    if constexpr (Archive::reads) {
        if (length > archive.left()) throw InputError("a saved world promises more than it holds");
    }
    return length;
}

template <class Archive>
void transfer(Archive& archive, std::string& text) {
    text.resize(transfer_length(archive, text.size()));
    archive.number(text.data(), text.size());
}

/// True if a list of these is written as it is in memory.
template <class T>
constexpr bool is_bytes = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;
template <class T>
constexpr bool is_bytes<Vec3<T>> = is_bytes<T> && sizeof(Vec3<T>) == 3 * sizeof(T);

template <class Archive, class T>
void transfer(Archive& archive, std::vector<T>& list) {
    const std::uint64_t length = transfer_length(archive, list.size());
    if constexpr (is_bytes<T>) {
        // As one by one, but at once.
        if constexpr (Archive::reads) {
            if (length > archive.left() / sizeof(T))
                throw InputError("a saved world promises more than it holds");
            list.resize(length);
        }
        if (length > 0) archive.number(list.data(), length * sizeof(T));
    } else if constexpr (Archive::reads) {
        list.clear();
        for (std::uint64_t i = 0; i < length; ++i) transfer(archive, list.emplace_back());
    } else {
        for (T& element : list) transfer(archive, element);
    }
}

/// Transfers several things, one after the other.
template <class Archive, class... T>
void transfer_all(Archive& archive, T&... things) {
    (transfer(archive, things), ...);
}

/// 64-bit FNV-1a.
inline std::uint64_t checksum(const std::string& bytes) {
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (const char byte : bytes)
        hash = (hash ^ static_cast<std::uint8_t>(byte)) * 0x100000001b3ull;
    return hash;
}

}  // namespace pierce
