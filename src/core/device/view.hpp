#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "core/device/check_place.hpp"
#include "pierce/host_device.hpp"

namespace pierce {

/// A pointer and a count: the form in which stages see arrays, on host and device alike. A view
/// owns nothing.
template <class T>
struct View {
    T* data = nullptr;
    std::uint32_t size = 0;

    PIERCE_HD T& operator[](std::size_t i) const {
        PIERCE_CHECK_PLACE(i, size);
        return data[i];
    }
    PIERCE_HD T* begin() const { return data; }
    PIERCE_HD T* end() const { return data + size; }
    template <class Const>
    requires std::is_same_v<Const, const T> PIERCE_HD operator View<Const>() const {
        return {data, size};
    }
};

/// The view of a contiguous container.
template <class Container>
auto view_of(Container& c) {
    return View<std::remove_pointer_t<decltype(c.data())>>{c.data(),
                                                           static_cast<std::uint32_t>(c.size())};
}

}  // namespace pierce
