// Filters leave out pairs and change nothing else; each of many worlds finds what it finds alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/explain.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

class FiltersTest : public testing::TestWithParam<test::NamedBackend> {};

/// A crowd of bodies that overlap, some of which deform; the first one is fixed.
struct Crowd {
    std::vector<MeshData> meshes;
    std::vector<Pose> poses;

    explicit Crowd(test::Random& random, int count, double spread = 1.2) {
        for (int i = 0; i < count; ++i) {
            meshes.push_back(i % 2 == 0 ? scenes::box({-0.5, -0.4, -0.3}, {0.5, 0.4, 0.3})
                                        : scenes::torus(0.5, 0.2, 10, 6));
            poses.push_back({random.in_box(spread), random.rotation()});
        }
    }
    std::vector<BodyId> add_to(World& world) const {
        std::vector<BodyId> bodies;
        for (std::size_t i = 0; i < meshes.size(); ++i) {
            const MeshId mesh = world.add_mesh("mesh " + std::to_string(i), meshes[i]);
            bodies.push_back(i == 0 ? world.add_fixed_body(mesh, poses[i])
                             : i % 3 == 1
                                 ? world.add_deforming_body(mesh, test::placed(meshes[i], poses[i]))
                                 : world.add_rigid_body(mesh, poses[i]));
        }
        return bodies;
    }
    /// Moves all bodies but the first one by a step.
    void move(test::Random& random) {
        for (std::size_t i = 1; i < poses.size(); ++i) poses[i].position += random.in_box(0.03);
    }
    void place(World& world, const std::vector<BodyId>& bodies) const {
        for (std::size_t i = 1; i < bodies.size(); ++i)
            if (world.motion_of(bodies[i]) == Motion::deforming)
                world.set_positions(bodies[i], test::placed(meshes[i], poses[i]));
            else
                world.set_pose(bodies[i], poses[i]);
    }
};

bool is_there(const World& world, BodyId body) {
    try {
        (void)world.filter_of(body);
        return true;
    } catch (const InputError&) {
        return false;
    }
}

TEST(BodiesOfTest, AreThoseOfTheWorldAfterAnyChange) {
    test::Random random(12);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    World world;
    const MeshId mesh = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    std::vector<BodyId> all;
    const auto any_world = [&] { return random.integer(0, 4) - 1; };
    for (int i = 0; i < 300; ++i) {
        const int what = random.integer(0, 9);
        if (what < 4 || all.empty()) {
            all.push_back(world.add_rigid_body(mesh));
        } else if (what < 7) {
            const auto which = static_cast<std::size_t>(
                random.integer(0, static_cast<int>(all.size()) - 1));
            world.set_filter(all[which], {.world = any_world()});
        } else if (what < 9) {
            const auto which = random.integer(0, static_cast<int>(all.size()) - 1);
            world.remove_body(all[static_cast<std::size_t>(which)]);
            all.erase(all.begin() + which);
        } else {
            world.remove_world(2);
            std::erase_if(all, [&](BodyId body) { return !is_there(world, body); });
        }
        for (std::int32_t w = -1; w < 5; ++w) {
            std::vector<BodyId> expected;
            for (const BodyId body : all)
                if (world.filter_of(body).world == w) expected.push_back(body);
            std::ranges::sort(expected);
            ASSERT_EQ(world.bodies_of(w), expected) << i;
        }
    }
}

