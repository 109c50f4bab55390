// Bodies, meshes and worlds that change between the steps of a world over several ranks: all ranks
// find what one world finds. Ranks beyond the second get bodies only from others.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/world/world_state.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/mpi/world.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/step_stats.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/failing_backend.hpp"

namespace pierce {
namespace {

Pose at(double x, double y = 0, double z = 0) { return {{x, y, z}, {}}; }
MeshData cube() { return scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}); }
std::vector<Vec3f> cube_at(double x, double y = 0) {
    return scenes::moved(cube().positions, to_float({x, y, 0}));
}
Collision sheet() { return {.sheet = true, .thickness = 0.01}; }
BodyId body(std::uint32_t number) { return {number, 1}; }

std::string message_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "nothing thrown";
}

/// The same bodies over all ranks, and in one world, which every rank has.
class RanksChangeTest : public testing::Test {
protected:
    void SetUp() override {
        if (many->ranks() == 1) GTEST_SKIP() << "there is one rank";
    }

    bool is_rank(int rank) const { return many->rank() == rank; }
    MeshId add_mesh(const MeshData& data) {
        one->add_mesh("mesh", data);
        return many->add_mesh("mesh", data);  // handles are the same
    }
    void add_rigid(int rank, std::uint32_t number, MeshId mesh, const Pose& pose) {
        one->add_rigid_body(mesh, pose);
        if (is_rank(rank)) many->add_rigid_body(number, mesh, pose);
    }
    void add_sheet(int rank, std::uint32_t number, MeshId mesh,
                   const std::vector<Vec3f>& positions) {
        one->add_deforming_body(mesh, positions);
        if (is_rank(rank)) many->add_deforming_body(number, mesh, positions);
        on_owner(number, [](auto& world, BodyId b) { world.set_collision(b, sheet()); });
    }
    /// Calls call(world, body) for the world that owns the body, and for the one world.
    template <class Call>
    void on_owner(std::uint32_t number, const Call& call) {
        call(*one, body(number));
        if (many->owns(body(number))) call(*many, body(number));
    }
    void set_pose(std::uint32_t number, const Pose& pose) {
        on_owner(number, [&](auto& world, BodyId b) { world.set_pose(b, pose); });
    }
    void set_positions(std::uint32_t number, const std::vector<Vec3f>& positions) {
        on_owner(number, [&](auto& world, BodyId b) { world.set_positions(b, positions); });
    }
    /// Runs a step; returns how many contacts there are.
    std::size_t step() {
        many->detect();
        one->detect();
        const std::vector<Contact> all = many->gather_contacts();
        if (is_rank(0)) {
            EXPECT_EQ(contact_hash(all), contact_hash(one->contacts()))
                << all.size() << " contacts and " << one->contacts().size();
        }
        return one->contacts().size();
    }
    /// Goes on with what save() has written.
    void save_and_restore() {
        std::ostringstream out;
        many->save(out);
        std::string bytes = out.str();
        std::uint64_t size = bytes.size();
        MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
        bytes.resize(size);
        MPI_Bcast(bytes.data(), static_cast<int>(size), MPI_BYTE, 0, MPI_COMM_WORLD);
        std::istringstream in(bytes);
        many = std::make_unique<mpi::World>(mpi::World::restore(MPI_COMM_WORLD, in, bvh_backend()));
    }

    std::unique_ptr<mpi::World> many = std::make_unique<mpi::World>(MPI_COMM_WORLD, bvh_backend());
    std::unique_ptr<World> one = std::make_unique<World>(bvh_backend());
};

TEST_F(RanksChangeTest, AMeshIsRemovedWhileABodyThatHasLeftHasIt) {
    many = std::make_unique<mpi::World>(MPI_COMM_WORLD, embree_backend(1));
    const MeshData ring = scenes::torus(0.7, 0.3, 40, 20), other = scenes::torus(0.7, 0.35, 20, 12);
    const MeshId mesh = add_mesh(ring), others = add_mesh(other);
    constexpr std::uint32_t rings = 6;
    for (std::uint32_t b = 0; b < rings; ++b) add_rigid(0, b, mesh, at(b));
    add_rigid(0, rings, others, at(-0.7));
    step();
    many->migrate();
    step();
    double last = 0;
    for (std::uint32_t b = 0; b < rings; ++b) {
        std::uint8_t goes = is_rank(0) && many->owns(body(b));
        MPI_Bcast(&goes, 1, MPI_UINT8_T, 0, MPI_COMM_WORLD);
        if (goes == 0)
            last = b;
        else
            on_owner(b, [](auto& world, BodyId gone) { world.remove_body(gone); });
    }
    if (is_rank(0)) many->remove_mesh(mesh);
    set_pose(rings, at(last - 0.6, 0.3));
    EXPECT_GT(last, 0);
    EXPECT_GT(step(), 100u);
}

