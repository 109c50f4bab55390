#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/measure/truth_program.hpp"
#include "app/output/table.hpp"
#include "scenes/detect/method.hpp"
#include "scenes/files/truth_file.hpp"
#include "scenes/measure/accuracy.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::app {

/// A way of detecting, by the name it has in comparisons.
struct ComparedMethod {
    std::string name;
    scenes::Method method = scenes::Method::rays;
    Settings settings;
};

/// All there are: full, walk, walk-predict, certified, overlaps, complete, reprojected, gjk-hull,
/// gjk-epa, gimpact, fcl.
std::span<const ComparedMethod> compared_methods();

/// Throws InputError for an unknown name.
const ComparedMethod& compared_method_named(const std::string& name);

/// What came of a method on a recording.
struct Comparison {
    std::string name;
    std::vector<double> ms;             ///< per frame, the whole step
    std::vector<double> missed_shares;  ///< per frame, of the depth [1]; NaN without the truth
    double contacts = 0;                ///< per frame, mean
    scenes::Accuracy accuracy;

    double median_ms() const;
};

/// All methods on the same frames, taking turns frame by frame, against the truth in the frames it
/// knows. Methods that cannot serve the recording are left out, and named in `left_out`.
std::vector<Comparison> compare(const scenes::Recording& recording,
                                std::span<const scenes::TrueFrame> truth,
                                std::span<const ComparedMethod> methods, int threads,
                                const std::string& what,
                                std::vector<std::string>* left_out = nullptr);

/// Convex pieces are not part of a recording; those of the named scenes are known by mesh name and
/// size.
void add_convex_pieces(scenes::SceneSetup& scene);

/// An angle in degrees, as tables have it.
double degrees(double radians);

/// Times and errors, a row for each method.
Table figures_of(std::span<const Comparison> results);

}  // namespace pierce::app
