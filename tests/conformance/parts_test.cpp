// Bodies that move through the parts of a world, so that they change owners: contacts, ages and all
// else are those of one backend.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/plan.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/step_stats.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/device_backend.hpp"
#include "support/failing_backend.hpp"

namespace pierce {
namespace {

/// Of four parts, the third one is shared by three others.
std::unique_ptr<Backend> parts(int count) {
    std::vector<Part> all;
    for (int k = 0; k < count; ++k) {
        std::unique_ptr<Backend> one = k % 2 ? embree_backend(1) : bvh_backend();
        if (count == 4 && k == 2) one = parts(3);
        all.push_back({.backend = std::move(one), .share = 1.0 + k});
    }
    return partitioned_backend(std::move(all));
}

std::unique_ptr<Backend> device_and_host() {
    std::vector<std::unique_ptr<Backend>> devices;
    devices.push_back(std::make_unique<test::DeviceBackend>());
    return partitioned_backend(std::move(devices), embree_backend(1), 0.4);
}

enum class Kind { rigid, soft, mixed, sheets };

struct Case {
    Kind kind;
    Settings settings;
    const char* name;
};

void PrintTo(const Case& tested, std::ostream* os) { *os << tested.name; }

/// Two swarms that fly through each other, over a floor.
class Swarms {
public:
    Swarms(std::unique_ptr<Backend> backend, const Case& tested)
        : world(std::move(backend), tested.settings), kind_(tested.kind) {
        const MeshId ring = world.add_mesh("ring", ring_),
                     floor = world.add_mesh("floor", scenes::box({-40, -40, -1}, {40, 40, 0}));
        world.add_fixed_body(floor, {{0, 0, -1.2}, {}});
        for (int b = 0; b < bodies; ++b) {
            const bool soft = kind_ == Kind::soft || kind_ == Kind::sheets ||
                              (kind_ == Kind::mixed && b % 2 == 1);
            ids_.push_back(soft ? world.add_deforming_body(ring) : world.add_rigid_body(ring));
            if (kind_ == Kind::sheets && b % 8 == 0)
                world.set_collision(ids_.back(), {.sheet = true, .thickness = 0.05});
        }
    }

    void put(int step) {
        for (int b = 0; b < bodies; ++b) {
            // Every now and then a body is at rest.
            if (step > 0 && (b + step / 8) % 5 == 0) continue;
            const double side = b % 2 == 0 ? 1 : -1, t = 0.25 * step;
            const Pose pose{{side * (7 - t) + 1.1 * (b / 6), 1.3 * (b % 6) - 3, 0.2 * (b % 3)},
                            turned(0.1 * step + b)};
            if (world.motion_of(ids_[b]) == Motion::deforming)
                world.set_positions(ids_[b], bent(pose, step + b));
            else
                world.set_pose(ids_[b], pose);
        }
        if (step % 17 == 9) {  // one goes, another one comes
            world.remove_body(ids_[5]);
            ids_[5] = world.add_deforming_body(world.add_mesh("ring", ring_),
                                               bent({{0, 0.5, 0}, {}}, step));
        }
    }

    World world;

private:
    static constexpr int bodies = 24;

    static Quaternion turned(double angle) {
        return {0.3 * std::sin(angle), 0.2 * std::cos(angle), 0.1, 0.9};
    }
    std::vector<Vec3f> bent(const Pose& pose, double phase) const {
        std::vector<Vec3f> positions;
        for (const Vec3f p : ring_.positions) {
            Vec3d q = to_double(p);
            q.z *= 1 + 0.1 * std::sin(0.7 * phase + q.x);
            positions.push_back(to_float(frame_of(pose).to_parent(q)));
        }
        return positions;
    }

