#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>

#include "pierce/error.hpp"

/// Structs that know their size, so that a program and a library of different versions understand
/// each other: fields are only ever added, at the end.
namespace pierce::c {

/// The size of a struct's first version; no caller has less. A struct that grows gets a
/// specialization with the size that it had at first.
template <class T>
inline constexpr std::size_t first_size = sizeof(T);

/// No struct will ever be larger; a size beyond is memory that nobody has written.
inline constexpr std::size_t most_bytes = 4096;

/// Throws InputError unless the size of a caller's struct can be true.
template <class T>
void check_size(std::size_t size, const char* name) {
    if (size < first_size<T> || size > most_bytes)
        throw InputError(std::string(name) + ": its struct_size is " + std::to_string(size) +
                         ", not the size of the struct");
}

template <class T>
void check_struct(const T* given, const char* name) {
    static_assert(std::is_trivially_copyable_v<T> && offsetof(T, struct_size) == 0);
    if (given == nullptr) throw InputError(std::string(name) + " is null");
    check_size<T>(given->struct_size, name);
}

/// A caller's struct. What an earlier version does not have is as in `defaults`; what a later one
/// has besides must be zero.
template <class T>
T read_struct(const T* given, const T& defaults, const char* name) {
    check_struct(given, name);
    const auto* bytes = reinterpret_cast<const unsigned char*>(given);
    const std::size_t size = given->struct_size;
    for (std::size_t at = sizeof(T); at < size; ++at)
        if (bytes[at] != 0)
            throw InputError(std::string(name) +
                             ": it has a field that this version of the library does not know");
    T read = defaults;
    std::memcpy(static_cast<void*>(&read), bytes, std::min(size, sizeof(T)));
    read.struct_size = sizeof(T);
    return read;
}

/// Fills a caller's struct of `size` bytes. An earlier version gets what it has room for; what a
/// later one has besides becomes zero.
template <class T>
void write_struct(const T& value, T* out, std::size_t size) {
    auto* bytes = reinterpret_cast<unsigned char*>(out);
    std::memcpy(bytes, &value, std::min(size, sizeof(T)));
    if (size > sizeof(T)) std::memset(bytes + sizeof(T), 0, size - sizeof(T));
    std::memcpy(bytes, &size, sizeof size);
}

/// The same for a struct whose size the caller has set, and check_struct() has checked.
template <class T>
void write_struct(const T& value, T* out) {
    write_struct(value, out, out->struct_size);
}

/// Fills a caller's struct with defaults. Throws InputError for null and for an impossible size.
template <class T>
void write_defaults(const T& defaults, T* out, std::size_t size, const char* name) {
    if (out == nullptr) throw InputError(std::string(name) + " is null");
    check_size<T>(size, name);
    write_struct(defaults, out, size);
}

}  // namespace pierce::c
