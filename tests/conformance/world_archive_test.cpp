// Saved worlds go on as they would have, on any backend, and nothing else is taken for one.
#include <gmock/gmock.h>

#include <cstring>
#include <sstream>

#include "core/base/archive.hpp"
#include "core/world/archived.hpp"
#include "core/world/world_state.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using testing::HasSubstr;

/// Solids that move, one that deforms, and a sheet that goes through one of them.
class SavedRun {
public:
    SavedRun(std::unique_ptr<Backend> backend, const Settings& settings)
        : world(std::move(backend), settings) {
        test::Random random(5);
        const MeshId solid = world.add_mesh("solid", test::random_closed_mesh(random));
        square_ = {{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{{0, 1, 2}}, {{0, 2, 3}}}};
        const MeshId sheet = world.add_mesh("sheet", square_);
        world.remove_body(world.add_rigid_body(solid));
        world.add_fixed_body(solid);
        moving_ = world.add_rigid_body(solid, {{0.8, 0, 0}, {}});
        cloth_ = world.add_deforming_body(sheet);
        world.set_collision(cloth_, {.self = SelfCollision::on, .sheet = true, .thickness = 0.05});
    }
    explicit SavedRun(World restored, const SavedRun& other)
        : world(std::move(restored)),
          square_(other.square_),
          moving_(other.moving_),
          cloth_(other.cloth_),
          step_(other.step_) {}

    /// The hash of the next step.
    std::uint64_t next() {
        ++step_;
        world.set_pose(moving_, {{0.8 - 0.02 * step_, 0.01 * step_, 0}, {0, 0, 0.05 * step_, 1}});
        std::vector<Vec3f> positions = square_.positions;
        for (Vec3f& p : positions) p.z = 1.5f - 0.1f * static_cast<float>(step_);
        world.set_positions(cloth_, positions);
        world.detect();
        return contact_hash(world.contacts());
    }

    std::string saved() const {
        std::ostringstream out;
        world.save(out);
        return out.str();
    }

    World world;

private:
    MeshData square_;
    BodyId moving_, cloth_;
    int step_ = 0;
};

World restored(const std::string& saved, std::unique_ptr<Backend> backend = reference_backend()) {
    std::istringstream in(saved);
    return World::restore(in, std::move(backend));
}

TEST(WorldArchiveTest, ARunGoesOnWithEqualHashesOnAnyBackend) {
    for (const Temporal temporal : {Temporal::off, Temporal::paper, Temporal::certified})
        for (const Coverage coverage :
             {Coverage::vertices, Coverage::overlaps, Coverage::complete}) {
            const Settings settings{.coverage = coverage,
                                    .temporal = temporal,
                                    .may_rest = coverage == Coverage::vertices};
            SavedRun run(reference_backend(), settings);
            for (int step = 0; step < 6; ++step) run.next();
            const std::string saved = run.saved();
            std::vector<SavedRun> others;
            for (const test::NamedBackend& backend : test::backends())
                others.emplace_back(restored(saved, backend.make()), run);
            for (int step = 0; step < 8; ++step) {
                const std::uint64_t expected = run.next();
                for (SavedRun& other : others)
                    EXPECT_EQ(other.next(), expected) << other.world.backend() << ' ' << step;
            }
            EXPECT_FALSE(run.world.contacts().empty());
        }
}

TEST(WorldArchiveTest, WhatIsNoSavedWorldIsRefusedByWhatIsWrongWithIt) {
    SavedRun run(reference_backend(), {});
    for (int step = 0; step < 4; ++step) run.next();
    const std::string saved = run.saved();
    const auto refused = [](const std::string& bytes, const char* why) {
        EXPECT_THAT([&] { restored(bytes); }, testing::ThrowsMessage<InputError>(HasSubstr(why)));
    };
    refused("", "ends too soon");
    refused("a file of another kind, long enough for a header", "something else");
    refused(saved.substr(0, saved.size() - 1), "more or less than its header says");
    refused(saved + "x", "more or less than its header says");
    std::string later = saved;
    const int version = later[8]++;
    refused(later, ("has version " + std::to_string(version + 1) + "; this library reads version " +
                    std::to_string(version))
                       .c_str());
    test::Random random(6);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 100; ++i) {
        std::string damaged = saved;
        char& byte = damaged[static_cast<std::size_t>(
            random.integer(28, static_cast<int>(saved.size()) - 1))];
        byte = static_cast<char>(byte ^ (1 << random.integer(0, 7)));
        refused(damaged, "its checksum differs");
    }
}

TEST(WorldArchiveTest, AWorldWhoseKeysAreUsedUpIsRefused) {
    SavedRun run(reference_backend(), {});
    run.next();
    const std::string saved = run.saved();
    ArchiveWriter settings;
    Settings of_run;
    transfer(settings, of_run);
    constexpr std::size_t header = 28, sum_at = 20;
    for (const std::uint64_t key : {largest_key, largest_key + 1, ~std::uint64_t{0}}) {
        std::string body = saved.substr(header);
        std::memcpy(body.data() + settings.bytes().size(), &key, sizeof key);
        std::string changed = saved.substr(0, header) + body;
        const std::uint64_t sum = checksum(body);
        std::memcpy(changed.data() + sum_at, &sum, sizeof sum);
        if (key <= largest_key) {
            EXPECT_NO_THROW(restored(changed));
            continue;
        }
        EXPECT_THAT([&] { restored(changed); },
                    testing::ThrowsMessage<InputError>(HasSubstr("keys that are used up")));
    }
}

// What is remembered of bodies that are gone is forgotten.
TEST(WorldArchiveTest, AWorldIsSavedAndRestoredAgainAndAgain) {
    World world;
    const MeshId mesh = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    const BodyId a = world.add_rigid_body(mesh),
                 b = world.add_rigid_body(mesh, {{0.2, 0.3, 0.9}, {}});
    world.add_rigid_body(mesh, {{9, 9, 9}, {}});
    world.detect();
    EXPECT_FALSE(world.contacts().empty());
    world.remove_body(a);
    world.remove_body(b);
    for (int i = 0; i < 3; ++i) {
        std::stringstream saved;
        world.save(saved);
        ASSERT_NO_THROW(world = World::restore(saved, reference_backend())) << i;
        if (i == 1) world.detect();
    }
}

TEST(WorldArchiveTest, HandlesStayWhatTheyWere) {
    SavedRun run(reference_backend(), {});
    World world = restored(run.saved());
    EXPECT_THROW(world.remove_body({0, 1}), InputError)
        << "the first body was removed, and its place taken";
    EXPECT_EQ(world.motion_of({0, 2}), Motion::fixed);
    EXPECT_TRUE(world.contacts().empty());
}

}  // namespace
}  // namespace pierce