    MeshData ring_ = scenes::torus(0.9, 0.35, 14, 8);
    Kind kind_;
    std::vector<BodyId> ids_;
};

class PartsTest : public testing::TestWithParam<Case> {};

TEST_P(PartsTest, FindWhatOneBackendFinds) {
    Swarms one(bvh_backend(), GetParam()), two(parts(2), GetParam()), four(parts(4), GetParam());
    std::size_t contacts = 0, old = 0;
    const int steps = GetParam().kind == Kind::sheets ? 40 : 70;
    for (int step = 0; step < steps; ++step) {
        for (Swarms* swarms : {&one, &two, &four}) {
            swarms->put(step);
            swarms->world.detect();
        }
        ASSERT_EQ(contact_hash(two.world.contacts()), contact_hash(one.world.contacts())) << step;
        ASSERT_EQ(contact_hash(four.world.contacts()), contact_hash(one.world.contacts())) << step;
        for (const World* world : {&two.world, &four.world}) {
            EXPECT_EQ(world->stats().pairs, one.world.stats().pairs);
            EXPECT_EQ(world->stats().contacts, one.world.stats().contacts);
            EXPECT_EQ(world->stats().touching_pairs, one.world.stats().touching_pairs);
            EXPECT_EQ(world->stats().penetration_max, one.world.stats().penetration_max);
        }
        contacts += one.world.contacts().size();
        for (const Contact& c : one.world.contacts()) old += c.age > 0;
    }
    EXPECT_GT(contacts, 3000u);
    EXPECT_GT(old, 100u) << "contacts last over steps";
}

/// A world of some parts goes on as one of other parts, or of one backend.
TEST_P(PartsTest, GoOnWithOtherParts) {
    Swarms one(bvh_backend(), GetParam()), shared(parts(3), GetParam());
    const int steps = GetParam().kind == Kind::sheets ? 45 : 60;
    for (int step = 0; step < steps; ++step) {
        one.put(step);
        shared.put(step);
        if (step % 20 == 19) {
            std::stringstream saved(std::ios::in | std::ios::out | std::ios::binary);
            shared.world.save(saved);
            shared.world = World::restore(saved,
                                          step == 39 ? bvh_backend() : parts(step == 19 ? 2 : 5));
        }
        one.world.detect();
        shared.world.detect();
        ASSERT_EQ(contact_hash(shared.world.contacts()), contact_hash(one.world.contacts()))
            << step;
    }
}

TEST(DeviceAndHostTest, FindWhatOneBackendFinds) {
    for (const Temporal temporal : {Temporal::certified, Temporal::paper}) {
        const Case tested{Kind::mixed, {.temporal = temporal}, ""};
        Swarms one(bvh_backend(), tested), both(device_and_host(), tested);
        EXPECT_TRUE(both.world.plan().parts[0].on_device);
        EXPECT_FALSE(both.world.plan().parts[1].on_device);
        std::uint32_t ghosts = 0;
        for (int step = 0; step < 30; ++step) {
            for (Swarms* swarms : {&one, &both}) {
                if (step != 20) swarms->put(step);  // in one step, nothing changes
                swarms->world.detect();
            }
            ASSERT_EQ(contact_hash(both.world.contacts()), contact_hash(one.world.contacts()))
                << step;
            const std::vector<PlannedPart>& parts = both.world.plan().parts;
            EXPECT_GT(parts[0].bodies, parts[1].bodies);
            EXPECT_EQ(parts[0].bodies + parts[1].bodies, one.world.body_boxes().size());
            EXPECT_GT(parts[1].triangles, 0u);
            ghosts += parts[0].ghosts + parts[1].ghosts;
            EXPECT_EQ(both.world.stats().part_milliseconds.size(), 2u);
        }
        EXPECT_GT(ghosts, 10u);
        // The host cannot read these, and the device cannot call that.
        const Pose pose;
        const BodyId body = both.world.body_boxes()[1].body;
        EXPECT_THROW(both.world.set_device_poses({&body, 1}, &pose.position.x), InputError);
        EXPECT_THROW(both.world.set_pair_filter([](BodyId, BodyId) { return true; }), InputError);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Swarms, PartsTest,
    testing::Values(
        Case{Kind::rigid, {}, "rigid"},
        Case{Kind::rigid, {.coverage = Coverage::complete}, "rigid_complete"},
        Case{Kind::rigid, {.temporal = Temporal::off}, "rigid_off"},
        Case{Kind::rigid, {.temporal = Temporal::paper}, "rigid_paper"},
        Case{Kind::soft, {}, "soft"}, Case{Kind::soft, {.temporal = Temporal::paper}, "soft_paper"},
        Case{Kind::mixed, {.may_rest = false}, "mixed"},
        Case{Kind::mixed, {.margin = 0.2}, "mixed_margin"},
        Case{Kind::mixed, {.coverage = Coverage::vertices, .reproject = false}, "mixed_vertices"},
        Case{Kind::mixed, {.temporal = Temporal::paper, .full_every = 3}, "mixed_paper"},
        Case{Kind::sheets, {}, "sheets"}),
    [](const testing::TestParamInfo<Case>& tested) { return tested.param.name; });

TEST(PartsOptionsTest, AreChecked) {
    EXPECT_THROW(partitioned_backend({}), InputError);
    std::vector<int> asked;
    const auto make = [&](int threads) {
        asked.push_back(threads);
        return bvh_backend();
    };
    EXPECT_THROW(partitioned_backend(0, 1, make), InputError);
    EXPECT_EQ(World(partitioned_backend(3, 8, make)).backend(),
              "3 parts; bvh, 1 thread; bvh, 1 thread; bvh, 1 thread");
    EXPECT_THROW(partitioned_backend(2, 1, {}), InputError);
    std::vector<Part> heavy;
    for (int k = 0; k < 3; ++k) heavy.push_back({.backend = bvh_backend(), .share = 1e308});
    EXPECT_THROW(partitioned_backend(std::move(heavy)), InputError) << "their sum is not finite";
    EXPECT_THROW(bvh_backend({.builder = static_cast<TreeBuilder>(4)}), InputError);
    partitioned_backend(2, 1, make);
    EXPECT_EQ(asked, (std::vector<int>{2, 2, 2, 1, 1}));
    const auto with_share = [](double share) {
        std::vector<Part> all;
        all.push_back({.backend = bvh_backend(), .share = share});
        return partitioned_backend(std::move(all));
    };
    EXPECT_THROW(with_share(0), InputError);
    EXPECT_THROW(with_share(-1), InputError);
    EXPECT_THROW(with_share(NAN), InputError);
    EXPECT_THROW(with_share(INFINITY), InputError);
    std::vector<Part> none;
    none.push_back({});
    EXPECT_THROW(partitioned_backend(std::move(none)), InputError);
    World world(with_share(2));
    EXPECT_EQ(world.backend(), "1 parts; bvh, 1 thread");
    EXPECT_TRUE(world.detect().pairs == 0 && world.contacts().empty());
}

TEST(PartsOptionsTest, APartThatFailsEndsTheStepWithItsErrorAndNoContacts) {
    std::vector<Part> all;
    all.push_back({.backend = bvh_backend()});
    all.push_back({.backend = std::make_unique<test::FailingBackend>()});
    Swarms swarms(partitioned_backend(std::move(all)), {Kind::rigid, {}, ""});
    for (int step = 24; step < 26; ++step) {
        swarms.put(step);
        swarms.world.detect();
        EXPECT_FALSE(swarms.world.contacts().empty());
    }
    swarms.put(26);
    try {
        swarms.world.detect();
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "the device is gone");
    }
    EXPECT_TRUE(swarms.world.contacts().empty());
    // It goes on as a world whose bodies were all just added.
    swarms.put(27);
    swarms.world.detect();
    Swarms fresh(bvh_backend(), {Kind::rigid, {}, ""});
    for (int step = 24; step < 28; ++step) fresh.put(step);
    fresh.world.detect();
    EXPECT_EQ(contact_hash(swarms.world.contacts()), contact_hash(fresh.world.contacts()));
}

}  // namespace
}  // namespace pierce
