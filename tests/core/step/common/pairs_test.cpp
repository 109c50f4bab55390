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

std::vector<std::uint64_t> by_sweep(View<const BodyView> bodies, std::uint32_t walks,
                                    View<const Pair> excluded = {},
                                    View<const std::uint32_t> world_begins = {}) {
    SerialExecutor executor;
    std::vector<std::uint64_t> keys(bodies.size), sorted_keys(bodies.size);
    std::vector<std::uint32_t> order(bodies.size), sorted(bodies.size);
    std::vector<stages::SweepItem> items(bodies.size);
    executor.for_each(bodies.size, stages::SweepKey{bodies, view_of(keys), view_of(order)});
    executor.sort(bodies.size, 64, view_of(keys), view_of(order), view_of(sorted_keys),
                  view_of(sorted));
    executor.for_each(bodies.size, stages::GatherSweep{bodies, view_of(sorted), view_of(items)});
    HostBuffer<std::uint64_t> boxes, pairs;
    const stages::PairKeys as_keys{world_begins.size > 0};
    executor.emit(ListId::box_pairs, bodies.size * walks,
                  stages::SweepPairs{.items = view_of(items),
                                     .bodies = bodies,
                                     .world_begins = world_begins,
                                     .keys = as_keys,
                                     .walks = walks},
                  boxes);
    executor.emit(ListId::swept_pairs, count_of(boxes),
                  stages::TestPair{{bodies, {}, excluded}, as_keys, view_of(boxes)}, pairs);
    std::sort(pairs.begin(), pairs.end());
    return {pairs.begin(), pairs.end()};
}

struct Found {
    HostBuffer<std::uint64_t> keys;
    HostBuffer<Pair> pairs;
    HostBuffer<PairIdentity> identities;
    HostBuffer<std::uint32_t> links;
};

Found all_at_once(View<const BodyView> bodies, View<const BodyId> ids, const Found& last,
                  View<const Pair> excluded = {}) {
    SerialExecutor executor;
    Found found;
    const stages::LinkPair link{.bodies = bodies,
                                .ids = ids,
                                .as_keys = {},
                                .last_keys = view_of(last.keys),
                                .last = view_of(last.identities)};
    executor.emit(ListId::pairs, bodies.size * bodies.size,
                  stages::FindPairs{link, {bodies, {}, excluded}}, found.keys, found.pairs,
                  found.identities, found.links);
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

/// Filters and excluded pairs at random.
std::vector<Pair> filter_at_random(std::vector<BodyView>& bodies, test::Random& random) {
    std::vector<Pair> excluded;
    for (BodyView& body : bodies)
        body.filter = {.groups = 1u << random.integer(0, 1),
                       .meets = static_cast<std::uint32_t>(random.integer(1, 3)),
                       .chain = static_cast<std::uint32_t>(random.integer(0, 4)),
                       .world = all_worlds};
    for (std::uint32_t a = 0; a < bodies.size(); ++a)
        for (std::uint32_t b = a + 1; b < bodies.size(); ++b)
            if (random.integer(0, 4) == 0) excluded.push_back({a, b});
    return excluded;
}

/// All pairs of an unfiltered list that a filter lets through.
std::vector<std::uint64_t> let_through(const std::vector<BodyView>& bodies, const Found& all,
                                       const std::vector<Pair>& excluded, bool by_world) {
    std::vector<std::uint64_t> keys;
    for (const Pair p : all.pairs) {
        const Filter &a = bodies[p.a].filter, &b = bodies[p.b].filter;
        const bool wanted = p.is_self() ||
                            ((a.groups & b.meets) != 0 && (b.groups & a.meets) != 0 &&
                             (a.chain == 0 || a.chain != b.chain) &&
                             (a.world == b.world || a.world < 0 || b.world < 0) &&
                             std::count(excluded.begin(), excluded.end(), p) == 0);
        if (wanted) keys.push_back(stages::PairKeys{by_world}.key(view_of(bodies), p.a, p.b));
    }
    std::sort(keys.begin(), keys.end());
    return keys;
}

TEST(PairsTest, FiltersLeaveOutWhatIsNotWanted) {
    test::Random random(9);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t pairs = 0, left_out = 0;
    for (int i = 0; i < 30; ++i) {
        auto bodies = random_bodies(random, static_cast<std::uint32_t>(random.integer(0, 60)));
        const std::vector<BodyId> ids(bodies.size());
        const Found all = all_at_once(view_of(bodies), view_of(ids), {});
        const std::vector<Pair> excluded = filter_at_random(bodies, random);
        const std::vector<std::uint64_t> wanted = let_through(bodies, all, excluded, false);
        const Found found = all_at_once(view_of(bodies), view_of(ids), {}, view_of(excluded));
        ASSERT_EQ(wanted, std::vector<std::uint64_t>(found.keys.begin(), found.keys.end()));
        ASSERT_EQ(wanted, by_sweep(view_of(bodies), 1, view_of(excluded))) << "try " << i;
        ASSERT_EQ(wanted, by_sweep(view_of(bodies), 8, view_of(excluded))) << "try " << i;
        pairs += wanted.size();
        left_out += all.keys.size() - wanted.size();
    }
    EXPECT_GT(pairs, 200u);
    EXPECT_GT(left_out, 200u);
}

TEST(PairsTest, WorldsAreSweptEachForItself) {
    test::Random random(10);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t pairs = 0;
    for (int i = 0; i < 40; ++i) {
        auto bodies = random_bodies(random, static_cast<std::uint32_t>(random.integer(1, 90)));
        const std::vector<BodyId> ids(bodies.size());
        const Found all = all_at_once(view_of(bodies), view_of(ids), {});
        const std::vector<Pair> excluded = filter_at_random(bodies, random);
        const auto worlds = static_cast<std::uint32_t>(random.integer(1, 5));
        std::vector<std::uint32_t> begins(worlds + 2, 0);
        for (BodyView& body : bodies) {
            body.world_place = static_cast<std::uint32_t>(
                random.integer(0, static_cast<int>(worlds)));
            body.filter.world = body.world_place == worlds
                                    ? all_worlds
                                    : 10 * static_cast<std::int32_t>(body.world_place);
            for (std::uint32_t w = body.world_place + 1; w < begins.size(); ++w) ++begins[w];
        }
        const std::vector<std::uint64_t> wanted = let_through(bodies, all, excluded, true);
        for (const std::uint32_t walks : {1u, 8u})
            ASSERT_EQ(wanted, by_sweep(view_of(bodies), walks, view_of(excluded), view_of(begins)))
                << "try " << i;
        for (const std::uint64_t key : wanted) {
            const Pair p = stages::PairKeys{true}.pair(key);
            ASSERT_EQ(stages::PairKeys{true}.key(view_of(bodies), p.a, p.b), key);
        }
        pairs += wanted.size();
    }
    EXPECT_GT(pairs, 500u);
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
