#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

/// Lists on their way to another process of the same program, as they are in memory. Both sides are
/// trusted; archives (core/base/archive.hpp) are for what is not.
namespace pierce::mpi {

/// Appends how many items there are, and the items.
template <class Item>
void append_items(std::string& bytes, std::span<const Item> items) {
    static_assert(std::is_trivially_copyable_v<Item>);
    const std::uint64_t count = items.size();
    bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
    if (count > 0) bytes.append(reinterpret_cast<const char*>(items.data()), items.size_bytes());
}

/// Adds what append_items() has appended from a place on to a list, and moves the place behind it.
template <class Item>
void take_items(const std::string& bytes, std::size_t& at, std::vector<Item>& items) {
    static_assert(std::is_trivially_copyable_v<Item>);
    std::uint64_t count = 0;
    std::memcpy(&count, bytes.data() + at, sizeof count);
    at += sizeof count;
    const std::size_t before = items.size();
    items.resize(before + count);
    if (count > 0)
        std::memcpy(static_cast<void*>(items.data() + before), bytes.data() + at,
                    count * sizeof(Item));
    at += count * sizeof(Item);
}

}  // namespace pierce::mpi
