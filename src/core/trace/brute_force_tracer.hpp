#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/execute/serial_executor.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/tracer.hpp"

namespace pierce {

/// Shows every triangle of the target to every ray: the definition of a right answer.
class BruteForceTracer {
public:
    template <class E>
    void update(E&, View<const BodyView>, View<const std::uint32_t>) {}

    template <class E>
    void closest_hits(E& executor, View<const BodyView> bodies, typename E::Count count,
                      View<const Ray> rays, View<Hit> hits) {
        executor.for_each(count, Trace{bodies, rays, hits});
    }

    template <class E>
    void closest_triangles(E& executor, View<const BodyView> bodies, typename E::Count count,
                           View<const Ray> rays, View<std::uint32_t> triangles) {
        executor.for_each(count, Closest{bodies, rays, triangles});
    }

    template <class E>
    void add_up(E&) {}
    /// Counts nothing: it has no trees.
    template <class E>
    TracerCounts counts(const E&) const {
        return {};
    }

private:
    struct Trace {
        View<const BodyView> bodies;
        View<const Ray> rays;
        View<Hit> hits;

        void operator()(std::uint32_t i) const {
            const Ray& ray = rays[i];
            hits[i] = {};
            if (!(ray.t_max >= 0)) return;
            const Surface surface = bodies[ray.target].surface();
            hits[i] = first_crossing(ray, surface, [&](CrossingSearch& search) {
                for (std::uint32_t t = 0; t < surface.triangles.size; ++t) search.test(t);
            });
        }
    };

    struct Closest {
        View<const BodyView> bodies;
        View<const Ray> rays;
        View<std::uint32_t> triangles;

        void operator()(std::uint32_t i) const {
            const Surface surface = bodies[rays[i].target].surface();
            triangles[i] = closest_triangle(rays[i], surface, [&](ClosestSearch& search) {
                for (std::uint32_t t = 0; t < surface.triangles.size; ++t) search.test(t);
            });
        }
    };
};

static_assert(Tracer<BruteForceTracer, SerialExecutor>);

}  // namespace pierce
