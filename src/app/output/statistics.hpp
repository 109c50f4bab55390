#pragma once

#include <span>

namespace pierce::app {

/// Zero of an empty list.
double mean(std::span<const double> values);

/// How far values are from their mean, root mean square.
double deviation(std::span<const double> values);

/// The values from three quarters of the way on.
inline std::span<const double> last_quarter(std::span<const double> values) {
    return values.subspan(values.size() - values.size() / 4);
}

/// The line of least squares through points, and how much of the variation of y it explains.
struct LinearFit {
    double slope = 0, offset = 0;
    double r2 = 0;  ///< [1] one if all points lie on the line
};

/// Of as many x as y; without a slope if x does not vary.
LinearFit linear_fit(std::span<const double> x, std::span<const double> y);

/// How well two curves agree in shape and in value, 1 at best [1]: Lin, A concordance correlation
/// coefficient to evaluate reproducibility, 1989. Of as many a as b; zero if neither varies.
double concordance(std::span<const double> a, std::span<const double> b);

}  // namespace pierce::app