TEST_P(FiltersTest, OnlyUnwantedPairsAreLeftOut) {
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        test::Random random(seed);
        SCOPED_TRACE("seed " + std::to_string(random.seed()));
        Crowd crowd(random, 14);
        World all(GetParam().make()), filtered(GetParam().make());
        const std::vector<BodyId> in_all = crowd.add_to(all), bodies = crowd.add_to(filtered);
        std::vector<Filter> filters;
        for (BodyId body : bodies) {
            filters.push_back({.groups = 1u << random.integer(0, 2),
                               .meets = static_cast<std::uint32_t>(random.integer(1, 7)),
                               .chain = static_cast<std::uint32_t>(random.integer(0, 3)),
                               .world = all_worlds});
            filtered.set_filter(body, filters.back());
            EXPECT_EQ(filtered.filter_of(body), filters.back());
        }
        filtered.exclude(bodies[2], bodies[5]);
        filtered.exclude(bodies[9], bodies[1]);
        const auto is_wanted = [&](const Contact& c) {
            const std::pair<std::uint32_t, std::uint32_t> pair(c.a.index, c.b.index);
            return pair != std::pair(2u, 5u) && pair != std::pair(1u, 9u) &&
                   filters[pair.first].allows(filters[pair.second]);
        };
        for (int step = 0; step < 4; ++step) {
            all.detect();
            filtered.detect();
            std::vector<Contact> wanted;
            std::ranges::copy_if(all.contacts(), std::back_inserter(wanted), is_wanted);
            EXPECT_LT(wanted.size(), all.contacts().size());
            EXPECT_GT(wanted.size(), 20u);
            EXPECT_EQ(contact_hash(filtered.contacts()), contact_hash(wanted)) << "step " << step;
            crowd.move(random);
            crowd.place(all, in_all);
            crowd.place(filtered, bodies);
        }
        EXPECT_EQ(filtered.plan().excluded_pairs, 2u);
    }
}

TEST_P(FiltersTest, ThePairFilterLeavesOutWhatExcludeDoes) {
    if (GetParam().make()->runs_on_device()) {
        World world(GetParam().make());
        EXPECT_THROW(world.set_pair_filter([](BodyId, BodyId) { return true; }), InputError);
        return;
    }
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        test::Random random(seed);
        SCOPED_TRACE("seed " + std::to_string(random.seed()));
        Crowd crowd(random, 12);
        World asked(GetParam().make()), excluded(GetParam().make());
        const std::vector<BodyId> bodies = crowd.add_to(asked), same = crowd.add_to(excluded);
        const auto is_wanted = [](std::uint32_t a, std::uint32_t b) { return (a + b) % 3 != 0; };
        std::atomic<int> calls = 0, wrong = 0;
        asked.set_pair_filter([&](BodyId a, BodyId b) {
            ++calls;
            wrong += !(a < b);
            return is_wanted(a.index, b.index);
        });
        for (std::size_t a = 0; a < same.size(); ++a)
            for (std::size_t b = a + 1; b < same.size(); ++b)
                if (!is_wanted(same[a].index, same[b].index)) excluded.exclude(same[a], same[b]);
        for (int step = 0; step < 4; ++step) {
            calls = 0;
            asked.detect();
            EXPECT_GT(calls, static_cast<int>(asked.stats().pairs));
            EXPECT_EQ(asked.stats().pairs, excluded.detect().pairs);
            EXPECT_GT(asked.contacts().size(), 20u);
            EXPECT_EQ(contact_hash(asked.contacts()), contact_hash(excluded.contacts()));
            crowd.move(random);
            crowd.place(asked, bodies);
            crowd.place(excluded, same);
        }
        EXPECT_EQ(wrong, 0);
        asked.detect();
        EXPECT_EQ(asked.explain(bodies[1], bodies[2], 0).reason, Reason::filtered);
        asked.set_pair_filter({});
        asked.detect();
        EXPECT_NE(asked.explain(bodies[1], bodies[2], 0).reason, Reason::filtered);
    }
}

