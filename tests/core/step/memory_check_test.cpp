// What a step may find in a saved world's memory.
#include "core/step/memory_check.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_memory.hpp"
#include "pierce/error.hpp"

namespace pierce {
namespace {

const MeshView* no_mesh(std::uint64_t /*key*/) { return nullptr; }

/// One pair of bodies that are not there, with a contact.
StepMemory memory_of_a_pair() {
    StepMemory memory;
    memory.pair_keys = {1};
    memory.identities.resize(1);
    memory.identities[0].b = {1, 1};
    memory.directed.resize(2);
    memory.contact_keys = {0};
    memory.ages = {3};
    memory.contacts.resize(1);
    return memory;
}

TEST(MemoryCheckTest, ContactsThatWouldBeTakenOverAreThere) {
    StepMemory memory = memory_of_a_pair();
    EXPECT_NO_THROW(check(memory, {}, {}, no_mesh));
    memory.contacts.clear();
    EXPECT_THROW(check(memory, {}, {}, no_mesh), InputError);
    memory.directed.clear();
    EXPECT_NO_THROW(check(memory, {}, {}, no_mesh)) << "nothing is taken over";
}

// A step looks keys up by halving: of some lists out of order it would not end.
TEST(MemoryCheckTest, KeysAreInOrder) {
    StepMemory memory = memory_of_a_pair();
    memory.sheet_keys = {1, 2};
    memory.sheet_records.resize(2);
    EXPECT_NO_THROW(check(memory, {}, {}, no_mesh));
    memory.sheet_keys = {2, 1};
    EXPECT_THROW(check(memory, {}, {}, no_mesh), InputError);

    memory = memory_of_a_pair();
    memory.contact_keys = {1, 0};
    memory.ages.resize(2);
    memory.contacts.resize(2);
    EXPECT_THROW(check(memory, {}, {}, no_mesh), InputError);

    memory = memory_of_a_pair();
    memory.pair_keys = {2, 1};
    memory.identities.resize(2);
    memory.directed.resize(4);
    EXPECT_THROW(check(memory, {}, {}, no_mesh), InputError);
    memory.pair_keys = {1, 2};
    EXPECT_NO_THROW(check(memory, {}, {}, no_mesh));
}

// Where only one direction of a pair goes on, a step would take over half of its contacts.
TEST(MemoryCheckTest, BothDirectionsOfAPairGoOn) {
    StepMemory memory = memory_of_a_pair();
    memory.identities[0].a = {0, 1};
    memory.contact_keys.clear();
    memory.ages.clear();
    memory.contacts.clear();
    std::vector<BodyView> bodies(2);
    for (BodyView& body : bodies) {
        body.motion = Motion::rigid;
        body.mesh.box = {{0, 0, 0}, {1, 1, 1}};
    }
    const std::vector<BodyId> ids{{0, 1}, {1, 1}};
    const auto check_it = [&] { check(memory, view_of(bodies), view_of(ids), no_mesh); };
    EXPECT_NO_THROW(check_it());
    for (const double odometer : {-1.0, 9.0, std::numeric_limits<double>::quiet_NaN()}) {
        memory.directed[1].odometer = odometer;
        EXPECT_THROW(check_it(), InputError) << odometer;
    }
    memory.directed[1].odometer = 0.5;
    EXPECT_NO_THROW(check_it());
    memory.directed[1].odometer = 0;
    bodies[1].mesh.box = {{1, 1, 1}, {1, 1, 1}};
    EXPECT_NO_THROW(check_it()) << "a mesh may be a point, of which nothing is known";
    memory.directed[0].step = std::numeric_limits<double>::infinity();
    EXPECT_THROW(check_it(), InputError);
}

TEST(MemoryCheckTest, PairsThatAreNoMoreAreForgotten) {
    StepMemory memory = memory_of_a_pair();
    const PairIdentity before = memory.identities[0];
    check(memory, {}, {}, no_mesh);
    EXPECT_FALSE(memory.identities[0].is(before));
    EXPECT_TRUE(memory.identities[0].is({}));
}

}  // namespace
}  // namespace pierce