TEST_F(RanksChangeTest, SheetsRememberWhereAGhostThatHasLeftWasLarger) {
    const MeshId small = add_mesh(cube()), large = add_mesh(scenes::torus(1, 0.4, 30, 20));
    add_sheet(0, 0, small, cube_at(0));
    add_sheet(0, 1, small, cube_at(0.1, 1.2));
    one->add_fixed_body(large, at(20));
    if (is_rank(0)) many->add_fixed_body(2, large, at(20));
    add_rigid(1, 3, small, at(20.9));
    EXPECT_GT(step(), 50u);
    set_pose(2, at(60));
    step();
    on_owner(2, [&](auto& world, BodyId b) { world.set_mesh(b, small); });
    step();
    set_positions(1, cube_at(0.1, 0.7));
    EXPECT_GT(step(), 20u);
    std::ostringstream out;
    many->save(out);
    if (is_rank(0)) {
        std::istringstream in(out.str());
        EXPECT_NO_THROW(World::restore(in, bvh_backend()));
    }
    many->migrate();
    EXPECT_GT(step(), 10u);
}

TEST_F(RanksChangeTest, WhatIsRememberedOutlastsSeveralMoves) {
    for (const bool restores : {false, true}) {
        SCOPED_TRACE(restores);
        many = std::make_unique<mpi::World>(MPI_COMM_WORLD, bvh_backend());
        one = std::make_unique<World>(bvh_backend());
        const MeshId mesh = add_mesh(cube());
        add_sheet(0, 0, mesh, cube_at(0));
        add_sheet(1, 1, mesh, cube_at(1.2, 0.1));
        step();
        set_positions(1, cube_at(0.8, 0.1));
        EXPECT_GT(step(), 20u);
        if (restores)
            save_and_restore();
        else
            many->migrate();
        many->migrate();
        EXPECT_GT(step(), 10u);
    }
}

TEST_F(RanksChangeTest, PredictionsOutlastMovesWhereARankHasNoBodies) {
    Settings settings;
    settings.temporal = Temporal::paper;
    settings.full_every = 50;
    many = std::make_unique<mpi::World>(MPI_COMM_WORLD, bvh_backend(), settings);
    one = std::make_unique<World>(bvh_backend(), settings);
    const MeshId mesh = add_mesh(scenes::torus(0.9, 0.35, 14, 8));
    add_rigid(0, 0, mesh, at(0));
    add_rigid(1, 1, mesh, at(1, 0.1));
    std::uint32_t walks = 0;
    for (int k = 0; k < 9; ++k) {
        set_pose(0, at(0.02 * k, 0, 0.02 * k));
        set_pose(1, at(1 - 0.03 * k, 0.1, 0.02 * k));
        if (k == 4) many->migrate();
        if (k == 6) save_and_restore();
        step();
        std::uint32_t here = many->stats().walks;
        MPI_Allreduce(MPI_IN_PLACE, &here, 1, MPI_UINT32_T, MPI_SUM, MPI_COMM_WORLD);
        EXPECT_EQ(here, one->stats().walks) << k;
        walks += here;
    }
    EXPECT_GT(walks, 50u);
}

TEST_F(RanksChangeTest, ARankWhoseStepHasSucceededRepeatsItsMotion) {
    many = std::make_unique<mpi::World>(MPI_COMM_WORLD,
                                        std::make_unique<test::FailingBackend>(is_rank(1)));
    one = std::make_unique<World>(std::make_unique<test::FailingBackend>());
    const MeshId mesh = add_mesh(cube());
    add_sheet(0, 0, mesh, cube_at(0));
    add_sheet(0, 1, mesh, cube_at(0.1, 3));
    add_rigid(1, 2, mesh, at(50));
    step();
    step();
    set_positions(1, cube_at(0.1, -3));  // right through the other one
    EXPECT_EQ(message_of([&] { many->detect(); }), "rank 1: the device is gone");
    EXPECT_EQ(message_of([&] { one->detect(); }), "the device is gone");
    EXPECT_GT(step(), 100u);
}

TEST_F(RanksChangeTest, AMeshThatHasArrivedIsRemovedAndComesAgain) {
    const MeshId box = add_mesh(cube());
    const MeshId mesh = many->add_mesh("ring", scenes::torus(0.7, 0.3, 10, 8));
    one->add_mesh("ring", scenes::torus(0.7, 0.3, 10, 8));
    add_rigid(0, 0, mesh, at(0));
    add_rigid(0, 1, mesh, at(9));
    add_rigid(0, 2, box, at(8.5));
    one->add_fixed_body(mesh, at(-9));
    if (is_rank(0)) many->add_fixed_body(3, mesh, at(-9));
    step();
    many->migrate();
    step();
    one->remove_body(body(1));
    if (many->owns(body(1))) {
        const MeshId arrived = many->nearby().mesh_of(body(1));
        many->remove_body(body(1));
        if (!is_rank(0)) many->remove_mesh(arrived);
    }
    step();
    set_pose(3, at(8.5));
    EXPECT_GT(step(), 10u);
    EXPECT_GT(step(), 10u);
}

