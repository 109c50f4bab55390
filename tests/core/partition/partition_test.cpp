// Which part owns a body, and what parts see, against brute force.
#include "core/partition/partition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/partition/memory_parts.hpp"
#include "core/partition/space_partition.hpp"
#include "core/step/common/contact_keys.hpp"
#include "pierce/plan.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

TEST(DivideSpaceTest, GivesEachPartItsShare) {
    test::Random random(3);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    for (int i = 0; i < 40; ++i) {
        std::vector<WeightedPoint> points(static_cast<std::size_t>(random.integer(0, 400)));
        double all = 0, heaviest = 0;
        for (WeightedPoint& p : points) {
            p = {random.in_box(10), random.uniform(0.5, 2)};
            all += p.weight;
            heaviest = std::max(heaviest, p.weight);
        }
        std::vector<double> shares(static_cast<std::size_t>(random.integer(1, 7)));
        double sum = 0;
        for (double& share : shares) sum += share = random.uniform(0.5, 3);
        const std::vector<std::uint32_t> parts = divide_space(points, shares);
        ASSERT_EQ(parts.size(), points.size());
        std::vector<double> got(shares.size(), 0);
        for (std::size_t p = 0; p < points.size(); ++p) got.at(parts[p]) += points[p].weight;
        // A cut misses by half a point at most, and three cuts lead to a part.
        for (std::size_t k = 0; k < shares.size(); ++k)
            EXPECT_NEAR(got[k], all * shares[k] / sum, 1.5 * heaviest);
        EXPECT_EQ(divide_space(points, shares), parts);
    }
}

TEST(DivideSpaceTest, CutsAcrossTheLongestSide) {
    std::vector<WeightedPoint> points;
    for (int i = 0; i < 100; ++i) points.push_back({{0.1 * (i % 7), 5.0 * i, 0.3 * (i % 11)}, 1});
    const std::vector<double> shares = {1, 3};
    const std::vector<std::uint32_t> parts = divide_space(points, shares);
    for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(parts[i], i < 25 ? 0u : 1u);
}

/// Bodies that are boxes, as a step gets them.
struct Boxes {
    std::vector<BodyView> bodies;
    std::vector<BodyId> ids;
    std::vector<std::uint32_t> changed;
    std::vector<Triangle> triangles = std::vector<Triangle>(12);
    Plan plan;

    explicit Boxes(std::uint32_t count) : bodies(count), ids(count) {
        plan.revision = 1;
        for (std::uint32_t b = 0; b < count; ++b) {
            ids[b] = {b, 1};
            changed.push_back(b);
            bodies[b].mesh.triangles = {triangles.data(), 12};
            bodies[b].mesh.box = {{-1, -1, -1}, {1, 1, 1}};
            bodies[b].motion = Motion::rigid;
        }
    }
    void put(std::uint32_t b, Vec3d at) {
        bodies[b].space.origin = bodies[b].start_space.origin = at;
        bodies[b].world_box = {at - Vec3d{1, 1, 1}, at + Vec3d{1, 1, 1}};
    }
    Scene scene() {
        Scene all;
        all.bodies = view_of(bodies);
        all.ids = view_of(std::as_const(ids));
        all.changed = view_of(std::as_const(changed));
        all.plan = &plan;
        return all;
    }
};

void expect_pairs_are_seen(const Partition& partition, const Boxes& boxes) {
    for (std::uint32_t a = 0; a < boxes.bodies.size(); ++a)
        for (std::uint32_t b = a + 1; b < boxes.bodies.size(); ++b) {
            const BodyView &first = boxes.bodies[a], &second = boxes.bodies[b];
            if (!first.active || !second.active || !boxes.ids[a] || !boxes.ids[b]) continue;
            if (first.motion == Motion::fixed && second.motion == Motion::fixed) continue;
            if (!overlap(first.world_box, second.world_box)) continue;
            const std::uint32_t of_first = partition.owners()[a], of_second = partition.owners()[b];
            const std::uint32_t part = part_of_pair(first.motion, of_first, second.motion,
                                                    of_second);
            EXPECT_EQ(part, part_of_pair(second.motion, of_second, first.motion, of_first));
            EXPECT_TRUE(partition.near(part)[a] && partition.near(part)[b])
                << a << " and " << b << " of part " << part;
        }
}