TEST_P(FiltersTest, PairsAreTakenInAgain) {
    const MeshData box = scenes::box({-1, -1, -1}, {1, 1, 1});
    World world(GetParam().make());
    const MeshId mesh = world.add_mesh("box", box);
    const BodyId a = world.add_rigid_body(mesh),
                 b = world.add_rigid_body(mesh, {{1.5, 0.1, 0.2}, {}});
    const auto contacts = [&] {
        world.detect();
        return world.contacts().size();
    };
    EXPECT_GT(contacts(), 0u);
    world.exclude(b, a);
    EXPECT_EQ(contacts(), 0u);
    EXPECT_EQ(world.explain(a, b, 0).reason, Reason::filtered);
    world.exclude(a, b);
    world.include(a, b);
    EXPECT_GT(contacts(), 0u);
    world.set_filter(a, {.groups = 1, .meets = 2});
    EXPECT_EQ(contacts(), 0u);
    world.set_filter(b, {.groups = 2, .meets = 4});
    EXPECT_EQ(contacts(), 0u) << "each has to meet the other's groups";
    world.set_filter(b, {.groups = 2, .meets = 1});
    EXPECT_GT(contacts(), 0u);
    world.set_filter(a, {.chain = 7});
    world.set_filter(b, {.chain = 7});
    EXPECT_EQ(contacts(), 0u);
    world.set_filter(b, {.chain = 8});
    EXPECT_GT(contacts(), 0u);

    world.exclude(a, b);
    std::stringstream file;
    world.save(file);
    World restored = World::restore(file, GetParam().make());
    restored.detect();
    EXPECT_TRUE(restored.contacts().empty());
    EXPECT_EQ(restored.filter_of(b).chain, 8u);
    // A removed body takes its exclusions with it.
    restored.remove_body(b);
    restored.add_rigid_body(restored.mesh_of(a), {{1.5, 0.1, 0.2}, {}});
    restored.detect();
    EXPECT_GT(restored.contacts().size(), 0u);
    EXPECT_EQ(restored.plan().excluded_pairs, 0u);

    EXPECT_THROW(world.exclude(a, a), InputError);
    EXPECT_THROW(world.set_filter(a, {.world = -2}), InputError);
    EXPECT_THROW(world.set_filter(a, {.world = 1 << 20}), InputError);
}

TEST_P(FiltersTest, SheetsFollowThem) {
    const MeshData plane = scenes::grid(2, 2, 6, 6);
    World world(GetParam().make());
    const MeshId mesh = world.add_mesh("plane", plane);
    std::vector<BodyId> sheets;
    for (int k = 0; k < 3; ++k) {
        sheets.push_back(world.add_deforming_body(mesh));
        world.set_collision(sheets.back(), {.sheet = true, .thickness = 0.1});
        world.set_motion(sheets.back(), test::placed(plane, {{0, 0, 0.02 * k}, {}}),
                         test::placed(plane, {{0, 0, 0.02 * k}, {}}));
    }
    world.detect();
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> pairs;
    for (const Contact& c : world.contacts()) ++pairs[{c.a.index, c.b.index}];
    EXPECT_EQ(pairs.size(), 3u);
    world.exclude(sheets[0], sheets[1]);
    world.detect();
    pairs.clear();
    for (const Contact& c : world.contacts()) ++pairs[{c.a.index, c.b.index}];
    EXPECT_EQ(pairs.size(), 2u);
    EXPECT_EQ(pairs.count({0u, 1u}), 0u);
}

/// Contacts with bodies named by their places in a list.
std::uint64_t hash_among(std::span<const Contact> contacts, const std::vector<BodyId>& bodies) {
    std::vector<Contact> named(contacts.begin(), contacts.end());
    for (Contact& c : named)
        for (BodyId* id : {&c.a, &c.b}) {
            const auto at = std::ranges::find(bodies, *id);
            EXPECT_NE(at, bodies.end()) << "a body of another world";
            *id = {static_cast<std::uint32_t>(at - bodies.begin()), 1};
        }
    return contact_hash(named);
}

