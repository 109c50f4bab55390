#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pierce/ids.hpp"
#include "pierce/pose.hpp"
#include "pierce/vec3.hpp"

namespace pierce::python {

namespace nb = nanobind;

/// An array as a caller gives it: of any type and shape, on any device.
using Array = nb::ndarray<nb::ro>;

/// From anything with DLPack, the buffer protocol or __cuda_array_interface__. Throws a TypeError
/// that names `what`.
Array array_of(nb::handle given, const char* what);

/// Rows of numbers as steps read them.
struct Rows {
    const void* data = nullptr;
    std::size_t count = 0;
    bool on_device = false;
    bool doubles = false;  ///< float64; else float32

    std::span<const Vec3f> vectors() const { return {static_cast<const Vec3f*>(data), count}; }
    template <class T>
    std::span<const T> numbers(std::size_t columns) const {
        return {static_cast<const T*>(data), count * columns};
    }
};

/// The rows of an array of shape (n, columns) in C order. Throws a TypeError for another type of
/// number, and a ValueError for another shape, order or device; both say what was given and how to
/// make what is needed.
Rows rows_of(const Array& array, std::size_t columns, const char* what, bool allows_doubles);

/// Handles from one handle, a sequence of them, or an array of uint64, which is the fastest.
std::vector<BodyId> bodies_of(nb::handle given);

/// An array of shape (n, columns) in NumPy that owns its numbers.
template <class Number, class Item>
nb::object owned_rows(std::vector<Item> items) {
    constexpr std::size_t columns = sizeof(Item) / sizeof(Number);
    auto* kept = new std::vector<Item>(std::move(items));
    const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<decltype(kept)>(p); });
    const std::size_t shape[2] = {kept->size(), columns};
    return nb::cast(nb::ndarray<nb::numpy, Number>(
        kept->empty() ? nullptr : reinterpret_cast<Number*>(kept->data()), 2, shape, owner));
}

/// A pose from a Pose, seven numbers (position, quaternion x y z w), or a 4 x 4 matrix.
Pose pose_of(nb::handle given);

/// Copies numbers of any type into a list of rows. Throws as rows_of() does for shapes.
std::vector<Vec3f> positions_of(nb::handle given, const char* what);

}  // namespace pierce::python
