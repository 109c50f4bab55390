// Backends held against each other: agreement is found, and so is every kind of disagreement, with
// who is wrong.
#include "scenes/measure/validation.hpp"

#include <gmock/gmock.h>

#include "core/device/view.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/named/shapes.hpp"
#include "scenes/simulate/simulation.hpp"
#include "support/forwarding_backend.hpp"

namespace pierce::scenes {
namespace {

Recording pile(bool soft, int frames) {
    const SceneSetup scene = make_scene("tori", {8, soft, 3});
    Simulation simulation(scene, Method::rays, {"embree", 1});
    Recording recording = start_recording(scene, 1.0 / 60);
    for (int i = 0; i < 100 + frames; ++i) {
        if (i >= 100) simulation.record(recording);
        simulation.step(1.0 / 60);
    }
    return recording;
}

/// A pyramid that stands on its tip in the ground; the tip's ray leaves the ground through the
/// diagonal of its top if `x` is 0.
Recording pyramid(float x) {
    MeshData tip{{{0, 0, 0}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}, {}};
    tip.triangles = {{{0, 2, 1}}, {{0, 3, 2}}, {{0, 4, 3}}, {{0, 1, 4}}, {{1, 2, 3}}, {{1, 3, 4}}};
    SceneSetup scene{
        "pyramid", {{"ground", box({-5, -5, -1}, {5, 5, 0}), {}}, {"tip", tip, {}}}, {}};
    scene.bodies = {{"ground", 0, Motion::fixed, {}, true}, {"tip", 1, Motion::rigid, {}, false}};
    Recording recording = start_recording(scene, 0.01);
    recording.frame_count = 1;
    recording.bodies[0].values = {0, 0, 0, 0, 0, 0, 1};
    recording.bodies[1].values = {x, 0, -0.1f, 0, 0, 0, 1};
    return recording;
}

/// A backend whose contacts are tampered with in one step.
class Tampering : public test::ForwardingBackend {
public:
    using Tamper = std::function<void(std::vector<Contact>&)>;
    Tampering(std::uint32_t step, Tamper tamper)
        : ForwardingBackend(bvh_backend()), step_(step), tamper_(std::move(tamper)) {}