TEST(PartitionTest, PairsAreSeenByTheirPart) {
    test::Random random(4);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    std::uint32_t cuts = 0, ghosts = 0, unseen = 0, kept = 0;
    for (int world = 0; world < 12; ++world) {
        Boxes boxes(120);
        const std::vector<double> shares(static_cast<std::size_t>(random.integer(1, 5)), 1.0);
        Partition partition(shares);
        std::vector<Vec3d> at, speed;
        for (std::uint32_t b = 0; b < boxes.bodies.size(); ++b) {
            at.push_back(random.in_box(15));
            // In some worlds all come together, so that parts see more and more of them.
            speed.push_back(world % 4 == 2 ? at.back() * (-1.0 / 40)
                                           : random.in_box(world % 2 == 0 ? 1 : 0.02));
            if (b % 10 == 0) boxes.bodies[b].motion = Motion::fixed;
            if (b % 37 == 5) boxes.ids[b] = {};
            if (b % 41 == 7) boxes.bodies[b].active = false;
        }
        // One is as large as all the others' space.
        boxes.bodies[3].mesh.box = {{-30, -30, -1}, {30, 30, 1}};
        for (int step = 0; step < 30; ++step) {
            for (std::uint32_t b = 0; b < boxes.bodies.size(); ++b)
                boxes.put(b, at[b] += boxes.bodies[b].motion == Motion::fixed ? Vec3d{} : speed[b]);
            boxes.bodies[3].world_box = {at[3] - Vec3d{30, 30, 1}, at[3] + Vec3d{30, 30, 1}};
            const Scene scene = boxes.scene();
            partition.begin(scene, step == 0);
            for (std::uint32_t p = 0; p < partition.parts(); ++p)
                partition.measure_on_host(scene, p);
            if (partition.is_out_of_date(0)) {
                for (std::uint32_t p = 0; p < partition.parts(); ++p) partition.look_around(p);
                cuts += partition.cut(scene);
            } else {
                ++kept;
            }
            expect_pairs_are_seen(partition, boxes);
            for (std::uint32_t p = 0; p < partition.parts(); ++p) {
                const BodySet residents = partition.residents(p);
                for (std::uint32_t b = 0; b < boxes.bodies.size(); ++b) {
                    EXPECT_LE(partition.near(p)[b], residents[b]);
                    EXPECT_FALSE(partition.near(p)[b] && !boxes.ids[b]);
                    ghosts += partition.near(p)[b] && partition.owners()[b] != p;
                    unseen += !partition.near(p)[b];
                }
            }
        }
    }
    EXPECT_GT(cuts, 12u) << "some worlds are cut again";
    EXPECT_GT(kept, 50u) << "not every step looks around";
    EXPECT_GT(ghosts, 1000u);
    EXPECT_GT(unseen, 10000u);
}

/// A memory of random pairs with contacts; what belongs to a pair can be told from its key.
StepMemory random_memory(test::Random& random, std::uint64_t first, std::uint64_t last) {
    StepMemory m;
    m.sheet_bits = 5;
    for (std::uint64_t key = first; key < last; ++key) {
        if (random.integer(0, 2) == 0) continue;
        const std::uint64_t pair = m.pair_keys.size();
        m.pair_keys.push_back(key);
        m.identities.emplace_back().mesh_a = key;
        for (std::uint32_t side = 0; side < 2; ++side) {
            PairMemory directed;
            directed.odometer = static_cast<double>(2 * key + side);
            directed.first_block = static_cast<std::uint32_t>(m.blocks.size());
            m.directed.push_back(directed);
            BlockRecord block;
            block.kept = 1;
            block.first_patch = static_cast<std::uint32_t>(m.patches.size());
            m.blocks.push_back(block);
            PatchRecord patch;
            patch.mask = 1;
            patch.first_vertex = static_cast<std::uint32_t>(m.vertices.size());
            m.patches.push_back(patch);
            VertexRecord vertex;
            vertex.triangle = static_cast<std::uint32_t>(2 * key + side);
            vertex.contact = static_cast<std::uint32_t>(m.contact_keys.size());
            m.vertices.push_back(vertex);
            m.contact_keys.push_back(
                ContactKey::of_vertex(static_cast<std::uint32_t>(pair), side, 7));
            m.ages.push_back(static_cast<std::uint32_t>(2 * key + side));
            m.contacts.push_back({});
            m.contacts.back().vertex = m.ages.back();
        }
        m.sheet_keys.push_back(pair << 8 | 3);
        m.sheet_records.emplace_back().age = static_cast<std::uint32_t>(key);
        m.deepest.push_back(static_cast<std::uint32_t>(key));
    }
    return m;
}

