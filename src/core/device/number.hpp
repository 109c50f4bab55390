#pragma once

#include <cstdint>

#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// A number that a stage reads when it runs, such as where a list goes on: one that the host knows,
/// or a sum of totals that earlier stages write.
class Number {
public:
    static constexpr std::uint32_t most_terms = 6;

    Number() = default;
    PIERCE_HD Number(std::uint32_t n) : bound_(n), known_(n) {}

    PIERCE_HD operator std::uint32_t() const {
        std::uint32_t sum = known_;
        for (const Term& term : terms_)
            if (term.total != nullptr) sum += term.times * *term.total;
        return min_of(sum, bound_);
    }

protected:
    struct Term {
        const std::uint32_t* total = nullptr;
        std::uint32_t times = 0;
    };

    std::uint32_t bound_ = 0;  ///< the largest value that it can have
    std::uint32_t known_ = 0;  ///< what the host knows of the sum
    Term terms_[most_terms];   ///< those without a total are last
};

}  // namespace pierce
