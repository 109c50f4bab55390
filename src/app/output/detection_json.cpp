#include "app/output/detection_json.hpp"

#include <iterator>
#include <nlohmann/json.hpp>

namespace pierce::app {
namespace {

constexpr const char* temporal_names[] = {"off", "paper", "certified"};
constexpr const char* coverage_names[] = {"vertices", "complete", "overlaps"};
constexpr const char* found_names[] = {"full",     "walk",       "prediction", "self",      "near",
                                       "crossing", "remembered", "tangled",    "separation"};
static_assert(std::size(temporal_names) == static_cast<std::size_t>(Temporal::certified) + 1);
static_assert(std::size(coverage_names) == static_cast<std::size_t>(Coverage::overlaps) + 1);
static_assert(std::size(found_names) == static_cast<std::size_t>(Found::separation) + 1);

}  // namespace

using nlohmann::json;

json xyz(Vec3d v) { return {v.x, v.y, v.z}; }

json rays_json(const scenes::RaySettings& rays) {
    const Settings& settings = rays.world;
    return {{"backend", rays.backend},
            {"threads", rays.threads},
            {"temporal", temporal_names[static_cast<int>(settings.temporal)]},
            {"predict", settings.predict},
            {"may_rest", settings.may_rest},
            {"full_every", settings.full_every},
            {"coverage", coverage_names[static_cast<int>(settings.coverage)]},
            {"reproject", settings.reproject},
            {"margin", settings.margin},
            {"inside", name(rays.inside)},
            {"mesh_cache", rays.mesh_cache.string()},
            {"parts", rays.parts},
            {"host_share", rays.host_share}};
}

json contact_json(const Contact& c) {
    json result{{"a", c.a.index},
                {"b", c.b.index},
                {"source", c.source == Side::a ? "a" : "b"},
                {"vertex", c.vertex},
                {"triangle", c.triangle},
                {"barycentric", c.barycentric},
                {"point_a", xyz(c.point_a)},
                {"point_b", xyz(c.point_b)},
                {"normal", xyz(c.normal)},
                {"distance", c.distance},
                {"grazing", c.grazing},
                {"reprojected", c.reprojected},
                {"found", found_names[static_cast<int>(c.found)]}};
    if (c.is_edge()) result.update({{"edge_end", c.edge_end}, {"along", c.along}});
    return result;
}

}  // namespace pierce::app
