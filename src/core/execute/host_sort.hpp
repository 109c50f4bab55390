#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/device/view.hpp"

namespace pierce {

/// The stable sort of every host executor. Nearly sorted keys, such as those of contacts, are
/// sorted by insertion. Of others, the leading bits are often in order, as lists are made pair by
/// pair: each run of keys that agree in these bits is sorted for itself, in the cache, by bytes,
/// least significant first, without the bytes in which all its keys agree. The object keeps its
/// memory from call to call.
class HostSort {
public:
    void operator()(View<std::uint64_t> keys, View<std::uint32_t> values) {
        if (insert(keys, values)) return;
        const int bits = bits_out_of_order(keys);
        const auto leading = [&](std::uint32_t i) { return bits < 64 ? keys[i] >> bits : 0; };
        for (std::uint32_t begin = 0, end = 1; begin < keys.size; begin = end++) {
            while (end < keys.size && leading(end) == leading(begin)) ++end;
            const View<std::uint64_t> run{keys.data + begin, end - begin};
            const View<std::uint32_t> its_values{values.data + begin, end - begin};
            if (!insert(run, its_values)) sort_bytes(run, its_values, (bits + 7) / 8);
        }
    }

private:
    /// How many of the lowest bits have to be sorted: without them, the keys are in order.
    static int bits_out_of_order(View<std::uint64_t> keys) {
        std::uint64_t differing = 0;
        for (std::uint32_t i = 1; i < keys.size; ++i)
            if (keys[i - 1] > keys[i]) differing |= keys[i - 1] ^ keys[i];
        return static_cast<int>(std::bit_width(differing));
    }

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

    /// Sorts by the lowest `bytes` bytes.
    void sort_bytes(View<std::uint64_t> keys, View<std::uint32_t> values, int bytes) {
        std::uint32_t counts[most_bytes][digits];
        for (int b = 0; b < bytes; ++b) std::fill_n(counts[b], digits, 0u);
        if (items_.size() < keys.size) {
            items_.resize(keys.size);
            sorted_.resize(keys.size);
        }
        for (std::uint32_t i = 0; i < keys.size; ++i) {
            items_[i] = {keys[i], values[i]};
            for (int b = 0; b < bytes; ++b) ++counts[b][digit(keys[i], b)];
        }
        for (int b = 0; b < bytes; ++b) {
            if (counts[b][digit(keys[0], b)] == keys.size) continue;
            std::uint32_t place = 0;
            for (std::uint32_t& count : counts[b]) place += std::exchange(count, place);
            for (std::uint32_t i = 0; i < keys.size; ++i)
                sorted_[counts[b][digit(items_[i].key, b)]++] = items_[i];
            items_.swap(sorted_);
        }
        for (std::uint32_t i = 0; i < keys.size; ++i) {
            keys[i] = items_[i].key;
            values[i] = items_[i].value;
        }
    }

    static constexpr std::uint32_t moves_per_key = 4;
    static constexpr int most_bytes = 8;
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
