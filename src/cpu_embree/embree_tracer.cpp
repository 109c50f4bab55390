#include "cpu_embree/embree_tracer.hpp"

#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "cpu_embree/embree_tree.hpp"
#include "pierce/error.hpp"
#include "pierce/min_max.hpp"

namespace pierce {
namespace {

using embree::Tree;
using embree::TreeKind;

/// One thread looks from so many points, one after the other: what is closest to one is near the
/// next, which limits its search.
constexpr std::uint32_t points_in_a_row = 16;

/// The tree of a deforming body, and the mesh and positions that the tree was last fitted to.
struct MovingTree {
    std::unique_ptr<Tree> tree;
    std::uint64_t mesh_key = 0;
    std::uint64_t positions_version = 0;
};

/// Which tree is a body's.
struct TreeUse {
    std::uint64_t mesh_key = 0;
    bool deforms = false;  ///< it has one of its own

    friend bool operator==(const TreeUse&, const TreeUse&) = default;
};

}  // namespace

struct EmbreeTracer::State {
    RTCDevice device = nullptr;
    std::unordered_map<std::uint64_t, std::unique_ptr<Tree>> still;  ///< by mesh key
    std::vector<MovingTree> moving;                                  ///< by body
    std::vector<TreeUse> uses;         ///< by body, when unused trees were last dropped
    std::vector<Tree*> trees;          ///< by body, for this step
    std::vector<std::uint32_t> tests;  ///< by ray
    bool many_trees = false;           ///< some body has a tree of its own
    std::vector<std::uint32_t> order;  ///< ray indices by target, so that each of many trees is
                                       ///< fetched once
    std::vector<std::uint32_t> first_of_target;  ///< where a body's rays begin in `order`; one more
                                                 ///< at the end
    TracerCounts counts;

    ~State() {
        still.clear();
        moving.clear();
        if (device != nullptr) rtcReleaseDevice(device);
    }

    /// Throws if Embree has reported an error on this thread since the last call; every thread has
    /// errors of its own.
    void check() const {
        const RTCError error = rtcGetDeviceError(device);
        if (error == RTC_ERROR_OUT_OF_MEMORY) throw OutOfMemory("Embree has no memory left");
        if (error != RTC_ERROR_NONE)
            throw std::runtime_error("Embree reports error " +
                                     std::to_string(static_cast<int>(error)));
    }

