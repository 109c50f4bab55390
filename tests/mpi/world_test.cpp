// A world over several ranks finds what one world finds: contacts, order and ages. Every rank runs
// the same program; rank 0 has the whole world, too.
#include "pierce/mpi/world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/mpi/ranks_backend.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/step_stats.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/counting_backend.hpp"
#include "support/device_memory.hpp"
#include "support/failing_backend.hpp"

namespace pierce {
namespace {

int rank_of(MPI_Comm comm) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    return rank;
}
int size_of(MPI_Comm comm) {
    int size = 0;
    MPI_Comm_size(comm, &size);
    return size;
}

/// True on all ranks if it is true on rank 0.
bool all_agree(bool value, MPI_Comm comm = MPI_COMM_WORLD) {
    int number = value;
    MPI_Bcast(&number, 1, MPI_INT, 0, comm);
    return number != 0;
}

std::uint64_t sum(std::uint64_t value, MPI_Comm comm) {
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_UINT64_T, MPI_SUM, comm);
    return value;
}

enum class Kind { rigid, soft, mixed, sheets, worlds, torn };

struct Case {
    Kind kind;
    Settings settings;
    const char* name;
};

void PrintTo(const Case& tested, std::ostream* os) { *os << tested.name; }

/// Two swarms that fly through each other, over a floor: where they are, without a world.
class Swarms {
public:
    static constexpr int bodies = 25;  ///< the first one is the floor

    explicit Swarms(const Case& tested) : kind_(tested.kind) {}

    const MeshData& ring() const { return ring_; }
    MeshData floor() const { return scenes::box({-40, -40, -1}, {40, 40, 0}); }
    bool is_soft(int b) const {
        return kind_ == Kind::soft || kind_ == Kind::sheets || kind_ == Kind::torn ||
               ((kind_ == Kind::mixed || kind_ == Kind::worlds) && b % 2 == 1);
    }
    Collision collision(int b) const {
        Collision collision;
        if (kind_ == Kind::sheets && b % 8 == 1) {
            collision.sheet = true;
            collision.thickness = 0.05;
        }
        return collision;
    }
    Filter filter(int b) const {
        Filter filter;
        if (kind_ == Kind::worlds && b % 4 != 0) filter.world = 7 - b % 3;
        return filter;
    }
    static bool rests(int b, int step) { return step > 0 && (b + step / 8) % 5 == 0; }
    static Pose pose(int b, int step) {
        const double side = b % 2 == 0 ? 1 : -1, t = 0.25 * step, angle = 0.1 * step + b;
        return {{side * (7 - t) + 1.1 * (b / 6), 1.3 * (b % 6) - 3, 0.2 * (b % 3)},
                {0.3 * std::sin(angle), 0.2 * std::cos(angle), 0.1, 0.9}};
    }
    std::vector<Vec3f> positions(int b, int step) const { return bent(pose(b, step), step + b); }
    std::vector<Vec3f> bent(const Pose& pose, double phase) const {
        std::vector<Vec3f> positions;
        for (const Vec3f p : ring_.positions) {
            Vec3d q = to_double(p);
            q.z *= 1 + 0.1 * std::sin(0.7 * phase + q.x);
            positions.push_back(to_float(frame_of(pose).to_parent(q)));
        }
        return positions;
    }
    Kind kind() const { return kind_; }

private:
    Kind kind_;
    MeshData ring_ = scenes::torus(0.9, 0.35, 14, 8);
};

/// The swarms in a World of either kind. `is_here(b)`: this world has body b.
template <class AnyWorld>
class Flight {
public:
    Flight(AnyWorld its_world, const Case& tested, int first_rank, int ranks,
           bool on_device = false)
        : world(std::move(its_world)),
          swarms_(tested),
          rank_(first_rank),
          ranks_(ranks),
          on_device_(on_device) {
        ids_.resize(Swarms::bodies);
        there_.resize(Swarms::bodies);
    }

    AnyWorld world;

    /// True if the body is added here.
    bool adds(int b) const { return ranks_ == 0 || b % ranks_ == rank_; }
    bool has(int b) const {
        if constexpr (std::is_same_v<AnyWorld, mpi::World>)
            return world.owns(ids_[static_cast<std::size_t>(b)]);
        else
            return true;
    }

