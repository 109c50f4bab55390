#include "pierce/cpu_embree/embree_tree.hpp"

namespace pierce::embree {

/// One ray on its way through Embree. The context comes first, so that the leaf callback finds the rest behind it.
struct Tree::Query {
    QueryContext context;
    CrossingSearch* search = nullptr;
    double start = 0;  ///< where on our ray Embree's ray begins
    double slack = 0;  ///< how much further than the search's limit Embree looks
    std::uint32_t tests = 0;

    float far_end() const { return round_up(search->limit() - start + slack); }
};

Tree::Tree(RTCDevice device, TreeKind kind, const Surface& surface, double max_coordinate) {
    scene_ = rtcNewScene(device);
    geometry_ = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    set_surface(surface, max_coordinate);
    rtcSetGeometryUserPrimitiveCount(geometry_, surface.triangles.size);
    rtcSetGeometryUserData(geometry_, this);
    rtcSetGeometryBoundsFunction(geometry_, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry_, intersect);
    if (kind == TreeKind::moving) {
        // Refitting needs all three; with any other scene quality Embree rebuilds without saying so.
        rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_DYNAMIC));
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
        rtcSetGeometryBuildQuality(geometry_, RTC_BUILD_QUALITY_REFIT);
    } else {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
    }
    rtcCommitGeometry(geometry_);
    rtcAttachGeometry(scene_, geometry_);
    rtcJoinCommitScene(scene_);  // in the caller's arena, so that its thread count holds
}

Tree::~Tree() {
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
}

void Tree::set_surface(const Surface& surface, double max_coordinate) {
    surface_ = surface;
    margin_ = round_up(constants::tree_margin * max_coordinate);
}

void Tree::refit(const Surface& surface, double max_coordinate) {
    set_surface(surface, max_coordinate);
    rtcCommitGeometry(geometry_);
    rtcJoinCommitScene(scene_);  // in the caller's arena, so that its thread count holds
}

Hit Tree::trace(const Ray& ray, std::uint32_t& tests) const {
    CrossingSearch search(ray, surface_);
    Query query;
    init_context(query.context);
    query.search = &search;
    query.slack = 2.0 * margin_ + surface_.touch;
    do {
        query.start = search.begin() - query.slack;
        const Vec3f origin = to_float(ray.origin + query.start * ray.direction);
        const Vec3f direction = to_float(ray.direction);
        RTCRayHit embree_ray;
        embree_ray.ray = {origin.x,    origin.y, origin.z,        0.0f,        direction.x, direction.y,
                          direction.z, 0.0f,     query.far_end(), 0xffffffffu, 0,           0};
        embree_ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        embree_ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        embree::intersect(scene_, query.context, embree_ray);
    } while (search.again());
    tests += query.tests;
    return search.hit();
}

void Tree::bounds(const RTCBoundsFunctionArguments* arguments) {
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    const Triangle& t = tree.surface_.triangles[arguments->primID];
    const Vec3f a = tree.surface_.positions[t.vertex[0]], b = tree.surface_.positions[t.vertex[1]],
                c = tree.surface_.positions[t.vertex[2]];
    RTCBounds& box = *arguments->bounds_o;
    box.lower_x = min_of(a.x, min_of(b.x, c.x)) - tree.margin_;
    box.lower_y = min_of(a.y, min_of(b.y, c.y)) - tree.margin_;
    box.lower_z = min_of(a.z, min_of(b.z, c.z)) - tree.margin_;
    box.upper_x = max_of(a.x, max_of(b.x, c.x)) + tree.margin_;
    box.upper_y = max_of(a.y, max_of(b.y, c.y)) + tree.margin_;
    box.upper_z = max_of(a.z, max_of(b.z, c.z)) + tree.margin_;
}

void Tree::intersect(const RTCIntersectFunctionNArguments* arguments) {
    Query& query = *reinterpret_cast<Query*>(arguments->context);
    query.search->test(arguments->primID);
    ++query.tests;
    // Shortening the ray is all that Embree needs to know of a hit.
    RTCRayHit& ray = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
    ray.ray.tfar = min_of(query.far_end(), ray.ray.tfar);
}

}  // namespace pierce::embree
