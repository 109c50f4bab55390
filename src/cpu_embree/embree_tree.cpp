#include "cpu_embree/embree_tree.hpp"
#include "core/device/bits.hpp"
#include "core/device/four.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/point_sieve.hpp"
#include "core/trace/triangle_sieve.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

#include <cmath>
#include <limits>

namespace pierce::embree {
namespace {

/// A point in a vector register. Every refit makes a box for every triangle: with scalars a refit
/// takes a third longer.
Four load(const Vec3f& p) { return {p.x, p.y, p.z, 0.0f}; }

}  // namespace

/// One ray on its way through Embree. The context is the first member, so that the leaf callback
/// can reach the others from it.
// NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): init_context() fills the context
struct Tree::Query {
    QueryContext context;
    CrossingSearch* search = nullptr;
    TriangleSieve sieve;
    double start = 0;  ///< the place on our ray where Embree's ray begins
    double slack = 0;  ///< how much further than the search's limit Embree looks
    std::uint32_t tests = 0;

    float far_end() const { return round_up(search->limit() - start + slack); }
};

Tree::Tree(RTCDevice device, TreeKind kind, const Surface& surface, const Box& box) {
    scene_ = rtcNewScene(device);
    geometry_ = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    set_surface(surface, box);
    rtcSetGeometryUserPrimitiveCount(geometry_, surface.triangles.size);
    rtcSetGeometryUserData(geometry_, this);
    rtcSetGeometryBoundsFunction(geometry_, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry_, intersect);
    rtcSetGeometryPointQueryFunction(geometry_, test_near);
    if (kind == TreeKind::moving) {
        // Refitting needs these three settings. With any other scene quality Embree rebuilds
        // without reporting it.
        rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_DYNAMIC));
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
        rtcSetGeometryBuildQuality(geometry_, RTC_BUILD_QUALITY_REFIT);
    } else {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
    }
    rtcCommitGeometry(geometry_);
    rtcAttachGeometry(scene_, geometry_);
    rtcJoinCommitScene(scene_);  // runs in the caller's arena and so keeps to its thread count
}

Tree::~Tree() {
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
}

void Tree::set_surface(const Surface& surface, const Box& box) {
    surface_ = surface;
    // A ray in a triangle's plane touches the triangle from as far away as the touch tolerance.
    margin_ = round_up(max_of(constants::tree_margin * box.max_coordinate() + surface.touch,
                              constants::least_tree_margin));
    reach_ = box.inflated(static_cast<double>(margin_));
}

void Tree::refit(const Surface& surface, const Box& box) {
    set_surface(surface, box);
    rtcCommitGeometry(geometry_);
    rtcJoinCommitScene(scene_);  // runs in the caller's arena and so keeps to its thread count
}

Hit Tree::trace(const Ray& ray, std::uint32_t& tests) const {
    CrossingSearch search(ray, surface_);
    Query query{.context = {}, .search = &search, .sieve = TriangleSieve(ray)};
    init_context(query.context);
    query.slack = 2.0 * margin_ + surface_.touch;
    // Embree's float32 ray begins near the surface: far away its rounding would exceed the margin.
    double first = -std::numeric_limits<double>::infinity();
    if (ray.outward > surface_.touch || !reach_.contains(ray.origin)) {
        const Stretch inside = stretch_inside(reach_, ray.origin, ray.direction);
        if (inside.begin > inside.end) return search.hit();
        first = inside.begin - query.slack;
    }
    do {
        query.start = max_of(search.begin() - query.slack, first);
        const Vec3f origin = to_float(ray.origin + query.start * ray.direction);
        const Vec3f direction = to_float(ray.direction);
        // Members that Embree does not read stay uninitialized.
        RTCRayHit embree_ray;  // NOLINT(cppcoreguidelines-pro-type-member-init)
        embree_ray.ray = {origin.x,        origin.y,    origin.z,    0.0f,
                          direction.x,     direction.y, direction.z, 0.0f,
                          query.far_end(), 0xffffffffu, 0,           0};
        embree_ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        embree_ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        embree::intersect(scene_, query.context, embree_ray);
    } while (search.again());
    tests += query.tests;
    return search.hit();
}

