#include "page/step_figures.hpp"

#include <nlohmann/json.hpp>
#include <string>

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

nlohmann::json plan_figures(const Plan& plan) {
    std::string stages;
    for (StageId stage : plan.stages)
        stages.append(stages.empty() ? "" : ", ").append(name_of(stage));
    nlohmann::json parts = nlohmann::json::array();
    for (const PlannedPart& part : plan.parts)
        parts.push_back({{"backend", part.backend},
                         {"share", part.share},
                         {"bodies", part.bodies},
                         {"ghosts", part.ghosts},
                         {"triangles", part.triangles}});
    return {{"fixed_bodies", plan.fixed_bodies},
            {"rigid_bodies", plan.rigid_bodies},
            {"deforming_bodies", plan.deforming_bodies},
            {"open_bodies", plan.open_bodies},
            {"sheets", plan.sheets},
            {"stages", stages},
            {"parts", parts}};
}

}  // namespace pierce::page