TEST_F(RanksChangeTest, MeshesThatCameBackAreKeptByNoRankForTheOther) {
    const MeshId first = add_mesh(cube());
    for (std::uint32_t b = 0; b < 2; ++b)
        add_rigid(static_cast<int>(b) % many->ranks(), b, first, at(50.0 * b));
    const auto used = [&] {
        const auto& slots = WorldInside::state(many->nearby()).meshes.slots();
        return std::ranges::count_if(slots, [](const auto& slot) { return slot.used; });
    };
    const auto remove_all = [&] {
        const auto count = WorldInside::state(many->nearby()).meshes.slots().size();
        for (std::uint32_t m = 0; m < count; ++m) {
            const auto& slot = WorldInside::state(many->nearby()).meshes.slots()[m];
            if (slot.used) message_of([&] { many->remove_mesh({m, slot.generation}); });
        }
    };
    std::ptrdiff_t after_few = 0;
    for (int round = 0; round < 8; ++round) {
        // Bodies go to other ranks and back, and then get another mesh.
        for (const bool swapped : {true, false}) {
            for (std::uint32_t b = 0; b < 2; ++b)
                set_pose(b, at(swapped ? 50 - 50.0 * b : 50.0 * b));
            many->migrate();
            step();
        }
        const MeshId in_one = one->add_mesh("other", cube()),
                     in_many = many->add_mesh("other", cube());
        for (std::uint32_t b = 0; b < 2; ++b)
            on_owner(b, [&](auto& world, BodyId id) {
                constexpr bool is_one = std::is_same_v<decltype(world), World&>;
                world.set_mesh(id, is_one ? in_one : in_many);
            });
        for (int k = 0; k < 3; ++k) {
            remove_all();
            step();
        }
        if (round == 2) after_few = used();
    }
    EXPECT_LE(used(), after_few);
}

