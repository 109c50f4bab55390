#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

namespace pierce::scenes {

/// An array of float32 in row-major order.
struct FloatArray {
    std::vector<std::size_t> shape;
    std::vector<float> values;
};

/// Reads a NumPy .npy file of float32. Throws InputError, naming the file, if it is something else
/// or cut short.
FloatArray read_npy(const std::filesystem::path& file);

/// Throws InputError if the file cannot be written.
void write_npy(const std::filesystem::path& file, std::span<const std::size_t> shape,
               std::span<const float> values);

}  // namespace pierce::scenes
