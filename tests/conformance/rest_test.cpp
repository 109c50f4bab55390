// A step in which nothing has changed leaves contacts as they are, one step older.
#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

class RestTest : public testing::TestWithParam<test::NamedBackend> {};

/// Rigid and deforming bodies that overlap, in two worlds; one of these never rests, because a body
/// far away from all others moves in every step.
class Pile {
public:
    Pile(test::Random& random, const test::NamedBackend& backend, const Settings& settings)
        : resting(backend.make(), settings), awake(backend.make(), settings) {
        for (int i = 0; i < 8; ++i) {
            poses_.push_back({random.in_box(1.2), random.rotation()});
            bodies_.push_back(add(resting, i, poses_.back()));
            add(awake, i, poses_.back());
        }
        far_ = awake.add_rigid_body(awake.add_mesh("far", shape(0)), {{100, 0, 0}, {}});
    }

    /// Moves a body in both worlds.
    void move(std::uint32_t i, Vec3d way) {
        poses_[i].position += way;
        for (World* world : {&resting, &awake}) {
            const BodyId body = bodies_[i];  // both worlds count alike
            if (deforms(static_cast<int>(i)))
                world->set_positions(body, test::placed(shape(static_cast<int>(i)), poses_[i]));
            else
                world->set_pose(body, poses_[i]);
        }
    }
    /// Sets all poses as they are.
    void set_poses_again() {
        for (std::uint32_t i = 0; i < poses_.size(); ++i)
            if (!deforms(static_cast<int>(i))) resting.set_pose(bodies_[i], poses_[i]);
    }
    void step() {
        resting.detect();
        height_ += 0.1;
        awake.set_pose(far_, {{100, 0, height_}, {}});
        awake.detect();
    }

    World resting, awake;

private:
    static bool deforms(int i) { return i % 3 == 1; }
    static MeshData shape(int i) {
        return i % 2 == 0 ? scenes::box({-0.5, -0.4, -0.3}, {0.5, 0.4, 0.3})
                          : scenes::torus(0.5, 0.2, 10, 6);
    }
    static BodyId add(World& world, int i, const Pose& pose) {
        const MeshId mesh = world.add_mesh("mesh", shape(i));
        return deforms(i) ? world.add_deforming_body(mesh, test::placed(shape(i), pose))
                          : world.add_rigid_body(mesh, pose);
    }

    std::vector<Pose> poses_;
    std::vector<BodyId> bodies_;
    BodyId far_;
    double height_ = 0;
};

void expect_same(const Pile& pile) {
    const std::span<const Contact> one = pile.resting.contacts(), other = pile.awake.contacts();
    ASSERT_EQ(one.size(), other.size());
    EXPECT_GT(one.size(), 20u);
    EXPECT_EQ(contact_hash(one), contact_hash(other));
    for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i].age, other[i].age);
}

TEST_P(RestTest, ContactsGetOlder) {
    const Settings with_margin{.coverage = Coverage::complete, .margin = 0.1};
    for (const Settings& settings :
         {Settings{}, Settings{.temporal = Temporal::off}, Settings{.may_rest = false}, with_margin,
          Settings{.temporal = Temporal::paper}}) {
        test::Random random(7);
        SCOPED_TRACE("seed " + std::to_string(random.seed()));
        Pile pile(random, GetParam(), settings);
        const bool may_rest = settings.temporal != Temporal::paper &&
                              !GetParam().make()->runs_on_device();
        for (int round = 0; round < 3; ++round) {
            for (int step = 0; step < 6; ++step) {
                if (step == 3) pile.set_poses_again();
                pile.step();
                expect_same(pile);
                EXPECT_EQ(pile.resting.stats().at_rest, may_rest && step >= 2)
                    << "round " << round << ", step " << step;
                EXPECT_FALSE(pile.awake.stats().at_rest);
                EXPECT_EQ(pile.resting.stats().contacts, pile.resting.contacts().size());
            }
            for (std::uint32_t i = 0; i < 8; i += 1 + static_cast<std::uint32_t>(round))
                pile.move(i, random.in_box(0.02));
        }
    }
}

