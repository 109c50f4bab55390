#include "app/output/statistics.hpp"

#include <cmath>
#include <cstddef>

namespace pierce::app {
namespace {

double covariance(std::span<const double> a, std::span<const double> b) {
    const double mean_a = mean(a), mean_b = mean(b);
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
    return a.empty() ? 0 : sum / static_cast<double>(a.size());
}

}  // namespace

double mean(std::span<const double> values) {
    double sum = 0;
    for (double v : values) sum += v;
    return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

double deviation(std::span<const double> values) { return std::sqrt(covariance(values, values)); }

LinearFit linear_fit(std::span<const double> x, std::span<const double> y) {
    const double xx = covariance(x, x), xy = covariance(x, y), yy = covariance(y, y);
    if (!(xx > 0)) return {};
    const double slope = xy / xx;
    return {slope, mean(y) - slope * mean(x), yy > 0 ? xy * xy / (xx * yy) : 1};
}

double concordance(std::span<const double> a, std::span<const double> b) {
    const double apart = mean(a) - mean(b);
    const double spread = covariance(a, a) + covariance(b, b) + apart * apart;
    // Without a spread, all values of both are the same.
    return spread > 0 ? 2 * covariance(a, b) / spread : 1;
}

}  // namespace pierce::app
