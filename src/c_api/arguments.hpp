#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pierce/c/base.h"
#include "pierce/error.hpp"
#include "pierce/ids.hpp"
#include "pierce/pose.hpp"
#include "pierce/vec3.hpp"

/// What comes in over the border, checked; every InputError names the argument.
namespace pierce::c {

/// Throws InputError if an argument is null. It need not be aligned.
inline void require(const void* argument, const char* name) {
    if (argument == nullptr) throw InputError(std::string(name) + " is null");
}

/// What an argument points to. Throws InputError if it is null.
template <class T>
T& required(T* argument, const char* name) {
    require(argument, name);
    return *argument;
}

/// `count` values. Throws InputError for null, unless there are none, and for more than numbers of
/// 32 bits can count.
template <class T>
std::span<const T> list(const T* values, std::size_t count, const char* name) {
    if (count > 0xffffffffu) throw InputError(std::string(name) + " has too many elements");
    if (count > 0) require(values, name);
    return {values, count};
}

/// `count` vectors of three numbers each.
template <class T>
std::span<const Vec3<T>> vectors(const T* numbers, std::size_t count, const char* name) {
    static_assert(sizeof(Vec3<T>) == 3 * sizeof(T));
    return list(reinterpret_cast<const Vec3<T>*>(numbers), count, name);
}

/// A value of an enumeration, whose values go from 0 to `last`.
template <class Enum>
Enum enumerated(std::uint32_t value, Enum last, const char* name) {
    if (value > static_cast<std::uint32_t>(last))
        throw InputError(std::string(name) + " is " + std::to_string(value) +
                         ", which has no meaning");
    return static_cast<Enum>(value);
}

/// A number of the C API as a handle; every number is one, and the World refuses wrong ones.
template <class Handle>
Handle handle(std::uint64_t number) {
    return {static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(number >> 32)};
}

inline MeshId mesh_handle(pierce_mesh_id number) { return handle<MeshId>(number); }
inline BodyId body_handle(pierce_body_id number) { return handle<BodyId>(number); }

template <class Tag>
std::uint64_t number(Id<Tag> id) {
    return std::uint64_t{id.generation} << 32 | id.index;
}

inline std::vector<BodyId> body_handles(const pierce_body_id* bodies, std::size_t count,
                                        const char* name) {
    const auto given = list(bodies, count, name);
    std::vector<BodyId> handles;
    handles.reserve(given.size());
    for (const pierce_body_id body : given) handles.push_back(body_handle(body));
    return handles;
}

/// A pose of seven numbers: the position x, y, z and the quaternion x, y, z, w.
inline Pose pose_of(const double* numbers, const char* name) {
    required(numbers, name);
    return {{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5], numbers[6]}};
}

inline void copy_to(double (&out)[3], Vec3d v) {
    for (int k = 0; k < 3; ++k) out[k] = v[k];
}

}  // namespace pierce::c