/// Contacts that are kept stay as they are through any later steps, and the world's end.
TEST_P(RestTest, KeptContactsStay) {
    for (const Settings& settings :
         {Settings{}, Settings{.temporal = Temporal::off}, Settings{.temporal = Temporal::paper}}) {
        test::Random random(11);
        SCOPED_TRACE("seed " + std::to_string(random.seed()));
        std::vector<KeptContacts> kept;
        std::vector<std::vector<Contact>> copies;
        {
            Pile pile(random, GetParam(), settings);
            for (int step = 0; step < 12; ++step) {
                // Kept twice, once, or not at all; steps with motion and at rest.
                if (step % 5 != 3) pile.move(static_cast<std::uint32_t>(step % 8), {0.01, 0, 0});
                if (step % 5 == 3) pile.step();
                pile.step();
                if (step % 4 == 2) continue;
                for (int k = 0; k < 1 + step % 2; ++k) {
                    kept.push_back(pile.resting.keep_contacts());
                    copies.emplace_back(pile.resting.contacts().begin(),
                                        pile.resting.contacts().end());
                    EXPECT_EQ(kept.back().count, copies.back().size());
                }
                if (step % 4 == 1) {
                    kept.erase(kept.begin());
                    copies.erase(copies.begin());
                }
            }
        }
        for (std::size_t k = 0; k < kept.size(); ++k) {
            EXPECT_GT(kept[k].count, 20u);
            EXPECT_EQ(contact_hash(kept[k].all()), contact_hash(copies[k]));
            for (std::size_t i = 0; i < copies[k].size(); ++i)
                ASSERT_EQ(kept[k].all()[i].age, copies[k][i].age);
        }
    }
}

/// What asks for the plan between a change and the next step does not make the change unseen.
TEST_P(RestTest, ChangesAreSeenThoughThePlanWasAskedFor) {
    for (int change = 0; change < 4; ++change) {
        SCOPED_TRACE(change);
        World world(GetParam().make());
        const MeshId mesh = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
        const BodyId low = world.add_rigid_body(mesh),
                     high = world.add_rigid_body(mesh, {{0.2, 0.1, 0.9}, {}});
        for (int step = 0; step < 3; ++step) world.detect();
        ASSERT_FALSE(world.contacts().empty());
        if (change == 0 || change == 3) world.remove_body(high);
        if (change == 3) world.remove_body(low);
        if (change == 1) world.exclude(low, high);
        if (change == 2) world.set_filter(low, {.meets = 0});
        world.plan();
        world.detect();
        EXPECT_TRUE(world.contacts().empty());
        EXPECT_EQ(world.stats().pairs, 0u);
    }
}

/// Where all bodies moved, memory rests; it must not where few move later.
TEST(MemoryTest, IsTakenUpAgainWhereFewBodiesMove) {
    test::Random random(3);
    World world;
    const MeshId mesh = world.add_mesh("torus", scenes::torus(0.5, 0.2, 10, 6));
    std::vector<BodyId> bodies;
    std::vector<Pose> poses;
    for (int i = 0; i < 20; ++i) {
        poses.push_back({random.in_box(1.5), random.rotation()});
        bodies.push_back(world.add_rigid_body(mesh, poses.back()));
    }
    const auto move = [&](std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            poses[i].position += random.in_box(0.4);
            world.set_pose(bodies[i], poses[i]);
        }
        return world.detect().rested;
    };
    std::uint32_t rested = 0;
    for (int step = 0; step < 10; ++step) rested += move(20);
    EXPECT_GT(rested, 0u);
    ASSERT_EQ(world.stats().rested, 1u);
    for (int step = 0; step < 10; ++step) EXPECT_EQ(move(2), 0u);
}

INSTANTIATE_TEST_SUITE_P(Backends, RestTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
