// Worlds saved where a backend keeps the shapes of the last step to itself, as a GPU does.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/counting_backend.hpp"

namespace pierce {
namespace {

/// Steps write Scene::seen here, and fetch_seen() tells it.
class OwnShapes : public test::CountingBackend {
public:
    using CountingBackend::CountingBackend;

    void step(const Scene& given, StepStats& stats) override {
        Scene scene = given;
        const std::size_t count = given.seen.size;
        shapes_.resize(count);
        of_.resize(count);
        views_.resize(count);
        for (std::uint32_t b = 0; b < count; ++b) {
            if (of_[b] != given.ids[b] || shapes_[b].size() != given.seen[b].size)
                shapes_[b].assign(given.seen[b].begin(), given.seen[b].end());
            of_[b] = given.ids[b];
            views_[b] = view_of(shapes_[b]);
        }
        scene.seen = view_of(std::as_const(views_));
        CountingBackend::step(scene, stats);
    }
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const override {
        for (std::uint32_t b = 0; b < ids.size && b < of_.size(); ++b)
            if (ids[b] && ids[b] == of_[b] && seen[b].size == shapes_[b].size())
                std::ranges::copy(shapes_[b], seen[b].begin());
    }
    void remember(const StepMemory& memory) override {
        of_.clear();
        shapes_.clear();
        CountingBackend::remember(memory);
    }

private:
    std::vector<std::vector<SeenPatch>> shapes_;
    std::vector<BodyId> of_;
    std::vector<View<SeenPatch>> views_;
};

/// A ball whose corner towards the other one is flat or not.
std::vector<Vec3f> ball_with(const MeshData& ball, float height) {
    constexpr float diagonal = 0.70710678f, plane = 0.2f;
    std::vector<Vec3f> positions = ball.positions;
    for (Vec3f& p : positions) {
        const float beyond = diagonal * (p.x + p.y) - plane;
        if (beyond <= 0) continue;
        p.x -= diagonal * (1 - height) * beyond;
        p.y -= diagonal * (1 - height) * beyond;
    }
    return positions;
}

std::size_t contacts_after_a_save(bool changes_filter) {
    test::Calls calls;
    const MeshData ball = scenes::sphere(0.8, 3);
    const auto own_shapes = [&] { return std::make_unique<OwnShapes>(bvh_backend(), calls); };
    World world(bvh_backend(), {.may_rest = false});
    const MeshId mesh = world.add_mesh("ball", ball);
    const BodyId soft = world.add_deforming_body(mesh, ball_with(ball, 1));
    world.add_rigid_body(mesh, {{1.05, 1.05, 0}, {}});
    const BodyId far = world.add_rigid_body(mesh, {{20, 0, 0}, {}});
    world.detect();
    // The world knows this shape. Those of the next steps only the backend knows.
    std::stringstream first, saved;
    world.save(first);
    world = World::restore(first, own_shapes());
    for (int step = 0; step < 3; ++step) {
        world.set_positions(soft, ball_with(ball, 0));
        world.detect();
    }
    if (changes_filter) world.set_filter(far, {.groups = 3});
    world.save(saved);
    World restored = World::restore(saved, own_shapes());
    restored.set_positions(soft, ball_with(ball, 1));
    restored.detect();
    return restored.contacts().size();
}

TEST(SavedShapesTest, AreThoseOfTheLastStepAlsoAfterAChange) {
    const std::size_t unchanged = contacts_after_a_save(false);
    EXPECT_GT(unchanged, 0u);
    EXPECT_EQ(contacts_after_a_save(true), unchanged);
}

}  // namespace
}  // namespace pierce