/// One point on its way through Embree.
struct Tree::PointQuery {
    ClosestSearch* search = nullptr;
    PointSieve sieve;
    double slack = 0;  ///< how much further than the search's limit Embree looks
    std::uint32_t waiting[Four::count] = {};  ///< triangles that are tested together
    std::uint32_t count = 0;                  ///< of those

    float radius() const { return round_up(search->limit() + slack); }

    void add(std::uint32_t triangle) {
        waiting[count++] = triangle;
        if (count == Four::count) test();
    }
    /// Tests those that wait.
    void test() {
        if (count == 0) return;
        const FourVec3 corners[3] = {corner(0), corner(1), corner(2)};
        std::uint32_t tested = sieve.may_be_closest(corners) & ((1u << count) - 1);
        count = 0;
        for (; tested != 0; tested &= tested - 1) search->test(waiting[lowest_bit(tested)]);
    }

private:
    FourVec3 corner(int k) const {
        const Surface& surface = search->surface();
        const auto at = [&](std::uint32_t lane) {
            const std::uint32_t triangle = waiting[lane < count ? lane : 0];
            return surface.positions[surface.triangles[triangle].vertex[k]];
        };
        return FourVec3::of(at(0), at(1), at(2), at(3));
    }
};

void Tree::show_near(ClosestSearch& search, std::uint32_t known) const {
    // The point rounds by half an ulp of its largest coordinate along each axis, and Embree's
    // distances by three ulp. These add up to less than 8 ulp of that coordinate and of the box's.
    double furthest = 0;
    for (int k = 0; k < 3; ++k) furthest = max_of(std::fabs(search.point()[k]), furthest);
    PointQuery query{&search,
                     {search.point(), search.limit(), reach_},
                     2.0 * static_cast<double>(margin_) + constants::slab_margin * furthest};
    if (search.may_leave_out()) query.sieve.keep_limit();
    if (known != no_triangle) {
        query.add(known);
        query.test();
    }
    RTCPointQueryContext context;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    rtcInitPointQueryContext(&context);
    const Vec3f at = to_float(search.point());
    RTCPointQuery embree_query{at.x, at.y, at.z, 0.0f, query.radius()};
    rtcPointQuery(scene_, &embree_query, &context, nullptr, &query);
    query.test();
}

bool Tree::test_near(RTCPointQueryFunctionArguments* arguments) {
    PointQuery& query = *static_cast<PointQuery*>(arguments->userPtr);
    query.add(arguments->primID);
    // To tell Embree about a closer triangle, it is enough to shorten the radius.
    const float before = arguments->query->radius;
    arguments->query->radius = min_of(query.radius(), before);
    return arguments->query->radius < before;
}

void Tree::bounds(const RTCBoundsFunctionArguments* arguments) {
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    const Triangle& t = tree.surface_.triangles[arguments->primID];
    const Four a = load(tree.surface_.positions[t.vertex[0]]),
               b = load(tree.surface_.positions[t.vertex[1]]),
               c = load(tree.surface_.positions[t.vertex[2]]);
    (min_of(a, min_of(b, c)) - tree.margin_).put(&arguments->bounds_o->lower_x);
    (max_of(a, max_of(b, c)) + tree.margin_).put(&arguments->bounds_o->upper_x);
}

void Tree::intersect(const RTCIntersectFunctionNArguments* arguments) {
    Query& query = *reinterpret_cast<Query*>(arguments->context);
    const Tree& tree = *static_cast<const Tree*>(arguments->geometryUserPtr);
    const Triangle& t = tree.surface_.triangles[arguments->primID];
    ++query.tests;
    if (!query.sieve.may_cross(tree.surface_.positions[t.vertex[0]],
                               tree.surface_.positions[t.vertex[1]],
                               tree.surface_.positions[t.vertex[2]]))
        return;
    query.search->test(arguments->primID);
    // To tell Embree about a hit, it is enough to shorten the ray.
    RTCRayHit& ray = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
    ray.ray.tfar = min_of(query.far_end(), ray.ray.tfar);
}

}  // namespace pierce::embree