    void add_all() {
        const MeshId ring = world.add_mesh("ring", swarms_.ring()),
                     floor = world.add_mesh("floor", swarms_.floor());
        for (int b = 0; b < Swarms::bodies; ++b) {
            BodyId& id = ids_[static_cast<std::size_t>(b)];
            id = {static_cast<std::uint32_t>(b), 1};
            if (!adds(b)) continue;
            if (b == 0)
                id = add(b, [&](auto... number) {
                    return world.add_fixed_body(number..., floor, {{0, 0, -1.2}, {}});
                });
            else if (swarms_.is_soft(b))
                id = add(b,
                         [&](auto... number) { return world.add_deforming_body(number..., ring); });
            else
                id = add(b, [&](auto... number) { return world.add_rigid_body(number..., ring); });
            describe(b);
        }
        if (rank_ == 0) world.exclude(ids_[3], ids_[4]);
    }

    void put(int step) {
        if (step % 17 == 9) {  // one goes, another one comes
            if (has(5)) {
                world.remove_body(ids_[5]);
                ++ids_[5].generation;
                const MeshId mesh = world.add_mesh("ring", swarms_.ring());
                EXPECT_EQ(ids_[5], add(5, [&](auto... number) {
                              return world.add_deforming_body(
                                  number..., mesh, swarms_.bent({{0, 0.5, 0}, {}}, step));
                          }));
            } else {
                ++ids_[5].generation;
            }
            soft5_ = true;
        }
        for (int b = 1; b < Swarms::bodies; ++b) {
            const BodyId id = ids_[static_cast<std::size_t>(b)];
            Place& there = there_[static_cast<std::size_t>(b)];
            if (!has(b)) there = {};
            there.start = there.positions;
            if (Swarms::rests(b, step) || !has(b)) continue;
            if (on_device_ && b != 5) {
                put_on_device(there, id, b, step);
                continue;
            }
            if (swarms_.kind() == Kind::torn && (step + b) % 11 == 3) {
                MeshData cut = swarms_.ring();
                cut.triangles.resize(cut.triangles.size() - static_cast<std::size_t>(step % 7));
                const MeshId mesh = world.add_mesh("cut", cut);
                world.set_mesh(id, mesh, swarms_.positions(b, step));
            } else if (swarms_.is_soft(b) || (b == 5 && soft5_)) {
                if (swarms_.kind() == Kind::sheets && (b + step) % 6 == 0)
                    world.set_motion(id, swarms_.positions(b, step - 1),
                                     swarms_.positions(b, step));
                else
                    world.set_positions(id, swarms_.positions(b, step));
            } else {
                world.set_pose(id, Swarms::pose(b, step));
            }
        }
        if (swarms_.kind() == Kind::worlds && step % 13 == 6 && has(7)) {
            Filter filter;
            filter.world = step % 2 == 0 ? 6 : all_worlds;
            world.set_filter(ids_[7], filter);
        }
        if (step == 20 && rank_ == 0) world.include(ids_[3], ids_[4]);
    }

    BodyId id(std::uint32_t b) const { return ids_[b]; }

    /// The handles that bodies have after so many steps, in a world that was read.
    void learn_as_of(int steps) {
        for (int b = 0; b < Swarms::bodies; ++b)
            ids_[static_cast<std::size_t>(b)] = {static_cast<std::uint32_t>(b), 1};
        for (int step = 0; step < steps; ++step)
            if (step % 17 == 9) {
                ++ids_[5].generation;
                soft5_ = true;
            }
    }

private:
    /// Where a body is, in what passes for a device's memory.
    struct Place {
        test::SharedVector<Vec3f> positions, start;
        test::SharedVector<double> pose;
    };

    /// Where a body is that has not been put on the device yet.
    std::vector<Vec3f> before(BodyId id) const {
        const pierce::World* nearby = nullptr;
        if constexpr (std::is_same_v<AnyWorld, mpi::World>)
            nearby = &world.nearby();
        else
            nearby = &world;
        std::vector<Vec3f> positions;
        for (const Vec3d p : nearby->vertex_positions(id)) positions.push_back(to_float(p));
        return positions;
    }

