#pragma once

#include <concepts>
#include <cstdint>
#include <stdexcept>

#include "core/device/number.hpp"
#include "core/execute/list_length.hpp"

namespace pierce::cuda {

/// How many items there are: a number that the host knows, or one that only the device knows, with
/// a bound.
class DeviceCount : public Number {
public:
    DeviceCount() = default;
    DeviceCount(std::uint32_t n) : Number(n) {}
    /// `times` the total in device memory, but no more than `most`.
    DeviceCount(std::uint32_t most, const std::uint32_t* total, std::uint32_t times) {
        bound_ = most;
        terms_[0] = {total, times};
    }

    /// Bounded steps know no numbers on the host: CudaExecutor::number() is for code that may wait.
    operator std::uint32_t() const = delete;

    std::uint32_t bound() const { return bound_; }
    /// True if the host knows the number, which is the bound.
    bool is_known() const { return terms_[0].total == nullptr; }

    /// The number, by the host's copy of the totals: `at(total)` is the value of a total.
    template <class At>
    std::uint32_t number(const At& at) const {
        std::uint32_t sum = known_;
        for (const Term& term : terms_)
            if (term.total != nullptr) sum += term.times * at(term.total);
        return min_of(sum, bound_);
    }

    /// The same sum of other totals: `other(total)` is where the one that stands for a total is.
    template <class Other>
    DeviceCount with(const Other& other) const {
        DeviceCount count = *this;
        for (Term& term : count.terms_)
            if (term.total != nullptr) term.total = other(term.total);
        return count;
    }

    /// Throws std::length_error for 2^32 things or more.
    template <std::integral N>
    friend DeviceCount operator*(N times, DeviceCount c) {
        const auto by = static_cast<std::uint32_t>(times);
        c.bound_ = list_length(std::uint64_t{by} * c.bound_);
        c.known_ *= by;
        for (Term& term : c.terms_) term.times *= by;
        return c;
    }
    /// Throws std::length_error for 2^32 things or more, std::logic_error if the sum has more terms
    /// than there is room for.
    friend DeviceCount operator+(DeviceCount a, const DeviceCount& b) {
        a.bound_ = list_length(std::uint64_t{a.bound_} + b.bound_);
        a.known_ += b.known_;
        std::uint32_t end = 0;
        while (end < most_terms && a.terms_[end].total != nullptr) ++end;
        for (const Term& term : b.terms_) {
            if (term.total == nullptr) break;
            if (end == most_terms) throw std::logic_error("a count of too many totals");
            a.terms_[end++] = term;
        }
        return a;
    }
};

}  // namespace pierce::cuda
