#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace pierce::truth {

/// All numbers from one to another: what a number computed in doubles may truly be. Every operation
/// widens its bounds outward by a step of the doubles, which is more than it rounds by.
class Interval {
public:
    constexpr Interval() = default;
    constexpr Interval(double value)
        : low_(value), high_(value) {}  // NOLINT(google-explicit-constructor): exact
    constexpr Interval(double low, double high) : low_(low), high_(high) {}

    constexpr double low() const { return low_; }
    constexpr double high() const { return high_; }
    bool is_positive() const { return low_ > 0; }
    bool is_negative() const { return high_ < 0; }

    friend Interval operator-(Interval a) { return {-a.high_, -a.low_}; }
    friend Interval operator+(Interval a, Interval b) {
        return outward(a.low_ + b.low_, a.high_ + b.high_);
    }
    friend Interval operator-(Interval a, Interval b) {
        return outward(a.low_ - b.high_, a.high_ - b.low_);
    }
    friend Interval operator*(Interval a, Interval b) {
        const double p = a.low_ * b.low_, q = a.low_ * b.high_, r = a.high_ * b.low_,
                     s = a.high_ * b.high_;
        return outward(std::min(std::min(p, q), std::min(r, s)),
                       std::max(std::max(p, q), std::max(r, s)));
    }
    /// Half of it.
    friend Interval halved(Interval a) { return outward(0.5 * a.low_, 0.5 * a.high_); }

private:
    static double below(double x) {
        return std::nextafter(x, -std::numeric_limits<double>::infinity());
    }
    static double above(double x) {
        return std::nextafter(x, std::numeric_limits<double>::infinity());
    }
    static Interval outward(double low, double high) { return {below(low), above(high)}; }

    double low_ = 0, high_ = 0;
};

}  // namespace pierce::truth