    /// The world is told where a place is once, and reads it from then on.
    void put_on_device(Place& there, BodyId id, int b, int step) {
        const bool is_told = !there.positions.empty() || !there.pose.empty();
        if (swarms_.is_soft(b)) {
            // Where they are in memory, they stay.
            const auto write = [](test::SharedVector<Vec3f>& to, const std::vector<Vec3f>& from) {
                to.assign(from.begin(), from.end());
            };
            if (!is_told) write(there.start, before(id));
            if (swarms_.kind() == Kind::sheets && (b + step) % 6 == 0)
                write(there.start, swarms_.positions(b, step - 1));
            write(there.positions, swarms_.positions(b, step));
            if (is_told) return;
            if (swarms_.kind() == Kind::sheets)
                world.set_device_motion(id, there.start.data(), there.positions.data());
            else
                world.set_device_positions(id, there.positions.data());
            return;
        }
        const auto [position, rotation] = Swarms::pose(b, step);
        there.pose = {position.x, position.y, position.z, rotation.x,
                      rotation.y, rotation.z, rotation.w};
        if (!is_told) world.set_device_poses({&id, 1}, there.pose.data());
    }

    template <class Add>
    BodyId add(int b, const Add& add) {
        if constexpr (std::is_same_v<AnyWorld, mpi::World>)
            return add(static_cast<std::uint32_t>(b));
        else
            return add();
    }
    void describe(int b) {
        const BodyId id = ids_[static_cast<std::size_t>(b)];
        if (swarms_.collision(b).sheet) world.set_collision(id, swarms_.collision(b));
        world.set_filter(id, swarms_.filter(b));
    }

    Swarms swarms_;
    int rank_, ranks_;
    bool on_device_;
    bool soft5_ = false;
    std::vector<BodyId> ids_;
    std::vector<Place> there_;  ///< per body
};

using One = Flight<World>;
using Many = Flight<mpi::World>;

One one_world(const Case& tested) {
    return {World(embree_backend(1), tested.settings), tested, 0, 0};
}
/// The first rank, which has the most ghosts, shares its bodies between two backends.
std::unique_ptr<Backend> backend_of(int rank) {
    if (rank == 0) return partitioned_backend(2, 2, [](int) { return bvh_backend(); });
    return rank % 2 ? embree_backend(1) : bvh_backend();
}
Many many_ranks(const Case& tested, MPI_Comm comm) {
    const int rank = rank_of(comm);
    return {mpi::World(comm, backend_of(rank), tested.settings), tested, rank, size_of(comm)};
}
/// Ranks with bodies in what passes for a device's memory, beside ranks without. Bodies of the
/// second rank are ghosts of the first one.
Many ranks_with_devices(const Case& tested) {
    const int rank = rank_of(MPI_COMM_WORLD), ranks = size_of(MPI_COMM_WORLD);
    std::unique_ptr<Backend> backend = rank % 2 ? test::device_backend() : backend_of(rank);
    return {mpi::World(MPI_COMM_WORLD, std::move(backend), tested.settings), tested, rank, ranks,
            rank % 2 == 1};
}

/// Runs a step in both, and compares on rank 0.
bool same_step(One& one, Many& many, MPI_Comm comm) {
    many.world.detect();
    const std::vector<Contact> all = many.world.gather_contacts();
    const std::uint64_t pairs = sum(many.world.stats().pairs, comm);
    bool same = true;
    if (rank_of(comm) == 0) {
        one.world.detect();
        const std::span<const Contact> expected = one.world.contacts();
        EXPECT_EQ(all.size(), expected.size());
        EXPECT_EQ(contact_hash(all), contact_hash(expected));
        EXPECT_EQ(pairs, one.world.stats().pairs);
        for (std::size_t c = 0; c < all.size() && c < expected.size(); ++c) {
            EXPECT_EQ(all[c].a, expected[c].a);
            EXPECT_EQ(all[c].b, expected[c].b);
            EXPECT_EQ(all[c].age, expected[c].age) << c;
            if (testing::Test::HasFailure()) break;
        }
        same = !testing::Test::HasFailure();
    }
    return all_agree(same, comm);
}

class RanksTest : public testing::TestWithParam<Case> {};

