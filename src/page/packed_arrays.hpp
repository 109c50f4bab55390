#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace pierce::page {

/// Arrays of numbers under names, made small for a web page. Numbers that change little from one to
/// the next of the same `stride` are kept as differences of their bits, and the bytes of equal rank
/// lie together, so that deflate finds what repeats. Nothing is lost.
class PackedArrays {
public:
    /// Adds an array of numbers of 1, 2, 4 or 8 bytes. `stride`: how many numbers back the one is
    /// that a number is like; 0: none.
    template <class Number>
    void add(const std::string& name, std::span<const Number> numbers, std::size_t stride = 0) {
        static_assert(std::is_arithmetic_v<Number>);
        constexpr const char* kind = std::is_floating_point_v<Number> ? "f" : "u";
        add(name, kind + std::to_string(8 * sizeof(Number)), numbers.data(), numbers.size(),
            sizeof(Number), stride);
    }

    /// `description`, the directory of the arrays as its member `arrays`, and the arrays: deflated
    /// and in base64. `progress` is told the share that is done.
    std::string text(nlohmann::json description,
                     const std::function<void(double share)>& progress = {}) const;

private:
    void add(const std::string& name, const std::string& type, const void* numbers,
             std::size_t count, std::size_t width, std::size_t stride);

    std::vector<unsigned char> bytes_;
    nlohmann::json directory_ = nlohmann::json::object();
};

}  // namespace pierce::page
