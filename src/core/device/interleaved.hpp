#pragma once

#include "core/device/view.hpp"
#include "core/device/whole.hpp"
#include "pierce/constants.hpp"

namespace pierce {

/// Items in groups of constants::group_size. On a GPU the words of a group's items lie side by
/// side, so that threads that read items of one group share memory accesses; on the host items lie
/// one after the other. The buffer is the same for both.
template <class T>
struct Interleaved {
    View<T> items;  ///< a whole number of groups

    template <class Const>
    requires std::is_same_v<Const, const T> PIERCE_HD operator Interleaved<Const>() const {
        return {items};
    }

    PIERCE_HD std::remove_const_t<T> read(std::uint32_t i) const {
#if defined(__CUDA_ARCH__)
        Words words;
        const uint4* const from = reinterpret_cast<const uint4*>(items.data) + first_word(i);
        for (std::uint32_t w = 0; w < count; ++w)
            *reinterpret_cast<uint4*>(&words.word[w]) = from[w * constants::group_size];
        std::remove_const_t<T> value;
        memcpy(&value, &words, sizeof(T));
        return value;
#else
        return items[i];
#endif
    }

    PIERCE_HD void write(std::uint32_t i, const T& value) const {
#if defined(__CUDA_ARCH__)
        Words words;
        memcpy(&words, &value, sizeof(T));
        uint4* const to = reinterpret_cast<uint4*>(items.data) + first_word(i);
        for (std::uint32_t w = 0; w < count; ++w)
            to[w * constants::group_size] = *reinterpret_cast<const uint4*>(&words.word[w]);
#else
        items[i] = value;
#endif
    }

private:
    using Words = detail::Words<std::remove_const_t<T>>;
    static constexpr std::uint32_t count = sizeof(T) / 16;

    PIERCE_HD static std::uint32_t first_word(std::uint32_t i) {
        return i / constants::group_size * (count * constants::group_size) +
               i % constants::group_size;
    }
};

template <class T>
Interleaved<T> interleaved(View<T> items) {
    return {items};
}

}  // namespace pierce
