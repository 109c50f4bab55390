#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/device/view.hpp"

namespace pierce {

/// The stable sort of every host executor. Lists of contacts are a few lists one after the other,
/// each nearly in order: they are sorted by insertion and merged. Of other keys, the leading bits
/// are often in order, as lists are made pair by pair: each run of keys that agree in these bits is
/// sorted for itself, in the cache, by bytes, least significant first, without the bytes in which
/// all its keys agree. The object keeps its memory from call to call.
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

    /// Sorts by insertion. A key that belongs far in front begins a new part; at the end the parts
    /// are merged. Gives up when that takes more than a few moves per key, or makes too many parts;
    /// equal keys are still in their order then.
    bool insert(View<std::uint64_t> keys, View<std::uint32_t> values) {
        std::uint64_t moves_left = std::uint64_t{moves_per_key} * keys.size;
        std::uint32_t begins[most_parts], parts = 1, first = 0;
        begins[0] = 0;
        for (std::uint32_t i = 1; i < keys.size; ++i) {
            const std::uint64_t key = keys[i];
            if (!(key < keys[i - 1])) continue;
            if (i - first > most_moves && key < keys[i - most_moves]) {
                if (parts == most_parts) return false;
                begins[parts++] = first = i;
                continue;
            }
            const std::uint32_t value = values[i];
            std::uint32_t place = i;
            for (; place > first && keys[place - 1] > key; --place) {
                keys[place] = keys[place - 1];
                values[place] = values[place - 1];
            }
            keys[place] = key;
            values[place] = value;
            if (i - place > moves_left) return false;
            moves_left -= i - place;
        }
        for (; parts > 1; --parts) {
            const std::uint32_t begin = begins[parts - 2], size = keys.size - begin;
            merge({keys.data + begin, size}, {values.data + begin, size},
                  begins[parts - 1] - begin);
        }
        return true;
    }

    /// Merges the keys from `second` on into those before, from the back.
    void merge(View<std::uint64_t> keys, View<std::uint32_t> values, std::uint32_t second) {
        std::uint32_t left = keys.size - second, place = keys.size, before = second;
        if (items_.size() < left) items_.resize(left);
        for (std::uint32_t k = 0; k < left; ++k) items_[k] = {keys[second + k], values[second + k]};
        while (left > 0) {
            --place;
            if (before > 0 && keys[before - 1] > items_[left - 1].key) {
                --before;
                keys[place] = keys[before];
                values[place] = values[before];
            } else {
                --left;
                keys[place] = items_[left].key;
                values[place] = items_[left].value;
            }
        }
    }

    /// Sorts by the lowest `bytes` bytes.
    void sort_bytes(View<std::uint64_t> keys, View<std::uint32_t> values, int bytes) {
        std::uint32_t counts[most_bytes][digits];
        for (int b = 0; b < bytes; ++b) std::fill_n(counts[b], digits, 0u);
        if (items_.size() < keys.size) items_.resize(keys.size);
        if (sorted_.size() < items_.size()) sorted_.resize(items_.size());
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

    static constexpr std::uint32_t moves_per_key = 16;
    static constexpr std::uint32_t most_moves = 64;  ///< of a key within its part
    static constexpr std::uint32_t most_parts = 6;
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
