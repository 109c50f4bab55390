#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/device/view.hpp"

namespace pierce {

/// The stable sort of every host executor. Nearly sorted keys, such as those of contacts, are
/// sorted by insertion. Others are sorted by bytes, least significant first, without the bytes in
/// which all keys agree. The object keeps its memory from call to call.
class HostSort {
public:
    void operator()(View<std::uint64_t> keys, View<std::uint32_t> values) {
        if (!insert(keys, values)) sort_bytes(keys, values);
    }

private:
    /// Sorts by insertion. Gives up when that takes more than a few moves per key; the order is
    /// still stable then.
    static bool insert(View<std::uint64_t> keys, View<std::uint32_t> values) {
        std::uint64_t moves_left = std::uint64_t{moves_per_key} * keys.size;
        for (std::uint32_t i = 1; i < keys.size; ++i) {
            const std::uint64_t key = keys[i];
            const std::uint32_t value = values[i];
            std::uint32_t place = i;
            for (; place > 0 && keys[place - 1] > key; --place) {
                keys[place] = keys[place - 1];
                values[place] = values[place - 1];
            }
            keys[place] = key;
            values[place] = value;
            if (i - place > moves_left) return false;
            moves_left -= i - place;
        }
        return true;
    }

    void sort_bytes(View<std::uint64_t> keys, View<std::uint32_t> values) {
        std::uint32_t counts[bytes][digits] = {};
        items_.resize(keys.size);
        sorted_.resize(keys.size);
        for (std::uint32_t i = 0; i < keys.size; ++i) {
            items_[i] = {keys[i], values[i]};
            for (int b = 0; b < bytes; ++b) ++counts[b][digit(keys[i], b)];
        }
        for (int b = 0; b < bytes; ++b) {
            if (keys.size == 0 || counts[b][digit(keys[0], b)] == keys.size) continue;
            std::uint32_t place = 0;
            for (std::uint32_t& count : counts[b]) place += std::exchange(count, place);
            for (const Item& item : items_) sorted_[counts[b][digit(item.key, b)]++] = item;
            items_.swap(sorted_);
        }
        for (std::uint32_t i = 0; i < keys.size; ++i) {
            keys[i] = items_[i].key;
            values[i] = items_[i].value;
        }
    }

    static constexpr std::uint32_t moves_per_key = 4;
    static constexpr int bytes = 8;
    static constexpr int digits = 256;
    static std::uint32_t digit(std::uint64_t key, int byte) {
        return static_cast<std::uint32_t>(key >> (8 * byte) & 0xff);
    }

    struct Item {
        std::uint64_t key;
        std::uint32_t value;
    };
    std::vector<Item> items_, sorted_;
};

}  // namespace pierce
