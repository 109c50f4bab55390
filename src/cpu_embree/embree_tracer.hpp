#pragma once

#include <memory>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/trace/tracer.hpp"
#include "cpu_embree/tbb_executor.hpp"

namespace pierce {

/// Embree builds, refits and traverses the trees; the triangle test is ours (CrossingSearch), run
/// from Embree's leaves. Boxes reach beyond their triangles by the rounding of float32 rays, so no
/// crossing is lost: the answer is the same as by brute force.
///
/// One tree per mesh, in its own space, serves all its fixed and rigid bodies. A deforming body has
/// a tree of its own, refitted when its positions changed and rebuilt when RefitPolicy says so or
/// its mesh changed.
class EmbreeTracer {
public:
    /// Throws std::runtime_error if Embree cannot start.
    EmbreeTracer();
    ~EmbreeTracer();

    void update(TbbExecutor& executor, View<const BodyView> bodies,
                View<const std::uint32_t> wanted);
    void closest_hits(TbbExecutor& executor, View<const BodyView> bodies, std::uint32_t count,
                      View<const Ray> rays, View<Hit> hits);
    void closest_triangles(TbbExecutor& executor, View<const BodyView> bodies, std::uint32_t count,
                           View<const Ray> rays, View<std::uint32_t> triangles);
    void add_up(TbbExecutor&) {}
    TracerCounts counts(const TbbExecutor&) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

static_assert(Tracer<EmbreeTracer, TbbExecutor>);

}  // namespace pierce