    void forget_unused(View<const BodyView> bodies);
    void sort_by_target(std::uint32_t body_count, View<const Ray> rays);
    void update_moving(const BodyView& body, MovingTree& entry, TracerCounts& done);
};

EmbreeTracer::EmbreeTracer() : state_(std::make_unique<State>()) {
    // No thread count is given: Embree would limit oneTBB to it in the whole process.
    state_->device = rtcNewDevice(nullptr);
    if (state_->device == nullptr)
        throw std::runtime_error("Embree cannot start: error " +
                                 std::to_string(static_cast<int>(rtcGetDeviceError(nullptr))));
}

EmbreeTracer::~EmbreeTracer() = default;

/// Sorts by counting. Measured on 100 deforming tori: tracing takes a tenth less.
void EmbreeTracer::State::sort_by_target(std::uint32_t body_count, View<const Ray> rays) {
    first_of_target.assign(body_count + 1, 0);
    for (const Ray& ray : rays) ++first_of_target[ray.target + 1];
    for (std::uint32_t b = 0; b < body_count; ++b) first_of_target[b + 1] += first_of_target[b];
    std::vector<std::uint32_t> next(first_of_target.begin(), first_of_target.end() - 1);
    order.resize(rays.size);
    for (std::uint32_t i = 0; i < rays.size; ++i) order[next[rays[i].target]++] = i;
}

/// Drops the trees of meshes that no body uses any more, and of bodies that were removed or no
/// longer deform.
void EmbreeTracer::State::forget_unused(View<const BodyView> bodies) {
    const auto use_of = [&](std::uint32_t b) {
        const bool deforms = bodies[b].motion == Motion::deforming && bodies[b].mesh_key != 0;
        return TreeUse{bodies[b].mesh_key, deforms};
    };
    bool same = uses.size() == bodies.size;
    for (std::uint32_t b = 0; b < bodies.size && same; ++b) same = uses[b] == use_of(b);
    if (same) return;
    uses.clear();
    moving.resize(bodies.size);
    std::unordered_set<std::uint64_t> used;
    for (std::uint32_t b = 0; b < bodies.size; ++b) {
        uses.push_back(use_of(b));
        if (uses[b].deforms) continue;
        moving[b] = {};
        used.insert(uses[b].mesh_key);
    }
    std::erase_if(still, [&](const auto& entry) { return !used.contains(entry.first); });
}

void EmbreeTracer::State::update_moving(const BodyView& body, MovingTree& entry,
                                        TracerCounts& done) {
    const bool other_mesh = entry.mesh_key != body.mesh_key;
    const bool decayed = entry.tree != nullptr &&
                         entry.tree->policy.should_rebuild(entry.tree->triangle_count());
    if (entry.tree == nullptr || other_mesh || decayed) {
        entry.tree = std::make_unique<Tree>(device, TreeKind::moving, body.surface(),
                                            body.world_box);
        entry.mesh_key = body.mesh_key;
        ++done.builds;
        done.rebuilds += decayed && !other_mesh;
    } else if (entry.positions_version != body.positions_version) {
        entry.tree->refit(body.surface(), body.world_box);
        ++done.refits;
    } else {
        entry.tree->see(body.surface());
    }
    entry.positions_version = body.positions_version;
    try {
        check();
    } catch (...) {
        entry = {};  // what could not be built is not used again
        throw;
    }
}

void EmbreeTracer::update(TbbExecutor& executor, View<const BodyView> bodies,
                          View<const std::uint32_t> wanted) {
    State& s = *state_;
    s.forget_unused(bodies);
    s.trees.assign(bodies.size, nullptr);
    std::vector<std::uint32_t> deforming;
    for (std::uint32_t b = 0; b < bodies.size; ++b) {
        if (!wanted[b]) continue;
        if (bodies[b].motion == Motion::deforming) {
            deforming.push_back(b);
            continue;
        }
        std::unique_ptr<Tree>& tree = s.still[bodies[b].mesh_key];
        if (tree == nullptr) {
            auto made = std::make_unique<Tree>(s.device, TreeKind::still, bodies[b].surface(),
                                               bodies[b].fit_box);
            s.check();
            tree = std::move(made);
            ++s.counts.builds;
        } else {
            tree->see(bodies[b].surface());
        }
        s.trees[b] = tree.get();
    }
    s.many_trees = !deforming.empty();
    std::vector<TracerCounts> done(deforming.size());
    executor.for_each_task(static_cast<std::uint32_t>(deforming.size()), [&](std::uint32_t i) {
        s.update_moving(bodies[deforming[i]], s.moving[deforming[i]], done[i]);
    });
    for (std::size_t i = 0; i < deforming.size(); ++i) {
        s.trees[deforming[i]] = s.moving[deforming[i]].tree.get();
        s.counts.builds += done[i].builds;
        s.counts.refits += done[i].refits;
        s.counts.rebuilds += done[i].rebuilds;
    }
    s.check();
}

void EmbreeTracer::closest_hits(TbbExecutor& executor, View<const BodyView> bodies,
                                std::uint32_t count, View<const Ray> rays, View<Hit> hits) {
    State& s = *state_;
    if (s.many_trees) s.sort_by_target(bodies.size, rays);
    s.tests.assign(rays.size, 0);
    executor.for_each(count, [&](std::uint32_t k) {
        const std::uint32_t i = s.many_trees ? s.order[k] : k;
        const Ray& ray = rays[i];
        hits[i] = {};
        if (!(ray.t_max >= 0)) return;
        const Tree& tree = *s.trees[ray.target];
        hits[i] = tree.trace(ray, s.tests[i]);
    });

    for (std::uint32_t tests : s.tests) s.counts.triangle_tests += tests;
    if (!s.many_trees) return;
    for (std::uint32_t b = 0; b < bodies.size; ++b) {
        if (bodies[b].motion != Motion::deforming || s.trees[b] == nullptr) continue;
        std::uint64_t tests = 0;
        for (std::uint32_t k = s.first_of_target[b]; k < s.first_of_target[b + 1]; ++k)
            tests += s.tests[s.order[k]];
        s.trees[b]->policy.record(s.first_of_target[b + 1] - s.first_of_target[b], tests);
    }
}

void EmbreeTracer::closest_triangles(TbbExecutor& executor, View<const BodyView> bodies,
                                     std::uint32_t count, View<const Ray> rays,
                                     View<std::uint32_t> triangles) {
    State& s = *state_;
    const auto look_from = [&](std::uint32_t i, std::uint32_t known) {
        const std::uint32_t target = rays[i].target;
        triangles[i] = closest_triangle(
            rays[i], bodies[target].surface(),
            [&](ClosestSearch& search) { s.trees[target]->show_near(search, known); });
    };
    executor.for_each_task((count + points_in_a_row - 1) / points_in_a_row, [&](std::uint32_t row) {
        const std::uint32_t begin = row * points_in_a_row,
                            end = min_of(begin + points_in_a_row, count);
        for (std::uint32_t i = begin; i < end; ++i) {
            const bool has_known = i > begin && rays[i - 1].target == rays[i].target;
            look_from(i, has_known ? triangles[i - 1] : no_triangle);
        }
    });
}

TracerCounts EmbreeTracer::counts(const TbbExecutor&) const { return state_->counts; }

}  // namespace pierce