TEST_P(FiltersTest, EachWorldFindsWhatItFindsAlone) {
    test::Random random(5);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const Crowd ground(random, 2, 0.3);
    // Worlds of different bodies, whose numbers are neither sorted nor without gaps.
    const std::vector<std::int32_t> numbers{7, 0, 12, 3};
    std::vector<Crowd> crowds;
    for (std::size_t w = 0; w < numbers.size(); ++w)
        crowds.emplace_back(random, 4 + static_cast<int>(w));

    World world(GetParam().make());
    std::vector<std::unique_ptr<World>> alone;
    std::vector<std::vector<BodyId>> bodies, bodies_alone, here, here_alone;
    // The ground has lower handles than the bodies of some worlds, and higher ones than others.
    constexpr std::size_t before_ground = 2;
    std::vector<BodyId> shared;
    std::vector<std::vector<BodyId>> shared_alone;
    for (std::size_t w = 0; w < numbers.size(); ++w) {
        if (w == before_ground) shared = ground.add_to(world);
        bodies.push_back(crowds[w].add_to(world));
        for (BodyId body : bodies.back()) world.set_filter(body, {.world = numbers[w]});
        alone.push_back(std::make_unique<World>(GetParam().make()));
        if (w >= before_ground) shared_alone.push_back(ground.add_to(*alone.back()));
        bodies_alone.push_back(crowds[w].add_to(*alone.back()));
        if (w < before_ground) shared_alone.push_back(ground.add_to(*alone.back()));
    }
    const auto both = [](std::vector<BodyId> first, const std::vector<BodyId>& second) {
        first.insert(first.end(), second.begin(), second.end());
        return first;
    };
    for (std::size_t w = 0; w < numbers.size(); ++w) {
        here.push_back(both(shared, bodies[w]));
        here_alone.push_back(both(shared_alone[w], bodies_alone[w]));
    }
    for (int step = 0; step < 5; ++step) {
        world.detect();
        const WorldOffsets offsets = world.world_offsets();
        ASSERT_EQ(offsets.worlds, (std::vector<std::int32_t>{0, 3, 7, 12}));
        for (std::size_t w = 0; w < numbers.size(); ++w) {
            alone[w]->detect();
            // Alone, contacts between shared bodies are among the world's own.
            std::vector<Contact> expected;
            std::ranges::copy_if(alone[w]->contacts(), std::back_inserter(expected),
                                 [&](const Contact& c) {
                                     return std::ranges::count(shared_alone[w], c.a) == 0 ||
                                            std::ranges::count(shared_alone[w], c.b) == 0;
                                 });
            const auto place = static_cast<std::size_t>(
                std::ranges::find(offsets.worlds, numbers[w]) - offsets.worlds.begin());
            const auto found = world.contacts().subspan(
                offsets.solids[place], offsets.solids[place + 1] - offsets.solids[place]);
            EXPECT_GT(found.size(), 5u);
            EXPECT_EQ(hash_among(found, here[w]), hash_among(expected, here_alone[w]))
                << "world " << numbers[w] << ", step " << step;
            crowds[w].move(random);
            crowds[w].place(world, bodies[w]);
            crowds[w].place(*alone[w], bodies_alone[w]);
        }
    }
}