TEST_F(RanksChangeTest, AMeshThatTwoRanksHaveSentIsRemovedByOne) {
    if (many->ranks() < 3) GTEST_SKIP() << "there is no third rank";
    const MeshId mesh = add_mesh(cube());
    constexpr std::uint32_t cubes = 24;
    for (std::uint32_t b = 0; b < cubes; ++b) add_rigid(0, b, mesh, at(10.0 * b));
    step();
    save_and_restore();  // a mesh that several ranks have
    // The first body of each rank, as all know it.
    std::vector<std::uint32_t> first(static_cast<std::size_t>(many->ranks()), cubes);
    std::vector<int> owner(cubes, 0);
    for (std::uint32_t b = 0; b < cubes; ++b) {
        owner[b] = many->owns(body(b)) ? many->rank() : 0;
        MPI_Allreduce(MPI_IN_PLACE, &owner[b], 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
        std::uint32_t& its = first[static_cast<std::size_t>(owner[b])];
        its = std::min(its, b);
    }
    for (const std::uint32_t b : first) ASSERT_LT(b, cubes);
    const double near = 10.0 * first[0];
    set_pose(first[1], at(near + 0.8));
    set_pose(first[2], at(near - 0.8));
    EXPECT_GT(step(), 0u);
    for (std::uint32_t b = 0; b < cubes; ++b) {
        if (owner[b] != 2) continue;
        const MeshId arrived = is_rank(2) ? many->nearby().mesh_of(body(b)) : MeshId();
        on_owner(b, [](auto& world, BodyId gone) { world.remove_body(gone); });
        const bool is_last = std::ranges::find(owner.begin() + b + 1, owner.end(), 2) ==
                             owner.end();
        if (is_last && is_rank(2)) many->remove_mesh(arrived);
    }
    EXPECT_GT(step(), 0u);
    set_pose(first[1], at(-500));
    step();
    set_pose(first[1], at(near + 0.7));
    EXPECT_GT(step(), 0u);
}

TEST_F(RanksChangeTest, WorldsAreLeftOutWhereverTheirBodiesAre) {
    const MeshId mesh = add_mesh(cube());
    const auto join = [&](std::uint32_t number) {
        on_owner(number, [](auto& world, BodyId b) { world.set_filter(b, {.world = 5}); });
    };
    const std::array places = {0.0, 0.8, 20.0, 20.8};
    for (std::uint32_t b = 0; b < 4; ++b) add_rigid(b < 2 ? 0 : 1, b, mesh, at(places[b]));
    join(2);
    join(3);
    const std::size_t all = step();
    one->set_world_active(5, false);
    many->set_world_active(5, false);
    const std::size_t awake = step();
    EXPECT_LT(awake, all);
    // The two pairs change ranks.
    for (const std::uint32_t b : {0u, 1u}) set_pose(b, at(100 + places[b]));
    many->migrate();
    EXPECT_EQ(step(), awake);
    save_and_restore();
    EXPECT_EQ(step(), awake);
    join(0);
    EXPECT_EQ(step(), 0u);
    one->set_world_active(5, true);
    many->set_world_active(5, true);
    EXPECT_GT(step(), 0u);
    EXPECT_THROW(many->set_world_active(all_worlds, false), InputError);
    EXPECT_THROW(many->set_world_active(-2, false), InputError);
}

// It is a ghost of the other rank when it is removed.
TEST_F(RanksChangeTest, AWorldThatHasLostItsLastBodyIsLeftOutNoMore) {
    const MeshId mesh = add_mesh(cube());
    for (const int owner : {0, 1}) {
        const auto number = static_cast<std::uint32_t>(3 * owner);
        add_rigid(owner, number, mesh, at(50.0 * owner));
        add_rigid(1 - owner, number + 1, mesh, at(50.0 * owner + 0.8));
        add_rigid(owner, number + 2, mesh, at(50.0 * owner + 20));
    }
    for (const int owner : {0, 1}) {
        const auto first = static_cast<std::uint32_t>(3 * owner), later = first + 2;
        const double place = 50.0 * owner;
        const std::int32_t world = 3 + owner;
        const auto join = [&](std::uint32_t number) {
            on_owner(number, [&](auto& its, BodyId b) { its.set_filter(b, {.world = world}); });
        };
        join(first);
        const std::size_t all = step();
        one->set_world_active(world, false);
        many->set_world_active(world, false);
        EXPECT_LT(step(), all);
        on_owner(first, [](auto& its, BodyId gone) { its.remove_body(gone); });
        step();
        step();
        join(later);
        set_pose(later, at(place));
        EXPECT_EQ(step(), all) << owner;
    }
}

TEST_F(RanksChangeTest, NumbersAndExclusionsOfRemovedBodies) {
    const MeshId mesh = add_mesh(cube());
    add_rigid(0, 0, mesh, at(0));
    add_rigid(0, 1, mesh, at(0.8));
    step();
    if (is_rank(0)) {
        many->exclude(body(0), body(1));
        many->remove_body(body(0));
        EXPECT_EQ(message_of([&] { many->exclude(body(0), body(1)); }), "body 0 was removed");
    }
    if (is_rank(1)) many->add_rigid_body(0, mesh, at(0));
    EXPECT_EQ(message_of([&] { many->detect(); }),
              "rank 0: body 0 was removed on rank 0 and added on rank 1 in the same step");
    step();
    EXPECT_GT(step(), 0u);
}

TEST_F(RanksChangeTest, AHandleOfABodyThatNoStepHasSeenIsNotAnotherOnes) {
    const MeshId mesh = add_mesh(cube());
    add_rigid(0, 0, mesh, at(0));
    if (is_rank(0)) many->remove_body(many->add_rigid_body(5, mesh, at(9)));
    if (is_rank(1)) many->add_rigid_body(5, mesh, at(0.8));
    EXPECT_EQ(message_of([&] { many->detect(); }),
              "rank 0: body 5 was removed on rank 0 and added on rank 1 in the same step");
}

TEST_F(RanksChangeTest, ContactsAreGatheredInTheOrderInWhichTheyWereFound) {
    const MeshId mesh = add_mesh(cube());
    add_rigid(0, 0, mesh, at(0));
    add_rigid(1, 1, mesh, at(0.8));
    step();
    EXPECT_EQ(message_of([&] { many->gather_contacts(99); }), "rank 0: there is no rank 99");
    EXPECT_EQ(message_of([&] { many->gather_contacts(-1); }), "rank 0: there is no rank -1");
    const std::string refused =
        "rank 0: gather_contacts needs a detect() after bodies were added, "
        "removed or changed";
    many->migrate();
    EXPECT_EQ(message_of([&] { many->gather_contacts(); }), refused);
    step();
    EXPECT_EQ(message_of([&] { many->gather_contacts(); }), "nothing thrown");
    if (is_rank(0)) many->remove_body(body(0));
    std::ostringstream saved;
    many->save(saved);
    many->nearby().plan();
    EXPECT_EQ(message_of([&] { many->gather_contacts(); }), refused);
}

}  // namespace
}  // namespace pierce