TEST_P(RanksTest, FindWhatOneWorldFinds) {
    One one = one_world(GetParam());
    Many many = many_ranks(GetParam(), MPI_COMM_WORLD);
    one.add_all();
    many.add_all();
    std::uint64_t contacts = 0, elsewhere = 0, migrated = 0;
    const int steps = GetParam().kind == Kind::sheets ? 30 : 60;
    for (int step = 0; step < steps; ++step) {
        one.put(step);
        many.put(step);
        if (step % 9 == 4) migrated += many.world.migrate().arrived.size();
        ASSERT_TRUE(same_step(one, many, MPI_COMM_WORLD)) << step;
        contacts += many.world.contacts().size();
        for (const Contact& c : many.world.contacts())
            elsewhere += !many.world.owns(c.a) || !many.world.owns(c.b);
    }
    EXPECT_GT(sum(contacts, MPI_COMM_WORLD), 1000u);
    if (many.world.ranks() > 1) {
        EXPECT_GT(sum(elsewhere, MPI_COMM_WORLD), 100u) << "pairs cross borders";
        EXPECT_GT(sum(migrated, MPI_COMM_WORLD), 20u) << "bodies change owners";
    }
}

TEST_P(RanksTest, FindWhatOneWorldFindsWithPlacesOnDevices) {
    if (GetParam().kind == Kind::torn) return;  // another mesh comes with places on the host
    One one = one_world(GetParam());
    Many many = ranks_with_devices(GetParam());
    one.add_all();
    many.add_all();
    for (int step = 0; step < 40; ++step) {
        one.put(step);
        many.put(step);
        if (step % 9 == 4) many.world.migrate();
        ASSERT_TRUE(same_step(one, many, MPI_COMM_WORLD)) << step;
    }
    // What is saved has its places on the host.
    std::stringstream saved(std::ios::in | std::ios::out | std::ios::binary);
    many.world.save(saved);
    if (many.world.rank() > 0) return;
    One again(World::restore(saved, bvh_backend()), GetParam(), 0, 0);
    again.learn_as_of(40);
    for (int step = 40; step < 44; ++step) {
        for (One* world : {&one, &again}) {
            world->put(step);
            world->world.detect();
        }
        EXPECT_EQ(contact_hash(again.world.contacts()), contact_hash(one.world.contacts())) << step;
    }
}

