#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "pierce/core/view.hpp"

namespace pierce {

/// The stable sort of every host executor: by bytes, least significant first, leaving out bytes in which all keys agree.
/// Keeps its memory.
class HostSort {
public:
    void operator()(View<std::uint64_t> keys, View<std::uint32_t> values) {
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

private:
    static constexpr int bytes = 8;
    static constexpr int digits = 256;
    static std::uint32_t digit(std::uint64_t key, int byte) { return static_cast<std::uint32_t>(key >> (8 * byte) & 0xff); }

    struct Item {
        std::uint64_t key;
        std::uint32_t value;
    };
    std::vector<Item> items_, sorted_;
};

}  // namespace pierce
