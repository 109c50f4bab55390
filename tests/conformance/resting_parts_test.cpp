// Where most bodies are at rest, they become a part that does not run: contacts, ages and all else
// are those of one backend, whichever bodies wake and fall asleep.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/partition/resting_backend.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/trace/ray.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/explain.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/counting_backend.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

struct Case {
    Settings settings;
    bool soft;  ///< some bodies deform
    const char* name;
};

void PrintTo(const Case& tested, std::ostream* os) { *os << tested.name; }

class RestingPartsTest : public testing::TestWithParam<Case> {};

std::unique_ptr<Backend> with_parts(test::Calls& calls) {
    const auto make = [&calls] {
        return std::make_unique<test::CountingBackend>(embree_backend(1), calls);
    };
    return resting_backend(make, {.bodies = 8, .steps = 2, .patience = 1, .most_patience = 1});
}

/// The same bodies in two worlds, in layers on a floor.
class Pile {
public:
    static constexpr int bodies = 30;

    Pile(const Case& tested, test::Random& random)
        : one(bvh_backend(), tested.settings), parts(with_parts(calls), tested.settings) {
        for (World* world : {&one, &parts})
            world->add_fixed_body(world->add_mesh("floor", scenes::box({-9, -9, -1}, {9, 9, 0})));
        for (int b = 0; b < bodies; ++b) {
            poses_.push_back(
                {{1.5 * (b % 5), 1.5 * (b / 5 % 3), 0.5 + 0.7 * (b / 15)}, random.rotation()});
            for (World* world : {&one, &parts}) {
                const MeshId ring = world->add_mesh("ring", ring_);
                const BodyId id = tested.soft && b % 3 == 0 ? world->add_deforming_body(ring)
                                                            : world->add_rigid_body(ring);
                if (world == &one) ids_.push_back(id);  // both worlds count alike
            }
            put(b);
        }
    }
    void move(int b, Vec3d way) {
        poses_[static_cast<std::size_t>(b)].position += way;
        put(b);
    }
    void detect() {
        one.detect();
        parts.detect();
    }
    BodyId id(int b) const { return ids_[static_cast<std::size_t>(b)]; }

    test::Calls calls;  ///< of the parts
    World one, parts;

private:
    void put(int b) {
        const Pose& pose = poses_[static_cast<std::size_t>(b)];
        for (World* world : {&one, &parts})
            if (world->motion_of(id(b)) == Motion::deforming)
                world->set_positions(id(b), test::placed(ring_, pose));
            else
                world->set_pose(id(b), pose);
    }

    MeshData ring_ = scenes::torus(0.8, 0.3, 12, 7);
    std::vector<Pose> poses_;
    std::vector<BodyId> ids_;
};

void expect_same(const Pile& pile, const std::string& where) {
    const auto one = pile.one.contacts(), parts = pile.parts.contacts();
    ASSERT_EQ(parts.size(), one.size()) << where;
    ASSERT_EQ(contact_hash(parts), contact_hash(one)) << where;
    for (std::size_t c = 0; c < one.size(); ++c) {
        ASSERT_EQ(parts[c].age, one[c].age) << where;
        ASSERT_EQ(parts[c].found, one[c].found) << where;
    }
    const StepStats &of_one = pile.one.stats(), &of_parts = pile.parts.stats();
    EXPECT_EQ(of_parts.pairs, of_one.pairs) << where;
    EXPECT_EQ(of_parts.contacts, of_one.contacts) << where;
    EXPECT_EQ(of_parts.touching_pairs, of_one.touching_pairs) << where;
    EXPECT_EQ(of_parts.penetration_max, of_one.penetration_max) << where;
    EXPECT_NEAR(of_parts.penetration_mean, of_one.penetration_mean, 1e-12) << where;
}