/// A world saved on some ranks goes on on others, and as one world.
TEST_P(RanksTest, GoOnOnAnotherNumberOfRanks) {
    const int ranks = size_of(MPI_COMM_WORLD), rank = rank_of(MPI_COMM_WORLD);
    std::string saved;
    {
        Many many = many_ranks(GetParam(), MPI_COMM_WORLD);
        many.add_all();
        for (int step = 0; step < 26; ++step) {
            many.put(step);
            if (step % 9 == 4) many.world.migrate();
            many.world.detect();
        }
        std::ostringstream out(std::ios::binary);
        many.world.save(out);
        saved = out.str();
    }
    std::uint64_t length = saved.size();
    MPI_Bcast(&length, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    saved.resize(length);
    MPI_Bcast(saved.data(), static_cast<int>(length), MPI_BYTE, 0, MPI_COMM_WORLD);
    One one = one_world(GetParam());
    one.add_all();
    for (int step = 0; step < 26; ++step) {
        one.put(step);
        one.world.detect();
    }
    std::istringstream alone(saved, std::ios::binary);
    World restored = World::restore(alone, bvh_backend());
    MPI_Comm fewer = MPI_COMM_NULL;
    MPI_Comm_split(MPI_COMM_WORLD, rank < (ranks + 1) / 2 ? 0 : 1, rank, &fewer);
    {
        std::istringstream in(saved, std::ios::binary);
        Many many(mpi::World::restore(fewer, in, bvh_backend()), GetParam(), rank_of(fewer),
                  size_of(fewer));
        many.learn_as_of(26);
        One again(std::move(restored), GetParam(), 0, 0);
        again.learn_as_of(26);
        for (int step = 26; step < 36; ++step) {
            one.put(step);
            many.put(step);
            again.put(step);
            again.world.detect();
            if (step == 31) many.world.migrate();
            ASSERT_TRUE(same_step(one, many, fewer)) << step;
            if (rank_of(fewer) == 0) {
                ASSERT_EQ(contact_hash(again.world.contacts()), contact_hash(one.world.contacts()));
            }
        }
    }
    MPI_Comm_free(&fewer);
}

/// Ranks that all have the whole world share its steps.
TEST_P(RanksTest, ShareAWorldThatAllHave) {
    const auto shared = [](int seed) {
        return mpi::ranks_backend(MPI_COMM_WORLD, (rank_of(MPI_COMM_WORLD) + seed) % 2
                                                      ? embree_backend(1)
                                                      : bvh_backend());
    };
    One one = one_world(GetParam()), all{World(shared(0), GetParam().settings), GetParam(), 0, 0};
    one.add_all();
    all.add_all();
    const int steps = GetParam().kind == Kind::sheets ? 30 : 60;
    for (int step = 0; step < steps; ++step) {
        one.put(step);
        all.put(step);
        if (step % 20 == 14) {
            std::stringstream saved(std::ios::in | std::ios::out | std::ios::binary);
            all.world.save(saved);
            all.world = World::restore(saved, shared(step));
        }
        one.world.detect();
        all.world.detect();
        bool same = contact_hash(all.world.contacts()) == contact_hash(one.world.contacts()) &&
                    all.world.contacts().size() == one.world.contacts().size();
        for (std::size_t c = 0; same && c < one.world.contacts().size(); ++c)
            same = all.world.contacts()[c].age == one.world.contacts()[c].age;
        EXPECT_EQ(all.world.stats().pairs, one.world.stats().pairs);
        EXPECT_EQ(all.world.stats().touching_pairs, one.world.stats().touching_pairs);
        EXPECT_EQ(all.world.stats().penetration_max, one.world.stats().penetration_max);
        EXPECT_EQ(all.world.body_boxes().size(), one.world.body_boxes().size());
        ASSERT_EQ(sum(same, MPI_COMM_WORLD), static_cast<std::uint64_t>(size_of(MPI_COMM_WORLD)))
            << step;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Swarms, RanksTest,
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
        Case{Kind::sheets, {}, "sheets"}, Case{Kind::worlds, {}, "worlds"},
        Case{Kind::torn, {}, "torn"}),
    [](const testing::TestParamInfo<Case>& tested) { return tested.param.name; });

/// Does without certificates and pair filters, as a device does.
class LikeADevice : public test::CountingBackend {
public:
    using CountingBackend::CountingBackend;
    bool certificates_pay() const override { return false; }
    bool calls_pair_filters() const override { return false; }
};

TEST(SharedWorldTest, OneRankHasADeviceAndOthersHaveNone) {
    test::Calls calls;
    const auto shared = [&]() -> std::unique_ptr<Backend> {
        if (rank_of(MPI_COMM_WORLD) > 0) return bvh_backend();
        return std::make_unique<LikeADevice>(bvh_backend(), calls);
    };
    for (const Kind kind : {Kind::rigid, Kind::soft}) {
        const Case tested{kind, {.may_rest = false}, ""};
        One one = one_world(tested),
            all{World(mpi::ranks_backend(MPI_COMM_WORLD, shared()), tested.settings), tested, 0, 0};
        EXPECT_THROW(all.world.set_pair_filter([](BodyId, BodyId) { return true; }), InputError);
        one.add_all();
        all.add_all();
        for (int step = 0; step < 30; ++step) {
            one.put(step);
            all.put(step);
            one.world.detect();
            all.world.detect();
            const bool same = contact_hash(all.world.contacts()) ==
                              contact_hash(one.world.contacts());
            ASSERT_EQ(sum(same, MPI_COMM_WORLD),
                      static_cast<std::uint64_t>(size_of(MPI_COMM_WORLD)))
                << step;
        }
        // Every rank knows what all of them did.
        const auto ranks = static_cast<std::size_t>(size_of(MPI_COMM_WORLD));
        EXPECT_EQ(all.world.stats().part_milliseconds.size(), ranks);
        for (const double milliseconds : all.world.stats().part_milliseconds)
            EXPECT_GT(milliseconds, 0);
        const std::vector<PlannedPart>& parts = all.world.plan().parts;
        ASSERT_EQ(parts.size(), ranks);
        std::size_t bodies = 0;
        for (const PlannedPart& part : parts) bodies += part.bodies;
        EXPECT_EQ(bodies, one.world.body_boxes().size());
        EXPECT_EQ(parts[0].backend, LikeADevice(bvh_backend(), calls).description());
        EXPECT_EQ(parts.back().backend, shared()->description());
        EXPECT_GT(parts.back().triangles, 0u);
    }
}

TEST(SharedWorldTest, AnyRankAnswersQuestionsAboutAllBodies) {
    const auto bodies = static_cast<std::uint32_t>(Swarms::bodies);
    for (const Kind kind : {Kind::soft, Kind::mixed}) {
        const Case tested{kind, {}, ""};
        One one = one_world(tested),
            all{World(mpi::ranks_backend(MPI_COMM_WORLD, bvh_backend()), tested.settings), tested,
                0, 0};
        one.add_all();
        all.add_all();
        int hits = 0, contacts = 0;
        for (int step = 0; step < 30; ++step) {
            one.put(step);
            all.put(step);
            one.world.detect();
            all.world.detect();
            if (step % 7 != 1) continue;
            SCOPED_TRACE(step);
            for (std::uint32_t b = 1; b < bodies; ++b) {
                const Vec3d middle = one.world.vertex_position(one.id(b), 0);
                const std::vector<Vec3d> along = {-middle, {0, 0.1, 1}, {1, 0.2, 0.1}};
                const Vec3d outside = middle - 30.0 * along[1];
                for (const Vec3d from : {outside, middle}) {
                    const auto expected = one.world.cast_rays(from, along),
                               found = all.world.cast_rays(from, along);
                    for (std::size_t k = 0; k < along.size(); ++k) {
                        ASSERT_EQ(found[k].has_value(), expected[k].has_value()) << b;
                        if (!found[k]) continue;
                        EXPECT_EQ(found[k]->body, expected[k]->body);
                        EXPECT_NEAR(found[k]->t, expected[k]->t, 1e-4);
                        ++hits;
                    }
                }
                const Vec3d normal = {0, 0, 1};
                const auto expected = one.world.probe({&middle, 1}, {&normal, 1}, 2),
                           found = all.world.probe({&middle, 1}, {&normal, 1}, 2);
                ASSERT_EQ(found[0].has_value(), expected[0].has_value()) << b;
                if (found[0]) {
                    EXPECT_EQ(found[0]->body, expected[0]->body);
                }
                for (std::uint32_t o = 1; o < bodies; ++o) {
                    if (o == b) continue;
                    const Reason wanted = one.world.explain(one.id(b), one.id(o), 3).reason,
                                 said = all.world.explain(one.id(b), one.id(o), 3).reason;
                    EXPECT_EQ(said == Reason::contact, wanted == Reason::contact) << b << " " << o;
                    contacts += wanted == Reason::contact;
                }
            }
        }
        EXPECT_GT(hits, 50);
        EXPECT_GT(contacts, 0);
    }
}

/// What a call throws.
template <class Error, class Call>
std::string message_of(const Call& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing thrown";
}

TEST(RanksFailTest, AllWithTheMessageOfOneAndGoOn) {
    const Case tested{Kind::soft, {}, "soft"};
    const int last = size_of(MPI_COMM_WORLD) - 1, rank = rank_of(MPI_COMM_WORLD);
    Many many{mpi::World(MPI_COMM_WORLD, std::make_unique<test::FailingBackend>(rank == last),
                         tested.settings),
              tested, rank, last + 1};
    One one = one_world(tested);
    one.add_all();
    many.add_all();
    for (int step = 0; step < 12; ++step) {
        one.put(step);
        many.put(step);
        if (step == 2) {
            EXPECT_EQ(message_of<std::runtime_error>([&] { many.world.detect(); }),
                      "rank " + std::to_string(last) + ": the device is gone");
            EXPECT_TRUE(many.world.contacts().empty());
            if (rank == 0) one.world.detect();
            continue;
        }
        many.world.detect();
        const std::vector<Contact> all = many.world.gather_contacts();
        bool same = true;
        if (rank == 0) {
            one.world.detect();
            same = contact_hash(all) == contact_hash(one.world.contacts());
            // Nothing is remembered after a failure.
            for (const Contact& c : all) EXPECT_LE(c.age, step < 3 ? step : step - 3);
        }
        ASSERT_TRUE(all_agree(same)) << step;
    }
}

TEST(RanksFailTest, WhereTwoHaveAddedTheSameBodyUntilOneIsRemoved) {
    const int ranks = size_of(MPI_COMM_WORLD), rank = rank_of(MPI_COMM_WORLD);
    mpi::World world(MPI_COMM_WORLD, bvh_backend());
    const MeshId box = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    EXPECT_EQ(world.uneven(), 1);
    world.detect();
    BodyId body;
    if (rank == 0 || rank == ranks - 1) body = world.add_rigid_body(4, box);
    if (ranks == 1) {
        EXPECT_THROW(world.add_rigid_body(4, box), InputError);
    } else {
        for (int again = 0; again < 2; ++again)
            EXPECT_EQ(
                message_of<InputError>([&] { world.detect(); }),
                "rank 0: body 4 was added on rank 0 and on rank " + std::to_string(ranks - 1));
        if (rank == ranks - 1) world.remove_body(body);
    }
    world.detect();
    EXPECT_EQ(world.bodies().size(), rank == 0 ? 1u : 0u);
    // The same where the first one is there already; the last rank cannot know.
    if (ranks == 1) return;
    if (rank == ranks - 1) body = world.add_rigid_body(4, box);
    for (int again = 0; again < 2; ++again)
        EXPECT_EQ(message_of<InputError>([&] { world.detect(); }),
                  "rank 0: body 4 was added on rank 0 and on rank " + std::to_string(ranks - 1));
    if (rank == ranks - 1) world.remove_body(body);
    world.detect();
}

TEST(RanksFailTest, WhatOnesBodiesAreNotIsRefused) {
    const int ranks = size_of(MPI_COMM_WORLD), rank = rank_of(MPI_COMM_WORLD);
    mpi::World world(MPI_COMM_WORLD, bvh_backend());
    EXPECT_EQ(world.rank(), rank);
    EXPECT_EQ(world.ranks(), ranks);
    const MeshId box = world.add_mesh("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    const auto number = static_cast<std::uint32_t>(rank);
    const BodyId own = world.add_rigid_body(number, box, {{0.5 * rank, 0, 0}, {}});
    world.detect();
    const BodyId others{static_cast<std::uint32_t>((rank + 1) % ranks), 1};
    if (ranks > 1) {
        const std::string refused = "body " + std::to_string(others.index) +
                                    " is not one of rank " + std::to_string(rank);
        EXPECT_EQ(message_of<InputError>([&] { world.set_pose(others, {}); }), refused);
        EXPECT_EQ(message_of<InputError>([&] { world.remove_body(others); }), refused);
        EXPECT_EQ(message_of<InputError>([&] { world.set_filter(others, {}); }), refused);
    }
    EXPECT_THROW(world.exclude(own, own), InputError);
    EXPECT_THROW(world.add_rigid_body(number, box), InputError);
    // Boxes in a row: each overlaps the next.
    const auto pairs = static_cast<std::uint32_t>(ranks - 1);
    EXPECT_EQ(sum(world.stats().touching_pairs, MPI_COMM_WORLD), pairs);
    if (rank == 0 && ranks > 1) world.exclude(own, others);
    world.detect();
    EXPECT_EQ(sum(world.stats().touching_pairs, MPI_COMM_WORLD), pairs - (ranks > 1));
    // Ranks with other settings cannot share a world.
    if (ranks > 1) {
        Settings settings;
        settings.margin = rank == 1 ? 0.5 : 0.25;
        EXPECT_THROW(mpi::World(MPI_COMM_WORLD, bvh_backend(), settings), InputError);
        settings.margin = rank == 1 ? -1 : 0.25;
        EXPECT_EQ(message_of<InputError>(
                      [&] { mpi::World impossible(MPI_COMM_WORLD, bvh_backend(), settings); }),
                  "rank 1: margin must be neither negative nor beyond 2^60");
    }
}

}  // namespace
}  // namespace pierce