    std::string description() const override { return "tampering"; }
    void step(const Scene& scene, StepStats& stats) override {
        ForwardingBackend::step(scene, stats);
        const View<const Contact> honest = inner().contacts();
        contacts_.assign(honest.begin(), honest.end());
        if (steps_++ == step_) tamper_(contacts_);
    }
    View<const Contact> contacts() const override { return view_of(contacts_); }

private:
    std::uint32_t step_, steps_ = 0;
    Tamper tamper_;
    std::vector<Contact> contacts_;
};

std::vector<Candidate> honest_and(std::uint32_t step, Tampering::Tamper tamper) {
    std::vector<Candidate> candidates;
    candidates.push_back({"tampering", std::make_unique<Tampering>(step, std::move(tamper))});
    candidates.push_back({"bvh", bvh_backend()});
    return candidates;
}

std::vector<Candidate> all_honest() {
    std::vector<Candidate> candidates;
    candidates.push_back({"reference", reference_backend()});
    candidates.push_back({"bvh", bvh_backend()});
    candidates.push_back({"embree", embree_backend(2)});
    return candidates;
}

TEST(ValidationTest, HonestBackendsAgree) {
    for (bool soft : {false, true}) {
        const Recording recording = pile(soft, 20);
        for (Coverage coverage : {Coverage::vertices, Coverage::overlaps, Coverage::complete}) {
            std::uint32_t done = 0;
            const Validation result = validate(recording, all_honest(), {.coverage = coverage}, 3,
                                               [&](std::uint32_t frames) { done = frames; });
            EXPECT_EQ(result.differing_frames, 0u);
            EXPECT_TRUE(result.wrong.empty());
            EXPECT_EQ(result.frames, 7u);
            EXPECT_EQ(done, 19u);
            ASSERT_EQ(result.results.size(), 3u);
            for (const Validation::Result& r : result.results) {
                EXPECT_EQ(r.contacts, result.results[0].contacts);
                EXPECT_EQ(r.ms.size(), 7u);
            }
            EXPECT_GT(result.results[0].contacts, 100u);
        }
    }
}

TEST(ValidationTest, TheJudgeSaysOfAPairWhatTheReferenceSaysOfAllBodies) {
    for (bool soft : {false, true}) {
        const Recording recording = pile(soft, 5);
        for (const Settings& settings :
             {Settings{}, Settings{.coverage = Coverage::complete, .reproject = true}}) {
            const auto reference = make_detector(scene_of(recording), reference_backend(),
                                                 settings);
            Judge judge(recording, settings, 2);
            for (std::uint32_t f = 0; f < recording.frame_count; f += 2) {
                put_frame(*reference, recording, f);
                const FrameResult expected = reference->detect();
                EXPECT_GT(expected.touching.size(), 5u);
                std::vector<Contact> all;
                for (const auto& [a, b] : expected.touching)
                    for (const Contact& c : judge.judge(f, a, b).contacts) all.push_back(c);
                EXPECT_EQ(contact_hash(all), expected.hash)
                    << "frame " << f << (soft ? ", soft" : "");
            }
        }
    }
}

TEST(ValidationTest, FindsEveryKindOfDifference) {
    const Recording recording = pile(false, 1);
    const auto detector = make_detector(scene_of(recording), bvh_backend(),
                                        {.coverage = Coverage::complete});
    put_frame(*detector, recording, 0);
    detector->detect();
    const std::vector<Contact> right(detector->world()->contacts().begin(),
                                     detector->world()->contacts().end());
    ASSERT_GT(right.size(), 20u);
    EXPECT_TRUE(differences(right, right).empty());
    EXPECT_EQ(differences({}, right).size(), right.size());
    EXPECT_EQ(differences(right, {}).size(), right.size());

    std::vector<Contact> broken = right;
    broken[3].triangle += 1;
    broken[5].distance = std::nextafter(broken[5].distance, 1.0);
    broken[7].age += 1;  // how old a contact is, and how it was found, is the backend's own
                         // business
    broken.erase(broken.begin() + 11);
    broken.push_back(broken.back());
    broken.back().vertex += 1;
    broken.back().edge += 1;
    const std::vector<ContactDifference> found = differences(broken, right);
    ASSERT_EQ(found.size(), 4u);
    EXPECT_EQ(found[0].found->triangle, right[3].triangle + 1);
    EXPECT_EQ(found[0].right->triangle, right[3].triangle);
    EXPECT_NE(found[1].found->distance, found[1].right->distance);
    EXPECT_FALSE(found[2].found) << "one that is missing";
    EXPECT_EQ(contact_hash({&*found[2].right, 1}), contact_hash({&right[11], 1}));
    EXPECT_FALSE(found[3].right) << "one that should not be";

    broken = right;
    std::swap(broken[0], broken[1]);
    EXPECT_FALSE(differences(broken, right).empty()) << "the order counts";
}

TEST(ValidationTest, SaysWhichBackendIsWrongAndAboutWhat) {
    const Recording recording = pile(false, 6);
    const auto drop_third = [](std::vector<Contact>& contacts) {
        contacts.erase(contacts.begin() + 2);
    };
    const Validation dropped = validate(recording, honest_and(4, drop_third), {});
    EXPECT_EQ(dropped.differing_frames, 1u);
    EXPECT_EQ(dropped.results[0].wrong_frames, 1u);
    EXPECT_EQ(dropped.results[0].wrong_contacts, 1u);
    EXPECT_EQ(dropped.results[1].wrong_contacts, 0u);
    ASSERT_EQ(dropped.wrong.size(), 1u);
    EXPECT_EQ(dropped.wrong[0].frame, 4u);
    EXPECT_EQ(dropped.wrong[0].candidate, 0u);
    EXPECT_FALSE(dropped.wrong[0].difference.found);
    EXPECT_EQ(dropped.results[0].contacts + 1, dropped.results[1].contacts);

    const auto other_triangle = [](std::vector<Contact>& contacts) {
        contacts.back().triangle ^= 1;
    };
    const Validation changed = validate(recording, honest_and(0, other_triangle),
                                        {.coverage = Coverage::complete});
    ASSERT_EQ(changed.wrong.size(), 1u);
    EXPECT_EQ(changed.wrong[0].candidate, 0u);
    EXPECT_EQ(changed.wrong[0].difference.found->triangle ^ 1,
              changed.wrong[0].difference.right->triangle);
    EXPECT_EQ(validate(recording, honest_and(6, other_triangle), {}).differing_frames, 0u);
}

TEST(ValidationTest, SaysWhichContactsAreNearTies) {
    const auto drop_all = [](std::vector<Contact>& contacts) { contacts.clear(); };
    for (float x : {0.f, 0.5f}) {
        // Where the edges are looked at, another contact lies on the ridge.
        const Validation result = validate(pyramid(x), honest_and(0, drop_all),
                                           {.coverage = Coverage::vertices});
        ASSERT_EQ(result.wrong.size(), 1u) << x;
        EXPECT_NEAR(result.wrong[0].difference.right->penetration_depth(), 0.1, 1e-6);
        EXPECT_EQ(result.wrong[0].near_tie, x == 0) << x;
        EXPECT_EQ(result.results[0].near_ties, x == 0 ? 1u : 0u);
    }
}

TEST(ValidationTest, InThePapersModeTheReferenceDecidesThatFollowsTheFrames) {
    const auto drop_third = [](std::vector<Contact>& contacts) {
        contacts.erase(contacts.begin() + 2);
    };
    for (bool soft : {false, true}) {
        const Recording recording = pile(soft, 24);
        for (bool predict : {false, true}) {
            const Settings settings{.temporal = Temporal::paper, .predict = predict};
            const Validation honest = validate(recording, all_honest(), settings);
            EXPECT_EQ(honest.differing_frames, 0u);
            EXPECT_GT(honest.results[0].contacts, 500u);
            // In a frame between full passes, brute force without memory has more contacts.
            const Validation dropped = validate(recording, honest_and(21, drop_third), settings);
            EXPECT_EQ(dropped.differing_frames, 1u);
            EXPECT_EQ(dropped.results[0].wrong_contacts, 1u);
            EXPECT_EQ(dropped.results[1].wrong_contacts, 0u);
            ASSERT_EQ(dropped.wrong.size(), 1u);
            EXPECT_EQ(dropped.wrong[0].frame, 21u);
            EXPECT_FALSE(dropped.wrong[0].difference.found);
            EXPECT_FALSE(dropped.wrong[0].near_tie);
        }
    }
}

TEST(ValidationTest, NeedsTwo) {
    std::vector<Candidate> one;
    one.push_back({"bvh", bvh_backend()});
    EXPECT_THROW(validate(pyramid(0), std::move(one), {}), InputError);
}

}  // namespace
}  // namespace pierce::scenes
