// Lists of contacts: what is new in them, and few that stand for all.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <tuple>
#include <vector>

#include "pierce/contact_changes.hpp"
#include "pierce/contact_reduction.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

/// A few bodies that overlap, some of them deeply, and move.
struct Pile {
    World world;
    std::vector<BodyId> bodies;
    std::vector<Pose> poses;

    explicit Pile(test::Random& random, double margin)
        : world(bvh_backend(), {.coverage = Coverage::complete, .margin = margin}) {
        for (int k = 0; k < 5; ++k) {
            const MeshId mesh = world.add_mesh("body", test::random_closed_mesh(random));
            poses.push_back({random.in_box(0.9), random.rotation()});
            bodies.push_back(world.add_rigid_body(mesh, poses.back()));
        }
        world.detect();
    }
    void move(test::Random& random) {
        for (std::size_t k = 0; k < bodies.size(); ++k) {
            poses[k].position += random.in_box(0.05);
            world.set_pose(bodies[k], poses[k]);
        }
        world.detect();
    }
};

using Key = std::tuple<BodyId, BodyId, std::uint64_t>;

std::set<Key> keys_of(std::span<const Contact> contacts) {
    std::set<Key> keys;
    for (const Contact& c : contacts) keys.emplace(c.a, c.b, c.feature());
    return keys;
}

TEST(ContactChangesTest, AreThoseOfTheSetsOfFeatures) {
    std::size_t began = 0, stayed = 0, ended = 0;
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        test::Random random(seed);
        SCOPED_TRACE("seed " + std::to_string(random.seed()));
        Pile pile(random, 0.05);
        for (int step = 0; step < 4; ++step) {
            const std::vector<Contact> before(pile.world.contacts().begin(),
                                              pile.world.contacts().end());
            pile.move(random);
            const auto now = pile.world.contacts();
            const ContactChanges changes = contact_changes(before, now);
            const std::set<Key> old_keys = keys_of(before), new_keys = keys_of(now);
            EXPECT_EQ(changes.began.size() + changes.stayed.size(), now.size());
            EXPECT_EQ(changes.ended.size() + changes.stayed.size(), before.size());
            const auto key = [](const Contact& c) { return Key(c.a, c.b, c.feature()); };
            for (std::uint32_t i : changes.began) EXPECT_FALSE(old_keys.contains(key(now[i])));
            for (std::uint32_t i : changes.stayed) EXPECT_TRUE(old_keys.contains(key(now[i])));
            for (std::uint32_t i : changes.ended) EXPECT_FALSE(new_keys.contains(key(before[i])));
            for (const auto* places : {&changes.began, &changes.stayed, &changes.ended})
                EXPECT_TRUE(std::ranges::is_sorted(*places));
            began += changes.began.size();
            stayed += changes.stayed.size();
            ended += changes.ended.size();
        }
    }
    EXPECT_GT(began, 50u);
    EXPECT_GT(stayed, 500u);
    EXPECT_GT(ended, 50u);
}

/// The resultant force and torque around `center` of contacts with weights.
struct Resultant {
    Vec3d force, torque;
    double size = 0;  ///< of all forces, whatever their directions

    void add(const Contact& c, double weight, Vec3d center) {
        const Vec3d f = weight * c.penetration_depth() * c.normal;
        force += f;
        torque += cross(0.5 * (c.point_a + c.point_b) - center, f);
        size += length(f);
    }
};

TEST(ContactReductionTest, KeepsTheResultantOfEveryPair) {
    std::size_t reduced_pairs = 0;
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        test::Random random(seed);
        SCOPED_TRACE("seed " + std::to_string(random.seed()));
        Pile pile(random, seed % 2 == 0 ? 0.05 : 0.0);
        const auto contacts = pile.world.contacts();
        for (const std::uint32_t most : {6u, 8u, 24u}) {
            const std::vector<ReducedContact> few = reduce(contacts, most);
            EXPECT_TRUE(std::ranges::is_sorted(few, std::less_equal<>(), &ReducedContact::contact));
            for (std::size_t begin = 0, end = 0; begin < contacts.size(); begin = end) {
                while (end < contacts.size() && contacts[end].a == contacts[begin].a &&
                       contacts[end].b == contacts[begin].b)
                    ++end;
                const Vec3d center = contacts[begin].point_a;
                Resultant all, rest;
                for (std::size_t i = begin; i < end; ++i) all.add(contacts[i], 1, center);
                std::size_t kept = 0;
                for (const ReducedContact& r : few) {
                    if (r.contact < begin || r.contact >= end) continue;
                    ++kept;
                    EXPECT_GT(r.weight, 0);
                    rest.add(contacts[r.contact], r.weight, center);
                }
                EXPECT_LE(kept, most);
                EXPECT_LT(length(all.force - rest.force), 1e-9 * all.size + 1e-15);
                EXPECT_LT(length(all.torque - rest.torque), 1e-8 * all.size + 1e-15);
                reduced_pairs += kept < end - begin;
            }
        }
    }
    EXPECT_GT(reduced_pairs, 100u);
    EXPECT_THROW(reduce({}, 5), InputError);
}

/// A sheet in a solid has contacts of the solid's inside and, after those of other pairs, contacts
/// of its surface.
TEST(ContactReductionTest, ASheetAndASolidAreOnePair) {
    World world;
    const BodyId ball = world.add_fixed_body(world.add_mesh("ball", scenes::sphere(1, 2)));
    const MeshData flat = scenes::grid(1, 1, 12, 12);
    const BodyId sheet = world.add_deforming_body(
        world.add_mesh("sheet", flat, {.inside = Inside::none}));
    world.set_collision(sheet, {.sheet = true, .thickness = 0.1});
    std::vector<Vec3f> lifted = flat.positions;
    for (Vec3f& p : lifted) p.z += 0.97f;
    world.set_positions(sheet, lifted);
    world.add_rigid_body(world.add_mesh("block", scenes::box({-1, -1, -2}, {1, 1, -0.9f})));
    world.detect();
    const auto contacts = world.contacts();
    std::size_t of_sheet = 0, of_solid = 0, kept = 0;
    const auto is_pair = [&](const Contact& c) { return c.a == ball && c.b == sheet; };
    for (const Contact& c : contacts)
        if (is_pair(c)) ++(c.of_sheet ? of_sheet : of_solid);
    ASSERT_GT(of_sheet, 6u);
    ASSERT_GT(of_solid, 6u);
    for (const ReducedContact& r : reduce(contacts, 6)) kept += is_pair(contacts[r.contact]);
    EXPECT_LE(kept, 6u);
    EXPECT_GT(kept, 0u);
}

}  // namespace
}  // namespace pierce