TEST_P(FiltersTest, ReplicatedWorldsFindTheSame) {
    test::Random random(9);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    Crowd crowd(random, 5);
    World world(GetParam().make());
    const MeshId box = world.add_mesh("ground", scenes::box({-3, -3, -3}, {3, 3, -0.5}));
    const BodyId ground = world.add_fixed_body(box);
    const std::vector<BodyId> first = crowd.add_to(world);
    for (BodyId body : first) world.set_filter(body, {.world = 4});
    world.exclude(first[1], first[2]);
    world.exclude(ground, first[3]);
    EXPECT_EQ(world.replicate(4, 6), 5);
    EXPECT_EQ(world.worlds(), (std::vector<std::int32_t>{4, 5, 6, 7, 8, 9, 10}));
    EXPECT_EQ(world.plan().excluded_pairs, 14u);
    world.detect();
    WorldOffsets offsets = world.world_offsets();
    const auto hash_of = [&](std::size_t place) {
        std::vector<BodyId> bodies = world.bodies_of(offsets.worlds[place]);
        bodies.insert(bodies.begin(), ground);
        return hash_among(
            world.contacts().subspan(offsets.solids[place],
                                     offsets.solids[place + 1] - offsets.solids[place]),
            bodies);
    };
    const std::uint64_t expected = hash_of(0);
    EXPECT_GT(offsets.solids[1], 10u);
    for (std::size_t place = 1; place < offsets.worlds.size(); ++place)
        EXPECT_EQ(hash_of(place), expected);

    // One world goes its own way, and is put back.
    crowd.move(random);
    crowd.place(world, world.bodies_of(8));
    world.detect();
    offsets = world.world_offsets();
    EXPECT_NE(hash_of(4), hash_of(0));
    world.copy_places(4, 8);
    world.set_world_active(6, false);
    world.detect();
    offsets = world.world_offsets();
    EXPECT_EQ(offsets.solids[2], offsets.solids[3]) << "left out";
    const std::size_t contacts = world.contacts().size();
    world.set_world_active(6, true);
    world.remove_world(10);
    EXPECT_THROW(world.remove_world(all_worlds), InputError);
    world.detect();
    offsets = world.world_offsets();
    EXPECT_EQ(offsets.worlds.size(), 6u);
    EXPECT_EQ(world.contacts().size(), contacts);

    std::stringstream file;
    world.save(file);
    World restored = World::restore(file, GetParam().make());
    world.detect();
    restored.detect();
    EXPECT_EQ(contact_hash(world.contacts()), contact_hash(restored.contacts()));
    EXPECT_EQ(restored.world_offsets().solids, world.world_offsets().solids);

    EXPECT_THROW(world.replicate(99, 1), InputError);
    EXPECT_THROW(world.replicate(all_worlds, 1), InputError);
    EXPECT_THROW(world.replicate(4, 1u << 20), InputError) << "too many worlds";
    EXPECT_THROW(world.replicate(4, 900'000), InputError) << "too many bodies";
    EXPECT_EQ(world.worlds().size(), 6u);
    EXPECT_THROW(world.copy_places(4, 99), InputError);
    EXPECT_THROW(world.set_world_active(99, false), InputError);
}

/// Contacts of a sheet that looks for itself along velocities stand among those of solids.
TEST_P(FiltersTest, WorldsWithRaysOfSheets) {
    World world(GetParam().make());
    const MeshData flat = scenes::grid(1, 1, 6, 6);
    MeshData lifted = flat;
    for (Vec3f& p : lifted.positions) p.z += 0.2f;
    const MeshData layers = scenes::joined(flat, lifted);
    const BodyId sheet = world.add_deforming_body(
        world.add_mesh("layers", layers, {.inside = Inside::none}));
    world.set_collision(sheet, {SelfCollision::rays, true, 0.01});
    const MeshId box = world.add_mesh("box", scenes::box({4, 4, 4}, {5, 5, 5}));
    const std::vector<BodyId> boxes{world.add_rigid_body(box),
                                    world.add_rigid_body(box, {{0.9, 0.1, 0.1}, {}})};
    for (BodyId body : {sheet, boxes[0], boxes[1]}) world.set_filter(body, {.world = 0});
    world.replicate(0, 2);
    std::vector<Vec3f> crossed = layers.positions;
    for (std::size_t v = 0; v < crossed.size(); ++v)
        crossed[v].z += v < flat.positions.size() ? 0.15f : -0.15f;
    for (const std::int32_t w : world.worlds())
        world.set_motion(world.bodies_of(w)[0], layers.positions, crossed);
    world.detect();
    const WorldOffsets offsets = world.world_offsets();
    const auto contacts = world.contacts();
    ASSERT_EQ(offsets.solids.size(), 4u);
    std::size_t of_rays = 0;
    for (std::size_t w = 0; w < 3; ++w) {
        const std::vector<BodyId> bodies = world.bodies_of(offsets.worlds[w]);
        std::size_t of_boxes = 0;
        for (std::uint32_t i = offsets.solids[w]; i < offsets.solids[w + 1]; ++i) {
            EXPECT_TRUE(std::ranges::find(bodies, contacts[i].a) != bodies.end()) << i;
            of_rays += contacts[i].of_sheet;
            of_boxes += !contacts[i].of_sheet;
        }
        EXPECT_GT(of_boxes, 0u);
        for (std::uint32_t v = 0; v < 8; ++v) {
            const bool is_there = std::ranges::any_of(contacts, [&](const Contact& c) {
                return c.a == bodies[1] && c.source == Side::a && c.vertex == v && !c.is_edge();
            });
            EXPECT_EQ(world.explain(bodies[1], bodies[2], v).reason == Reason::contact, is_there);
        }
    }
    EXPECT_GT(of_rays, 0u);
}

TEST_P(FiltersTest, ManyPosesAreSetAtOnce) {
    World world(GetParam().make());
    const MeshId mesh = world.add_mesh("box", scenes::box({-1, -1, -1}, {1, 1, 1}));
    const std::vector<BodyId> bodies{world.add_rigid_body(mesh), world.add_rigid_body(mesh)};
    const std::vector<double> doubles{0, 0, 0, 0, 0, 0, 1, 1.5, 0, 0.25, 0, 0, 0, 1};
    const std::vector<float> floats(doubles.begin(), doubles.end());
    const std::vector<Pose> poses{{}, {{1.5, 0, 0.25}, {}}};
    for (int way = 0; way < 3; ++way) {
        if (way == 0) world.set_poses(bodies, poses);
        if (way == 1) world.set_poses(bodies, doubles);
        if (way == 2) world.set_poses(bodies, floats);
        EXPECT_EQ(world.vertex_position(bodies[1], 0), (Vec3d{0.5, -1, -0.75}));
        world.set_pose(bodies[1], {{9, 9, 9}, {}});
    }
    EXPECT_THROW(world.set_poses(bodies, std::span(poses).first(1)), InputError);
    EXPECT_THROW(world.set_poses(bodies, std::span(doubles).first(13)), InputError);
    EXPECT_THROW(world.set_poses(bodies, std::span(floats).first(7)), InputError);
    const BodyId soft = world.add_deforming_body(mesh);
    EXPECT_THROW(world.set_poses(std::vector{bodies[0], soft}, poses), InputError);
    EXPECT_EQ(world.vertex_position(bodies[0], 0), (Vec3d{-1, -1, -1}));
}

/// Whatever the numbers of bodies: those of the first two fit both ways of writing pairs.
TEST_P(FiltersTest, ContactsBeginANewAgeWhenTheFirstBodyGetsAWorld) {
    for (const int before : {0, 1}) {
        World world(GetParam().make());
        const MeshId box = world.add_mesh("box", scenes::box({-1, -1, -1}, {1, 1, 1}));
        for (int k = 0; k < before; ++k) world.add_rigid_body(box, {{50, 0, 0}, {}});
        const BodyId a = world.add_fixed_body(box), b = world.add_rigid_body(box);
        const auto age_after_move = [&](double by) {
            world.set_pose(b, {{0.1 + by, 0.2, 1.9}, {}});
            world.detect();
            EXPECT_FALSE(world.contacts().empty());
            return world.contacts()[0].age;
        };
        for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(age_after_move(0.001 * i), i);
        world.set_filter(a, {.world = 0});
        world.set_filter(b, {.world = 0});
        EXPECT_EQ(age_after_move(0.01), 0u) << before;
        EXPECT_EQ(age_after_move(0.011), 1u) << before;
        world.set_filter(a, {});
        world.set_filter(b, {});
        EXPECT_EQ(age_after_move(0.012), 0u) << before;
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, FiltersTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
