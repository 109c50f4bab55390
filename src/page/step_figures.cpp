#include "page/step_figures.hpp"

#include <nlohmann/json.hpp>

namespace pierce::page {

nlohmann::json step_figures(const StepStats& stats) {
    nlohmann::json ms{{"total", stats.milliseconds}};
    for (const StageTime& t : stats.stages) ms[name_of(t.stage)] = t.milliseconds;
    if (stats.device_milliseconds > 0) ms["device"] = stats.device_milliseconds;
    return {{"ms", ms},
            {"contacts", stats.contacts},
            {"pairs", stats.pairs},
            {"touching_pairs", stats.touching_pairs},
            {"rays", stats.rays},
            {"hits", stats.hits},
            {"edges", stats.edges},
            {"edge_contacts", stats.edge_contacts},
            {"certified", stats.certified},
            {"reprojected", stats.reprojected},
            {"crossings", stats.crossings},
            {"status", stats.status},
            {"penetration_mean", stats.penetration_mean},
            {"penetration_max", stats.penetration_max}};
}

}  // namespace pierce::page
