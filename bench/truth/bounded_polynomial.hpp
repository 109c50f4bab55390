#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "truth/interval.hpp"

namespace pierce::truth {

/// A polynomial of time in a stretch of it, by its Bernstein coefficients, each known within
/// bounds: the first and the last are the values at both ends, and no value is beyond the smallest
/// and the largest.
template <std::size_t degree>
struct BoundedPolynomial {
    std::array<Interval, degree + 1> at;

    Interval first() const { return at.front(); }
    Interval last() const { return at.back(); }
    bool is_positive() const {
        for (Interval c : at)
            if (!c.is_positive()) return false;
        return true;
    }
    bool is_negative() const {
        for (Interval c : at)
            if (!c.is_negative()) return false;
        return true;
    }

    /// In the first and in the second half of its stretch (de Casteljau).
    std::pair<BoundedPolynomial, BoundedPolynomial> halves() const {
        BoundedPolynomial low, high;
        std::array<Interval, degree + 1> row = at;
        for (std::size_t k = 0; k <= degree; ++k) {
            low.at[k] = row.front();
            high.at[degree - k] = row[degree - k];
            for (std::size_t i = 0; i + k < degree; ++i) row[i] = halved(row[i] + row[i + 1]);
        }
        return {low, high};
    }

    friend BoundedPolynomial operator+(const BoundedPolynomial& a, const BoundedPolynomial& b) {
        BoundedPolynomial sum;
        for (std::size_t k = 0; k <= degree; ++k) sum.at[k] = a.at[k] + b.at[k];
        return sum;
    }
    friend BoundedPolynomial operator-(const BoundedPolynomial& a, const BoundedPolynomial& b) {
        BoundedPolynomial difference;
        for (std::size_t k = 0; k <= degree; ++k) difference.at[k] = a.at[k] - b.at[k];
        return difference;
    }
};

template <std::size_t m, std::size_t n>
BoundedPolynomial<m + n> operator*(const BoundedPolynomial<m>& a, const BoundedPolynomial<n>& b) {
    constexpr double choose[5][5] = {{1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}};
    static_assert(m + n < 5);
    BoundedPolynomial<m + n> product;
    for (std::size_t i = 0; i <= m; ++i)
        for (std::size_t j = 0; j <= n; ++j) {
            const Interval all = choose[m + n][i + j];
            const double share = choose[m][i] * choose[n][j] / all.low();
            // The share is rounded; thirds and sixths lie between its neighbours.
            const Interval bounds(std::nextafter(share, 0.0), std::nextafter(share, 2.0));
            product.at[i + j] = product.at[i + j] + bounds * (a.at[i] * b.at[j]);
        }
    return product;
}

}  // namespace pierce::truth
