// The C API answers what the C++ API answers, bit for bit.
#include <gtest/gtest.h>
#include <pierce/pierce.h>

#include <atomic>
#include <cstring>

#include "pierce/contact_changes.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/contact_reduction.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/world.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

constexpr int body_count = 12, step_count = 6;

std::uint64_t number(BodyId id) { return std::uint64_t{id.generation} << 32 | id.index; }

#define WORKS(call) ASSERT_EQ(call, PIERCE_OK) << pierce_last_error()

/// One scene in both worlds: random meshes, every third body deforms, none is far away.
class SameContactsTest : public ::testing::Test {
protected:
    void SetUp() override { WORKS(pierce_create_world(nullptr, nullptr, &c_)); }
    void TearDown() override { pierce_destroy_world(c_); }

    void add_body(int i) {
        const MeshData data = test::random_closed_mesh(random_);
        const Pose pose = random_pose();
        pierce_mesh_id mesh = 0;
        WORKS(pierce_add_mesh(c_, "random", &data.positions[0].x, data.positions.size(),
                              data.triangles[0].vertex, data.triangles.size(), nullptr, &mesh));
        const MeshId own = cpp_.add_mesh("random", data);
        pierce_body_id body = 0;
        if (i % 3 == 0) {
            const auto positions = test::placed(data, pose);
            WORKS(pierce_add_deforming_body(c_, mesh, &positions[0].x, positions.size(), &body));
            own_.push_back(cpp_.add_deforming_body(own, positions));
        } else {
            WORKS(pierce_add_rigid_body(c_, mesh, numbers(pose).data(), &body));
            own_.push_back(cpp_.add_rigid_body(own, pose));
        }
        bodies_.push_back(body);
        meshes_.push_back(data);
    }

    void move(int i) {
        const Pose pose = random_pose();
        if (i % 3 == 0) {
            const auto positions = test::placed(meshes_[i], pose);
            WORKS(pierce_set_positions(c_, bodies_[i], &positions[0].x, positions.size()));
            cpp_.set_positions(own_[i], positions);
        } else {
            WORKS(pierce_set_pose(c_, bodies_[i], numbers(pose).data()));
            cpp_.set_pose(own_[i], pose);
        }
    }

    /// Steps both, and compares what they found.
    void step() {
        WORKS(pierce_detect(c_));
        const StepStats& stats = cpp_.detect();
        pierce_contact_list list{};
        WORKS(pierce_contacts(c_, &list));
        const auto contacts = cpp_.contacts();
        ASSERT_EQ(list.count, contacts.size());
        ASSERT_EQ(list.stride, sizeof(Contact));
        if (!contacts.empty()) {
            EXPECT_EQ(std::memcmp(list.contacts, contacts.data(), contacts.size_bytes()), 0);
        }
        std::uint64_t hash = 0;
        WORKS(pierce_contact_hash(&list, &hash));
        EXPECT_EQ(hash, contact_hash(contacts));
        pierce_step_stats own{};
        own.struct_size = sizeof own;
        WORKS(pierce_stats(c_, &own));
        EXPECT_EQ(own.contacts, stats.contacts);
        EXPECT_EQ(own.pairs, stats.pairs);
        EXPECT_EQ(own.penetration_max, stats.penetration_max);
        EXPECT_EQ(own.stage_count, stats.stages.size());
        EXPECT_EQ(own.at_rest != 0, stats.at_rest);
        found_ += contacts.size();
    }

    Pose random_pose() { return {random_.in_box(1.2), random_.rotation()}; }
    static std::array<double, 7> numbers(const Pose& p) {
        return {p.position.x, p.position.y, p.position.z, p.rotation.x,
                p.rotation.y, p.rotation.z, p.rotation.w};
    }

    test::Random random_{20260};
    pierce_world* c_ = nullptr;
    World cpp_{embree_backend()};
    std::vector<pierce_body_id> bodies_;
    std::vector<BodyId> own_;
    std::vector<MeshData> meshes_;
    std::size_t found_ = 0;
};

TEST_F(SameContactsTest, OfARandomSceneBitForBit) {
    SCOPED_TRACE("seed " + std::to_string(random_.seed()));
    for (int i = 0; i < body_count; ++i) add_body(i);
    for (int i = 0; i < body_count; ++i) EXPECT_EQ(bodies_[i], number(own_[i]));
    for (int i = 0; i < step_count; ++i) {
        step();
        move(random_.integer(0, body_count - 1));
    }
    EXPECT_GT(found_, 1000u);
}

TEST_F(SameContactsTest, OfBodiesAtRestAndOfStepsBefore) {
    SCOPED_TRACE("seed " + std::to_string(random_.seed()));
    for (int i = 0; i < body_count; ++i) add_body(i);
    std::vector<pierce_kept_contacts*> kept;
    std::vector<pierce_contact_list> lists;
    std::vector<KeptContacts> own;
    int rested = 0;
    for (int i = 0; i < 2 * step_count; ++i) {
        step();
        rested += cpp_.stats().at_rest;
        WORKS(pierce_keep_contacts(c_, &kept.emplace_back(), &lists.emplace_back()));
        own.push_back(cpp_.keep_contacts());
        if (i == step_count) move(1);
    }
    EXPECT_EQ(rested, 2 * step_count - 4);  // all but the first two, and two after the motion
    pierce_destroy_world(c_);
    c_ = nullptr;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        ASSERT_EQ(lists[i].count, own[i].count);
        EXPECT_EQ(std::memcmp(lists[i].contacts, own[i].first.get(), own[i].all().size_bytes()), 0);
        pierce_release_contacts(kept[i]);
    }
}

