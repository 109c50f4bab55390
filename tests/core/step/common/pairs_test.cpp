// Pairs of bodies: a sweep, and all pairs at once, find the same ones, and know which they were in
// the last step.
#include "core/step/common/pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/execute/host_executor.hpp"
#include "core/execute/serial_executor.hpp"
#include "core/step/common/records.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

/// Boxes in any pose: some of bodies that never move, some left out, some of cloth that is looked
/// for in itself.
std::vector<BodyView> random_bodies(test::Random& random, std::uint32_t count) {
    std::vector<BodyView> bodies(count);
    for (BodyView& body : bodies) {
        const Vec3d half{random.uniform(0.05, 0.6), random.uniform(0.05, 0.6),
                         random.uniform(0.05, 0.6)};
        body.fit.rotation = rotation_matrix(random.rotation());
        body.fit.origin = random.in_box(2);
        body.fit_box = {-half, half};
        body.world_box = {};
        for (int corner = 0; corner < 8; ++corner)
            body.world_box.extend(
                body.fit.to_parent({corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y,
                                    corner & 4 ? half.z : -half.z}));
        body.touch = 1e-9;
        body.mesh_key = static_cast<std::uint64_t>(random.integer(1, 3));
        body.motion = static_cast<Motion>(random.integer(0, 2));
        body.active = random.integer(0, 9) != 0;
        if (random.integer(0, 4) == 0) body.collision.self = SelfCollision::on;
    }
    return bodies;
}

std::vector<std::uint64_t> by_sweep(View<const BodyView> bodies, std::uint32_t walks) {
    SerialExecutor executor;
    std::vector<std::uint64_t> keys(bodies.size), sorted_keys(bodies.size);
    std::vector<std::uint32_t> order(bodies.size), sorted(bodies.size);
    std::vector<stages::SweepItem> items(bodies.size);
    executor.for_each(bodies.size, stages::SweepKey{bodies, view_of(keys), view_of(order)});
    executor.sort(bodies.size, stages::sweep_key_bits, view_of(keys), view_of(order),
                  view_of(sorted_keys), view_of(sorted));
    executor.for_each(bodies.size, stages::GatherSweep{bodies, view_of(sorted), view_of(items)});
    HostBuffer<std::uint64_t> boxes, pairs;
    executor.emit(ListId::box_pairs, bodies.size * walks, stages::SweepPairs{view_of(items), walks},
                  boxes);
    executor.emit(ListId::swept_pairs, count_of(boxes), stages::TestPair{bodies, view_of(boxes)},
                  pairs);
    std::sort(pairs.begin(), pairs.end());
    return {pairs.begin(), pairs.end()};
}

struct Found {
    HostBuffer<std::uint64_t> keys;
    HostBuffer<Pair> pairs;
    HostBuffer<PairIdentity> identities;
    HostBuffer<std::uint32_t> links;
};

Found all_at_once(View<const BodyView> bodies, View<const BodyId> ids, const Found& last) {
    SerialExecutor executor;
    Found found;
    const stages::LinkPair link{bodies, ids, view_of(last.keys), view_of(last.identities)};
    executor.emit(ListId::pairs, bodies.size * bodies.size, stages::FindPairs{link}, found.keys,
                  found.pairs, found.identities, found.links);
    return found;
}

TEST(PairsTest, AllAtOnceAreThoseOfTheSweep) {
    test::Random random(7);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t pairs = 0, themselves = 0;
    for (int i = 0; i < 60; ++i) {
        const auto bodies = random_bodies(random,
                                          static_cast<std::uint32_t>(random.integer(0, 70)));
        const std::vector<BodyId> ids(bodies.size());
        const Found found = all_at_once(view_of(bodies), view_of(ids), {});
        const std::vector<std::uint64_t> keys(found.keys.begin(), found.keys.end());
        ASSERT_EQ(keys, by_sweep(view_of(bodies), 1)) << "try " << i;
        ASSERT_EQ(keys, by_sweep(view_of(bodies), 8)) << "try " << i;
        for (const Pair pair : found.pairs)
            ASSERT_TRUE(pair.is_self() || bodies[pair.a].motion != Motion::fixed ||
                        bodies[pair.b].motion != Motion::fixed);
        pairs += keys.size();
        themselves += static_cast<std::size_t>(std::count_if(
            found.pairs.begin(), found.pairs.end(), [](Pair pair) { return pair.is_self(); }));
    }
    EXPECT_GT(pairs, 1000u);
    EXPECT_GT(themselves, 100u);
}

TEST(PairsTest, AreLinkedToTheSameBodiesAndMeshesOfTheLastStep) {
    test::Random random(8);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t linked = 0, fresh = 0;
    for (int i = 0; i < 60; ++i) {
        auto bodies = random_bodies(random, 40);
        std::vector<BodyId> ids(bodies.size());
        for (std::uint32_t b = 0; b < 40; ++b) ids[b] = {b, 1};
        const Found last = all_at_once(view_of(bodies), view_of(ids), {});
        for (std::uint32_t b = 0; b < 40; ++b) {
            const int what = random.integer(0, 9);
            if (what == 0) ids[b].generation = 2;
            if (what == 1) ++bodies[b].mesh_key;
            if (what == 2) bodies[b].fit.origin += random.in_box(0.5);
        }
        const Found now = all_at_once(view_of(bodies), view_of(ids), last);
        for (std::uint32_t p = 0; p < count_of(now.keys); ++p) {
            const auto at = std::find(last.keys.begin(), last.keys.end(), now.keys[p]);
            const auto place = static_cast<std::uint32_t>(at - last.keys.begin());
            const bool is_known = at != last.keys.end() &&
                                  last.identities[place].is(now.identities[p]);
            ASSERT_EQ(now.links[p], is_known ? place : stages::no_pair)
                << "try " << i << " pair " << p;
            ++(is_known ? linked : fresh);
        }
    }
    EXPECT_GT(linked, 1000u);
    EXPECT_GT(fresh, 100u);
}

}  // namespace
}  // namespace pierce