TEST_P(RestingPartsTest, FindWhatOneBackendFinds) {
    test::Random random(41);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    Pile pile(GetParam(), random);
    std::size_t contacts = 0;
    for (int step = 0; step < 160; ++step) {
        // Long times in which few bodies move, others wake one by one, all move, or none does.
        const int phase = step / 10 % 8;
        for (int b = 0; b < Pile::bodies; ++b) {
            const bool moves = phase == 5   ? random.integer(0, 3) == 0
                               : phase == 3 ? false
                               : phase == 6 ? b == step % Pile::bodies
                                            : b % 13 == phase;
            if (moves) pile.move(b, random.in_box(0.05));
        }
        if (step == 75)  // a plan of other pairs
            for (World* world : {&pile.one, &pile.parts}) world->exclude(pile.id(1), pile.id(2));
        if (step == 115) {  // goes on from what was saved
            std::stringstream saved(std::ios::in | std::ios::out | std::ios::binary);
            pile.parts.save(saved);
            pile.parts = World::restore(saved, with_parts(pile.calls));
        }
        pile.detect();
        // Contacts become older in steps after which nobody asks for them, too.
        if (step % 7 != 3) expect_same(pile, "step " + std::to_string(step));
        // A world that was just restored does not know that nothing has changed.
        if (step < 115 || step > 116) {
            EXPECT_EQ(pile.parts.stats().at_rest, pile.one.stats().at_rest) << step;
        }
        contacts += pile.one.contacts().size();
    }
    EXPECT_GT(contacts, 3000u);
    if (GetParam().settings.temporal == Temporal::paper) {
        EXPECT_EQ(pile.calls.backends, 2) << "the plan lets nothing rest";
    } else {
        EXPECT_GT(pile.calls.rests, 60);
    }
}

TEST_P(RestingPartsTest, AnswerQuestionsAsOneBackendDoes) {
    if (GetParam().settings.temporal == Temporal::paper) GTEST_SKIP() << "nothing rests";
    test::Random random(43);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    Pile pile(GetParam(), random);
    for (int step = 0; step < 12; ++step) {
        pile.move(4, {0.01, 0, 0});
        pile.detect();
    }
    ASSERT_GT(pile.calls.rests, 3);
    EXPECT_TRUE(pile.parts.plan().parts.empty());
    EXPECT_TRUE(pile.parts.stats().part_milliseconds.empty());
    const auto boxes = pile.one.body_boxes(), of_parts = pile.parts.body_boxes();
    ASSERT_EQ(of_parts.size(), boxes.size());
    for (std::size_t b = 0; b < boxes.size(); ++b) {
        EXPECT_EQ(of_parts[b].body, boxes[b].body);
        EXPECT_EQ(of_parts[b].box.lower, boxes[b].box.lower);
        EXPECT_EQ(of_parts[b].box.upper, boxes[b].box.upper);
    }
    const KeptContacts kept = pile.parts.keep_contacts();
    EXPECT_EQ(contact_hash(kept.all()), contact_hash(pile.one.contacts()));
    const Contact& c = pile.one.contacts().back();
    const auto way = pile.one.parting(c.a, c.b), its_way = pile.parts.parting(c.a, c.b);
    ASSERT_TRUE(way && its_way);
    EXPECT_EQ(its_way->translation(), way->translation());
}

// There may be too little memory for a second backend.
TEST(RestingPartsMemoryTest, AStepThatCannotMakePartsIsForgotten) {
    int made = 0;
    const auto make = [&made] {
        if (++made == 2) throw std::bad_alloc();
        return bvh_backend();
    };
    World world(
        resting_backend(make, {.bodies = 8, .steps = 2, .patience = 1, .most_patience = 1}));
    const MeshId box = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    std::vector<BodyId> bodies;
    for (int b = 0; b < 12; ++b) bodies.push_back(world.add_rigid_body(box, {{0.9 * b, 0, 0}, {}}));
    auto step = [&, z = 0.0]() mutable {
        world.set_pose(bodies[3], {{2.7, 0, z += 0.01}, {}});
        world.detect();
    };
    bool has_failed = false;
    for (int k = 0; k < 20; ++k) {
        try {
            step();
        } catch (const std::bad_alloc&) {
            has_failed = true;
            EXPECT_TRUE(world.contacts().empty());
            world.detect();
            EXPECT_FALSE(world.contacts().empty());
            for (const Contact& c : world.contacts()) EXPECT_EQ(c.age, 0u);
        }
    }
    EXPECT_TRUE(has_failed);
    EXPECT_GT(made, 2);
}

INSTANTIATE_TEST_SUITE_P(
    Piles, RestingPartsTest,
    testing::Values(Case{{}, false, "rigid"}, Case{{}, true, "soft"},
                    Case{{.temporal = Temporal::off}, true, "off"},
                    Case{{.coverage = Coverage::vertices, .reproject = false}, true, "vertices"},
                    Case{{.margin = 0.1}, true, "margin"},
                    Case{{.temporal = Temporal::paper}, true, "paper"}),
    [](const testing::TestParamInfo<Case>& tested) { return tested.param.name; });

}  // namespace
}  // namespace pierce
