// What the Embree backend does with its trees, and that no answer depends on it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/device/view.hpp"
#include "core/execute/serial_executor.hpp"
#include "core/trace/refit_policy.hpp"
#include "cpu_embree/tbb_executor.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

TEST(EmbreeBackendTest, RefusesNegativeThreads) { EXPECT_THROW(embree_backend(-1), InputError); }

TEST(EmbreeBackendTest, RefitsOnlyDeformingBodiesThatAreHit) {
    World world(embree_backend(1));
    const MeshId ball = world.add_mesh("ball", scenes::sphere(1, 2));
    std::vector<BodyId> bodies;
    const auto at = [](double x) { return test::placed(scenes::sphere(1, 2), {{x, 0, 0}, {}}); };
    for (double x : {0.0, 1.5, 10.0}) bodies.push_back(world.add_deforming_body(ball, at(x)));
    world.detect();
    for (int i = 0; i < 3; ++i)
        world.set_positions(bodies[static_cast<std::size_t>(i)], at(i == 2 ? 10.1 : 1.4 * i));
    world.detect();
    EXPECT_EQ(world.stats().refits, 2u) << "the third ball is far away from both";
    world.detect();
    EXPECT_EQ(world.stats().refits, 0u) << "nothing moved";
}

/// A body scrambled until its first tree is useless: it is rebuilt, and the contacts are the
/// reference's all along.
TEST(EmbreeBackendTest, RebuildsADecayedTreeAndStaysRight) {
    test::Random random(3);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    World embree(embree_backend(1)), reference;
    // A band of small boxes as one mesh: they can change places without any of them changing shape.
    MeshData boxes;
    constexpr int count = 60;
    for (int i = 0; i < count; ++i) {
        const MeshData one = scenes::box({0, 0, 0}, {0.9, 0.9, 0.9});
        for (Triangle t : one.triangles) {
            const auto base = static_cast<std::uint32_t>(boxes.positions.size());
            boxes.triangles.push_back(
                {{t.vertex[0] + base, t.vertex[1] + base, t.vertex[2] + base}});
        }
        for (Vec3f p : one.positions)
            boxes.positions.push_back(p + Vec3f{static_cast<float>(i), 0, 0});
    }
    const MeshData rod = scenes::box({-1, 0.2, 0.2}, {count + 1, 0.5, 0.5});
    // Fine, so that its rays tell a fresh tree from a decayed one within a few steps.
    const MeshData ring = scenes::torus(8, 0.2, 1000, 8);
    for (World* world : {&embree, &reference}) {
        world->add_deforming_body(world->add_mesh("boxes", boxes));
        world->add_rigid_body(world->add_mesh("ring", ring), {{8, 0.4, 0.4}, {}});
        world->add_rigid_body(world->add_mesh("rod", rod));
    }
    std::uint64_t rebuilds = 0;
    std::vector<int> order(count);
    for (int i = 0; i < count; ++i) order[static_cast<std::size_t>(i)] = i;
    for (int step = 0; step < 60; ++step) {
        if (step >= 5)
            for (int k = 0; k < 10; ++k)
                std::swap(order[static_cast<std::size_t>(random.integer(0, count - 1))],
                          order[static_cast<std::size_t>(random.integer(0, count - 1))]);
        std::vector<Vec3f> positions = boxes.positions;
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i].x += static_cast<float>(order[i / 8]) - static_cast<float>(i / 8);
        for (World* world : {&embree, &reference}) world->set_positions({0, 1}, positions);
        embree.detect();
        reference.detect();
        ASSERT_EQ(contact_hash(embree.contacts()), contact_hash(reference.contacts()))
            << "step " << step;
        rebuilds += embree.stats().rebuilds;
    }
    EXPECT_GT(rebuilds, 0u);
    EXPECT_LT(rebuilds, 45u) << "and not in every step";
}

TEST(RefitPolicyTest, RebuildsWhenTheExcessHasPaidForIt) {
    RefitPolicy policy;
    policy.record(constants::rebuild_baseline_rays, 2 * constants::rebuild_baseline_rays);
    policy.record(1000, 2000);
    EXPECT_FALSE(policy.should_rebuild(100)) << "no worse than fresh";
    policy.record(1000, 3500);
    EXPECT_FALSE(policy.should_rebuild(100));
    policy.record(1000, 3500);
    EXPECT_TRUE(policy.should_rebuild(100)) << "3000 tests in excess, a rebuild costs 2000";
    policy.restart();
    EXPECT_FALSE(policy.should_rebuild(100));
}

/// Sorts keys that have their places as values, and compares with the standard library's sort.
void expect_sorted(HostSort& sort, std::vector<std::uint64_t> keys) {
    std::vector<std::uint32_t> values(keys.size()), expected(keys.size());
    std::iota(values.begin(), values.end(), 0u);
    std::iota(expected.begin(), expected.end(), 0u);
    const std::vector<std::uint64_t> before = keys;
    std::ranges::stable_sort(expected, {}, [&](std::uint32_t k) { return before[k]; });
    sort(view_of(keys), view_of(values));
    for (std::size_t k = 0; k < expected.size(); ++k) {
        ASSERT_EQ(keys[k], before[expected[k]]);
        ASSERT_EQ(values[k], expected[k]);
    }
}

TEST(HostSortTest, IsStableForKeysInAnyOrder) {
    test::Random random(5);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    HostSort sort;
    for (int i = 0; i < 300; ++i) {
        const int size = random.integer(0, 400),
                  spread = random.integer(0, 3) == 0 ? 1 << 30 : random.integer(1, 50);
        std::vector<std::uint64_t> keys;
        for (int k = 0; k < size; ++k) {
            const auto noise = static_cast<std::uint64_t>(random.integer(0, spread));
            keys.push_back(
                (static_cast<std::uint64_t>(i % 2 == 0 ? k : random.integer(0, 20)) << 40) +
                (noise << (i % 3 * 8)));
        }
        ASSERT_NO_FATAL_FAILURE(expect_sorted(sort, keys));
    }
}

TEST(HostSortTest, MergesListsThatAreNearlyInOrder) {
    test::Random random(6);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    HostSort sort;
    for (int i = 0; i < 100; ++i) {
        std::vector<std::uint64_t> keys;
        for (int part = random.integer(1, 8); part > 0; --part) {
            const int size = random.integer(0, 300);
            for (int k = 0; k < size; ++k)
                keys.push_back(static_cast<std::uint64_t>(2 * k + random.integer(0, 6)));
        }
        ASSERT_NO_FATAL_FAILURE(expect_sorted(sort, keys));
    }
}

TEST(TbbExecutorTest, RunsEveryItemOnceAndMatchesTheSerialOne) {
    SerialExecutor serial;
    for (int threads : {1, 2, 3}) {
        TbbExecutor parallel(threads);
        for (std::uint32_t n : {0u, 1u, 15u, 1234u}) {
            std::vector<std::uint32_t> visits(n, 0), in(n), expected(n), out(n);
            parallel.for_each(n, [&](std::uint32_t i) { ++visits[i]; });
            EXPECT_EQ(visits, std::vector<std::uint32_t>(n, 1));
            for (std::uint32_t i = 0; i < n; ++i) in[i] = i * 7 % 5;
            const std::uint32_t total = serial.exclusive_scan(
                ListId::parts, n, view_of(std::as_const(in)), view_of(expected));
            EXPECT_EQ(
                parallel.exclusive_scan(ListId::parts, n, view_of(std::as_const(in)), view_of(out)),
                total);
            EXPECT_EQ(out, expected);
        }
    }
}

}  // namespace
}  // namespace pierce