TEST_F(SameContactsTest, OfPairsThatTheCallerAllows) {
    SCOPED_TRACE("seed " + std::to_string(random_.seed()));
    for (int i = 0; i < body_count; ++i) add_body(i);
    step();
    const std::size_t of_all = found_;
    std::atomic<int> calls = 0;
    const auto allow = [](pierce_body_id a, pierce_body_id b, void* user) {
        ++*static_cast<std::atomic<int>*>(user);
        return static_cast<int>((a + b) % 3);
    };
    WORKS(pierce_set_pair_filter(c_, allow, &calls));
    cpp_.set_pair_filter([](BodyId a, BodyId b) { return (number(a) + number(b)) % 3 != 0; });
    step();
    EXPECT_GT(found_, of_all + 100);
    EXPECT_LT(found_, 2 * of_all);
    EXPECT_GT(calls, 20);
    WORKS(pierce_set_pair_filter(c_, nullptr, nullptr));
    cpp_.set_pair_filter({});
    const std::size_t before = found_;
    step();
    EXPECT_EQ(found_, before + of_all);
}

TEST_F(SameContactsTest, QuestionsHaveTheSameAnswers) {
    SCOPED_TRACE("seed " + std::to_string(random_.seed()));
    for (int i = 0; i < body_count; ++i) add_body(i);
    step();
    for (int b = 1; b < body_count; ++b) {
        pierce_explanation why{};
        why.struct_size = sizeof why;
        WORKS(pierce_explain(c_, bodies_[0], bodies_[b], 3, &why));
        const Explanation own = cpp_.explain(own_[0], own_[b], 3);
        EXPECT_EQ(why.reason, static_cast<unsigned>(own.reason));
        EXPECT_EQ(why.text, own.text());
        EXPECT_EQ(why.t, own.t);
        EXPECT_EQ(why.contact != nullptr, own.contact.has_value());

        pierce_common_volume common{};
        common.struct_size = sizeof common;
        WORKS(pierce_overlap(c_, bodies_[0], bodies_[b], 0.8, &common));
        const auto overlap = cpp_.overlap(own_[0], own_[b], 0.8);
        ASSERT_EQ(common.exists != 0, overlap.has_value());
        EXPECT_EQ(common.volume, overlap ? overlap->volume : 0);
        EXPECT_EQ(common.patch_count, overlap ? overlap->patches.size() : 0);
        EXPECT_EQ(common.turn[1], overlap ? overlap->turn.y : 0);

        pierce_translation way{};
        way.struct_size = sizeof way;
        WORKS(pierce_parting(c_, bodies_[0], bodies_[b], &way));
        const auto parting = cpp_.parting(own_[0], own_[b]);
        ASSERT_EQ(way.exists != 0, parting.has_value());
        EXPECT_EQ(way.depth, parting ? parting->depth : 0);
        EXPECT_EQ(way.direction[2], parting ? parting->direction.z : 0);
    }
    std::vector<Vec3d> lines;
    for (int i = 0; i < 64; ++i) lines.push_back(random_.unit_vector());
    std::vector<pierce_ray_hit> hits(lines.size());
    const Vec3d origin{0.1, 0.2, 0.3};
    WORKS(pierce_cast_rays(c_, &origin.x, &lines[0].x, lines.size(), hits.data()));
    const auto own = cpp_.cast_rays(origin, lines);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        EXPECT_EQ(hits[i].body, own[i] ? number(own[i]->body) : 0);
        EXPECT_EQ(hits[i].t, own[i] ? own[i]->t : 0);
    }
    std::vector<pierce_probe_contact> touched(lines.size());
    WORKS(
        pierce_probe(c_, &lines[0].x, &lines[0].x, lines.size(), 0.2, nullptr, 0, touched.data()));
    const auto probed = cpp_.probe(lines, lines, 0.2);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        EXPECT_EQ(touched[i].body, probed[i] ? number(probed[i]->body) : 0);
        EXPECT_EQ(touched[i].distance, probed[i] ? probed[i]->distance : 0);
    }
}

TEST_F(SameContactsTest, ListsAreReducedAndComparedAlike) {
    SCOPED_TRACE("seed " + std::to_string(random_.seed()));
    for (int i = 0; i < body_count; ++i) add_body(i);
    step();
    const std::vector<Contact> earlier(cpp_.contacts().begin(), cpp_.contacts().end());
    move(1);
    step();
    pierce_contact_list list{};
    WORKS(pierce_contacts(c_, &list));
    const pierce_contact_list before{reinterpret_cast<const pierce_contact*>(earlier.data()),
                                     earlier.size(), sizeof(Contact)};
    const auto changes = contact_changes(earlier, cpp_.contacts());
    std::vector<std::uint32_t> began(list.count), ended(earlier.size());
    std::size_t began_count = 0, stayed_count = 0, ended_count = 0;
    WORKS(pierce_contact_changes(&before, &list, began.data(), &began_count, nullptr, &stayed_count,
                                 ended.data(), &ended_count));
    began.resize(began_count);
    ended.resize(ended_count);
    EXPECT_EQ(began, changes.began);
    EXPECT_EQ(ended, changes.ended);
    EXPECT_EQ(stayed_count, changes.stayed.size());

    std::vector<pierce_reduced_contact> reduced(list.count);
    std::size_t count = 0;
    WORKS(pierce_reduce(&list, 7, reduced.data(), &count));
    const auto own = reduce(cpp_.contacts(), 7);
    ASSERT_EQ(count, own.size());
    for (std::size_t i = 0; i < count; ++i) {
        EXPECT_EQ(reduced[i].contact, own[i].contact);
        EXPECT_EQ(reduced[i].weight, own[i].weight);
    }
}

}  // namespace
}  // namespace pierce