void expect_whole(const StepMemory& m) {
    EXPECT_TRUE(std::ranges::is_sorted(m.pair_keys));
    EXPECT_TRUE(std::ranges::is_sorted(m.contact_keys));
    EXPECT_TRUE(std::ranges::is_sorted(m.sheet_keys));
    ASSERT_EQ(m.directed.size(), 2 * m.pair_keys.size());
    ASSERT_EQ(m.contact_keys.size(), 2 * m.pair_keys.size());
    ASSERT_EQ(m.sheet_keys.size(), m.pair_keys.size());
    for (std::size_t p = 0; p < m.pair_keys.size(); ++p) {
        const std::uint64_t key = m.pair_keys[p];
        EXPECT_EQ(m.identities[p].mesh_a, key);
        EXPECT_EQ(m.deepest[p], key);
        EXPECT_EQ(m.sheet_keys[p] >> 8, p);
        EXPECT_EQ(m.sheet_records[p].age, key);
        for (std::uint32_t side = 0; side < 2; ++side) {
            const PairMemory& directed = m.directed[2 * p + side];
            const VertexRecord& vertex =
                m.vertices[m.patches[m.blocks[directed.first_block].first_patch].first_vertex];
            EXPECT_EQ(directed.odometer, static_cast<double>(2 * key + side));
            EXPECT_EQ(vertex.triangle, 2 * key + side);
            const std::uint64_t contact_key = ContactKey::of_vertex(static_cast<std::uint32_t>(p),
                                                                    side, 7);
            ASSERT_TRUE(is_contact(view_of(m.contact_keys), vertex.contact, contact_key));
            EXPECT_EQ(m.ages[vertex.contact], 2 * key + side);
            EXPECT_EQ(m.contacts[vertex.contact].vertex, 2 * key + side);
        }
    }
}

TEST(MemoryPartsTest, WhatIsTakenApartAndJoinedIsTheSame) {
    test::Random random(5);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    for (int i = 0; i < 20; ++i) {
        StepMemory all = random_memory(random, 0, 50);
        all.by_world = i % 2 == 1;
        for (std::uint32_t b = 0; b < 9; ++b) all.bodies.emplace_back().id = {b, 1};
        expect_whole(all);
        std::vector<StepMemory> parts;
        for (std::uint64_t part = 0; part < 3; ++part) {
            parts.push_back(part_of_memory(all, [&](Pair pair) { return pair.b % 3 == part; }));
            expect_whole(parts.back());
            for (std::uint64_t key : parts.back().pair_keys) EXPECT_EQ(key % 3, part);
        }
        const std::vector<std::uint32_t> owners = {0, 1, 2, 2, 1, 0, 0, 1, 2};
        const StepMemory joined = join_memory(parts, owners);
        expect_whole(joined);
        EXPECT_EQ(joined.by_world, all.by_world);
        EXPECT_EQ(joined.pair_keys, all.pair_keys);
        EXPECT_EQ(joined.ages, all.ages);
        ASSERT_EQ(joined.bodies.size(), 9u);
        for (std::uint32_t b = 0; b < 9; ++b) EXPECT_EQ(joined.bodies[b].id, all.bodies[b].id);
    }
}

}  // namespace
}  // namespace pierce
