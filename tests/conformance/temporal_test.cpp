// Steps that remember: the certified mode against tracing everything, the paper's mode where it
// must and where it may differ.
#include <gtest/gtest.h>

#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/named/shapes.hpp"
#include "scenes/recording/lattice.hpp"
#include "scenes/recording/recording.hpp"
#include "scenes/simulate/simulation.hpp"
#include "support/backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

Settings with(Temporal temporal, bool predict = false) {
    Settings settings = vertex_rays;
    settings.temporal = temporal;
    settings.predict = predict;
    settings.may_rest = false;
    return settings;
}

Settings without_memory(Settings settings) {
    settings.temporal = Temporal::off;
    return settings;
}

class TemporalTest : public testing::TestWithParam<test::NamedBackend> {};

/// Bodies that rest, creep, slide, spin, jump, deform, vanish, break and change their triangles, in
/// two worlds alike.
class TwoWorlds {
public:
    TwoWorlds(const test::NamedBackend& backend, Settings settings, test::Random& random)
        : random_(random),
          plain_(backend.make(), without_memory(settings)),
          remembering_(backend.make(), settings) {
        for (int i = 0; i < 5; ++i) add_body();
    }

    World& plain() { return plain_; }
    World& remembering() { return remembering_; }

    void step() {
        const double size = std::pow(10.0, random_.uniform(-5, -1));
        for (Body& body : bodies_) {
            if (random_.integer(0, 9) == 0) body.rests = !body.rests;
            if (body.rests) continue;
            const Vec3d turn = size * random_.in_box(0.3);
            body.pose.position += size * random_.in_box(1);
            const Quaternion q = body.pose.rotation;
            body.pose.rotation = {q.x + turn.x, q.y + turn.y, q.z + turn.z, q.w};
            if (random_.integer(0, 60) == 0) body.pose = {random_.in_box(0.9), random_.rotation()};
            body.bend += size * random_.uniform(-0.5, 0.5);
            put(body, random_.integer(0, 40) == 0);
        }
        if (random_.integer(0, 20) == 0) {
            const auto i = static_cast<std::size_t>(
                random_.integer(0, static_cast<int>(bodies_.size()) - 1));
            for (World* world : {&plain_, &remembering_}) world->remove_body(bodies_[i].id);
            bodies_.erase(bodies_.begin() + static_cast<std::ptrdiff_t>(i));
            add_body();
        }
        plain_.detect();
        remembering_.detect();
    }

private:
    struct Body {
        BodyId id;
        MeshData data;
        Pose pose;
        double bend = 0;
        bool deforms = false, rests = false;
    };

    void add_body() {
        Body body{{}, test::random_closed_mesh(random_), {random_.in_box(0.8), random_.rotation()}};
        const int kind = random_.integer(0, 3);
        body.deforms = kind >= 2;
        for (World* world : {&plain_, &remembering_}) {
            const MeshId mesh = world->add_mesh("body", body.data);
            body.id = body.deforms ? world->add_deforming_body(mesh)
                      : kind == 0  ? world->add_fixed_body(mesh)
                                   : world->add_rigid_body(mesh);
        }
        bodies_.push_back(body);
        put(bodies_.back(), false);
    }

    void put(Body& body, bool special) {
        if (!body.deforms) {
            Pose pose = body.pose;
            if (special) pose.position.x = std::nan("");  // left out for a step
            for (World* world : {&plain_, &remembering_}) world->set_pose(body.id, pose);
            return;
        }
        if (special) {
            body.data = test::random_closed_mesh(random_);
            body.bend = 0;
        }
        MeshData bent = body.data;
        for (Vec3f& p : bent.positions) p.z += static_cast<float>(body.bend) * p.x * p.x;
        const std::vector<Vec3f> positions = test::placed(bent, body.pose);
        for (World* world : {&plain_, &remembering_}) {
            if (special)
                world->set_mesh(body.id, world->add_mesh("other", body.data), positions);
            else
                world->set_positions(body.id, positions);
        }
    }

    test::Random& random_;
    World plain_, remembering_;
    std::vector<Body> bodies_;
};

std::vector<std::uint32_t> ages(const World& world) {
    std::vector<std::uint32_t> result;
    for (const Contact& c : world.contacts()) result.push_back(c.age);
    return result;
}

TEST_P(TemporalTest, CertifiedIsTracingEverything) {
    test::Random random(21);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::uint64_t contacts = 0, certified = 0, walks = 0, full = 0, plain = 0;
    for (int scene = 0; scene < 8; ++scene) {
        Settings settings = with(Temporal::certified);
        settings.coverage = scene % 3 == 2   ? Coverage::complete
                            : scene % 3 == 1 ? Coverage::overlaps
                                             : Coverage::vertices;
        settings.reproject = scene % 4 == 3;
        TwoWorlds worlds(GetParam(), settings, random);
        for (int step = 0; step < 60; ++step) {
            worlds.step();
            ASSERT_EQ(contact_hash(worlds.remembering().contacts()),
                      contact_hash(worlds.plain().contacts()))
                << "scene " << scene << " step " << step;
            ASSERT_EQ(ages(worlds.remembering()), ages(worlds.plain()))
                << "scene " << scene << " step " << step;
            const StepStats& stats = worlds.remembering().stats();
            contacts += stats.contacts;
            certified += stats.certified;
            walks += stats.walks;
            full += stats.rays;
            plain += worlds.plain().stats().rays;
        }
    }
    EXPECT_GT(contacts, 20000u);
    if (!GetParam().make()->certificates_pay()) return;
    EXPECT_GT(certified, 500u);
    EXPECT_GT(walks, 10000u);
    EXPECT_LT(full, plain) << "it saves rays";
}

TEST_P(TemporalTest, ABodyThatGrowsASpikeIsSeenToTouch) {
    // Its frame hardly moves and most of it stays as it is: only the motion of the shape itself
    // tells.
    World certified(GetParam().make(), with(Temporal::certified)),
        plain(GetParam().make(), with(Temporal::off));
    const MeshData ball = scenes::sphere(1, 4);
    for (World* world : {&certified, &plain}) {
        world->add_fixed_body(world->add_mesh("plate", scenes::box({-5, -5, -1}, {5, 5, 0})));
        world->add_deforming_body(world->add_mesh("ball", ball));
    }
    std::size_t most = 0;
    for (int i = 0; i < 60; ++i) {
        MeshData now = ball;
        for (Vec3f& p : now.positions) {
            const float below = std::max(-p.z - 0.95f, 0.0f) / 0.05f;
            p.z += 1.9f - 0.02f * static_cast<float>(i) * below;
        }
        for (World* world : {&certified, &plain}) {
            world->set_positions({1, 1}, now.positions);
            world->detect();
        }
        most = std::max(most, plain.contacts().size());
        ASSERT_EQ(contact_hash(certified.contacts()), contact_hash(plain.contacts()))
            << "step " << i;
    }
    EXPECT_GT(most, 3u);
}

TEST_P(TemporalTest, PaperModeHoldsNothingStale) {
    test::Random random(22);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t seen = 0;
    for (bool predict : {false, true})
        for (int scene = 0; scene < 3; ++scene) {
            TwoWorlds worlds(GetParam(), with(Temporal::paper, predict), random);
            for (int step = 0; step < 60; ++step) {
                worlds.step();
                seen += worlds.remembering().contacts().size();
                for (const Contact& c : worlds.remembering().contacts()) {
                    // Whatever it missed, what it reports is there: on the hit triangle, at the
                    // depth it says.
                    const BodyId target = c.source == Side::a ? c.b : c.a;
                    const Mesh& mesh = worlds.remembering().mesh(
                        worlds.remembering().mesh_of(target));
                    ASSERT_LT(c.triangle, mesh.triangles().size());
                    Vec3d q;
                    for (int k = 0; k < 3; ++k)
                        q += c.barycentric[k] * worlds.remembering().vertex_position(
                                                    target, mesh.triangles()[c.triangle].vertex[k]);
                    EXPECT_NEAR(length(q - (c.source == Side::a ? c.point_b : c.point_a)), 0, 1e-6);
                    EXPECT_NEAR(dot(c.point_b - c.point_a, c.normal), c.distance, 1e-5);
                }
            }
        }
    EXPECT_GT(seen, 1000u);
}

/// A ball that sinks into a plate. The paper's mode does not see vertices that enter between full
/// passes; prediction does.
struct Sinking {
    World world;
    BodyId ball;

    explicit Sinking(const test::NamedBackend& backend, Settings settings, bool deforming = false)
        : world(backend.make(), settings) {
        world.add_fixed_body(world.add_mesh("plate", scenes::box({-5, -5, -1}, {5, 5, 0})));
        const MeshId mesh = world.add_mesh("ball", scenes::sphere(1, 3));
        ball = deforming ? world.add_deforming_body(mesh) : world.add_rigid_body(mesh);
    }

    std::size_t at(double height) {
        if (world.motion_of(ball) == Motion::deforming)
            world.set_positions(ball, test::placed(scenes::sphere(1, 3), {{0, 0, height}, {}}));
        else
            world.set_pose(ball, {{0, 0, height}, {}});
        world.detect();
        return world.contacts().size();
    }
};

TEST_P(TemporalTest, PredictionSeesVerticesEnterBetweenFullPasses) {
    for (bool deforming : {false, true}) {
        std::size_t missed = 0, missed_with_prediction = 0, total = 0;
        std::uint32_t came_true = 0;
        Sinking plain(GetParam(), with(Temporal::off), deforming),
            paper(GetParam(), with(Temporal::paper), deforming),
            predicting(GetParam(), with(Temporal::paper, true), deforming);
        for (int i = 0; i < 60; ++i) {
            const double height = 1.02 - 0.002 * i;
            const std::size_t expected = plain.at(height);
            total += expected;
            missed += expected - paper.at(height);
            const std::size_t found = predicting.at(height);
            missed_with_prediction += expected - found;
            came_true += predicting.world.stats().predictions_true;
        }
        EXPECT_GT(total, 500u);
        EXPECT_GT(missed, 20u);
        EXPECT_EQ(missed_with_prediction, 0u);
        EXPECT_GT(came_true, 20u);
    }
}

// The motion is known from the second step on. To guess it would cost a ray of nearly every vertex.
TEST_P(TemporalTest, PredictsNothingBeforeItKnowsTheMotion) {
    for (bool deforming : {false, true}) {
        Sinking paper(GetParam(), with(Temporal::paper), deforming),
            predicting(GetParam(), with(Temporal::paper, true), deforming);
        // The ball is in the plate already, so that bodies are a pair from the start.
        paper.at(0.95);
        predicting.at(0.95);
        EXPECT_EQ(predicting.world.stats().rays, paper.world.stats().rays);
        EXPECT_EQ(predicting.world.stats().predictions, 0u);
        predicting.at(0.94);
        EXPECT_EQ(predicting.world.stats().full_passes, 1u);
        EXPECT_GT(predicting.world.stats().predictions, 0u);
        predicting.at(0.93);
        EXPECT_EQ(predicting.world.stats().full_passes, 0u);
    }
}

TEST_P(TemporalTest, FullPassesComeEveryKSteps) {
    Settings settings = with(Temporal::paper);
    settings.full_every = 4;
    Sinking scene(GetParam(), settings);
    int full = 0;
    for (int i = 0; i < 40; ++i) {
        scene.at(0.95 - 1e-4 * i);
        full += static_cast<int>(scene.world.stats().full_passes);
    }
    EXPECT_NEAR(full, 10, 1);
    // A displacement of more than two edges forces one at once.
    for (int i = 0; i < 8; ++i) {
        scene.at(0.3 + 0.65 * (i % 2));
        EXPECT_EQ(scene.world.stats().full_passes, 1u);
    }
}

TEST_P(TemporalTest, ASmallBodyOnAHugeOneIsWalked) {
    // The ball turns, so that a far end of the plate goes a long way, seen from it. The ball's
    // vertices do not.
    Settings settings = with(Temporal::paper);
    World world(GetParam().make(), settings);
    world.add_fixed_body(world.add_mesh("plate", scenes::box({-500, -500, -1}, {500, 500, 0})));
    const BodyId ball = world.add_rigid_body(world.add_mesh("ball", scenes::sphere(1, 3)));
    std::uint32_t walked = 0, contacts = 0;
    for (int i = 0; i < 40; ++i) {
        world.set_pose(ball, {{0, 0, 0.9}, {0, 0, 0.002 * i, 1}});
        world.detect();
        for (const Contact& c : world.contacts()) walked += c.found == Found::walk;
        contacts += world.stats().contacts;
    }
    EXPECT_GT(contacts, 500u);
    EXPECT_GT(walked, contacts * 3 / 4);
}

TEST_P(TemporalTest, B4ANearerSheetIsSeenByTheNextFullPass) {
    // A flat plate comes up inside the ball's vertex' way to the far side of a box: the walk stays
    // on the far side.
    Settings settings = with(Temporal::paper);
    settings.full_every = 5;
    World world(GetParam().make(), settings), plain(GetParam().make(), with(Temporal::off));
    MeshData fold = scenes::box({-2, -2, -2}, {2, 2, 0.5});
    // A slot cut by hand: the inner walls of a thin box, turned inside out, inside the block.
    const MeshData slot = scenes::box({-1.5, -1.5, -0.2}, {1.5, 1.5, -0.19});
    for (Triangle t : slot.triangles)
        fold.triangles.push_back({{t.vertex[0] + 8, t.vertex[2] + 8, t.vertex[1] + 8}});
    fold.positions.insert(fold.positions.end(), slot.positions.begin(), slot.positions.end());
    for (World* w : {&world, &plain}) {
        w->add_deforming_body(w->add_mesh("fold", fold));
        w->add_rigid_body(w->add_mesh("spike", scenes::box({-0.1, -0.1, -0.3}, {0.1, 0.1, 3})));
    }
    int late = 0, differ = 0;
    for (int i = 0; i < 20; ++i) {
        // The slot's walls move up past the spike's end, so that they come between it and the
        // block's top.
        std::vector<Vec3f> positions = fold.positions;
        for (std::size_t v = 8; v < positions.size(); ++v)
            positions[v].z += 0.01f * static_cast<float>(i) - 0.2f;
        for (World* w : {&world, &plain}) {
            w->set_positions({0, 1}, positions);
            w->detect();
        }
        const bool same = contact_hash(world.contacts()) == contact_hash(plain.contacts());
        late = same ? 0 : late + 1;
        differ += !same;
        EXPECT_LT(late, 5) << "a full pass must have come in between";
    }
    EXPECT_GT(differ, 0) << "and this is a case in which it matters";
}

TEST_P(TemporalTest, B5ClothSlidingInItsPlaneHasNoContacts) {
    for (Temporal temporal : {Temporal::off, Temporal::paper, Temporal::certified}) {
        World world(GetParam().make(), with(temporal, true));
        MeshData sheet{{}, {}};
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 6; ++x)
                sheet.positions.push_back(
                    {0.2f * static_cast<float>(x), 0.2f * static_cast<float>(y), 0});
        for (std::uint32_t y = 0; y < 5; ++y)
            for (std::uint32_t x = 0; x < 5; ++x) {
                const std::uint32_t v = 6 * y + x;
                sheet.triangles.push_back({{v, v + 1, v + 6}});
                sheet.triangles.push_back({{v + 1, v + 7, v + 6}});
            }
        const MeshId mesh = world.add_mesh("sheet", sheet);
        const BodyId a = world.add_deforming_body(mesh);
        world.add_deforming_body(mesh);
        for (int i = 0; i < 12; ++i) {
            std::vector<Vec3f> positions = sheet.positions;
            for (Vec3f& p : positions) p.x += 0.01f * static_cast<float>(i);
            world.set_positions(a, positions);
            world.detect();
            EXPECT_TRUE(world.contacts().empty());
        }
    }
}

TEST_P(TemporalTest, B6B7RecordsDieWithTopologyAndBodies) {
    for (Temporal temporal : {Temporal::paper, Temporal::certified}) {
        Sinking scene(GetParam(), with(temporal, true), true);
        const std::size_t before = scene.at(0.9);
        EXPECT_GT(before, 0u);
        EXPECT_EQ(scene.at(0.9), before);
        // Triangles that only happen to be the same.
        scene.world.set_mesh(scene.ball, scene.world.add_mesh("twin", scenes::sphere(1, 3)),
                             test::placed(scenes::sphere(1, 3), {{0, 0, 0.9}, {}}));
        scene.world.detect();
        EXPECT_EQ(scene.world.contacts().size(), before);
        for (const Contact& c : scene.world.contacts()) EXPECT_EQ(c.age, 0u);
        // Other triangles: fewer vertices than the records name.
        const MeshData coarse = scenes::sphere(1, 1);
        scene.world.set_mesh(scene.ball, scene.world.add_mesh("coarse", coarse),
                             test::placed(coarse, {{0, 0, 0.9}, {}}));
        scene.world.detect();
        for (const Contact& c : scene.world.contacts()) {
            EXPECT_LT(c.vertex, coarse.positions.size());
            EXPECT_EQ(c.age, 0u);
            EXPECT_EQ(c.found, Found::full);
        }
        scene.world.remove_body(scene.ball);
        scene.world.detect();
        EXPECT_TRUE(scene.world.contacts().empty());
        const MeshId mesh = scene.world.add_mesh("ball", scenes::sphere(1, 3));
        scene.ball = scene.world.add_rigid_body(mesh);
        EXPECT_EQ(scene.at(0.9), before);
        for (const Contact& c : scene.world.contacts())
            EXPECT_EQ(c.age, 0u) << "another body in the same slot";
    }
}

TEST_P(TemporalTest, BodiesThatJumpOrPartLeaveNothingBehind) {
    for (Temporal temporal : {Temporal::paper, Temporal::certified}) {
        Sinking scene(GetParam(), with(temporal, true)), plain(GetParam(), with(Temporal::off));
        for (double height : {0.9, 0.9, 0.5, 3.0, 0.9, 0.9, 20.0, 20.0, 0.8}) {
            const std::size_t expected = plain.at(height);
            EXPECT_EQ(scene.at(height), expected) << "height " << height;
        }
    }
}

TEST_P(TemporalTest, ContactsOfBodiesThatRestCostNoRays) {
    if (!GetParam().make()->certificates_pay()) GTEST_SKIP() << "it traces everything";
    for (const Coverage coverage : {Coverage::vertices, Coverage::overlaps, Coverage::complete}) {
        SCOPED_TRACE("coverage " + std::to_string(static_cast<int>(coverage)));
        Settings settings = with(Temporal::certified);
        settings.coverage = coverage;
        settings.reproject = coverage != Coverage::vertices;
        Sinking scene(GetParam(), settings), plain(GetParam(), without_memory(settings));
        const auto rays = [&] { return scene.world.stats().rays + scene.world.stats().walks; };
        const auto expect_same = [&](const char* when) {
            EXPECT_EQ(contact_hash(scene.world.contacts()), contact_hash(plain.world.contacts()))
                << when;
            EXPECT_EQ(ages(scene.world), ages(plain.world)) << when;
        };
        for (int step = 0; step < 4; ++step) {
            EXPECT_GT(scene.at(0.9), 0u);
            plain.at(0.9);
            expect_same("at rest");
            EXPECT_EQ(rays() == 0, step > 0) << "step " << step;
        }
        for (double height : {std::nextafter(0.9, 1.0), 0.9, -0.0, 0.0}) {
            scene.at(height);
            plain.at(height);
            expect_same("moved");
            EXPECT_GT(rays(), 0u) << "moved by as little as can be: " << height;
        }
    }
}

/// Bars that cross and a ball within a ball, of which one bar moves once.
void expect_contacts_kept(const test::NamedBackend& backend, Coverage coverage) {
    SCOPED_TRACE("coverage " + std::to_string(static_cast<int>(coverage)));
    Settings settings = with(Temporal::certified);
    settings.coverage = coverage;
    settings.reproject = true;
    World kept(backend.make(), settings), plain(backend.make(), without_memory(settings));
    // On edge, and then turned by about a right angle.
    const double half_sine = std::sin(0.4), half_cosine = std::cos(0.4);
    const Quaternion on_edge{half_sine, 0, 0, half_cosine},
        across{0.65 * half_sine, 0.76 * half_sine, 0.76 * half_cosine, 0.65 * half_cosine};
    const auto add = [&](World& world) {
        // Two bars that cross like an X, edge on edge, and a small ball in a large one.
        const MeshId bar = world.add_mesh("bar", scenes::box({-2, -0.2, -0.2}, {2, 0.2, 0.2})),
                     ball = world.add_mesh("ball", scenes::sphere(1, 2)),
                     small = world.add_mesh("small", scenes::sphere(0.2, 1));
        world.add_rigid_body(bar, {{0, 0, 0}, on_edge});
        const BodyId moves = world.add_rigid_body(bar, {{0, 0, 0.5}, across});
        world.add_rigid_body(ball, {{10, 0, 0}, {}});
        world.add_rigid_body(small, {{10.1, 0, 0.1}, {}});
        return moves;
    };
    const BodyId moves = add(kept);
    add(plain);
    std::uint32_t of_edges = 0, of_separation = 0;
    for (int step = 0; step < 9; ++step) {
        const double height = step < 5 ? 0.5 : 0.499;
        for (World* world : {&kept, &plain}) {
            world->set_pose(moves, {{0, 0, height}, across});
            world->detect();
        }
        EXPECT_EQ(contact_hash(kept.contacts()), contact_hash(plain.contacts())) << step;
        EXPECT_EQ(ages(kept), ages(plain)) << step;
        const bool rests = step > 0 && step != 5;
        EXPECT_EQ(kept.stats().rays == 0, rests) << step;
        EXPECT_EQ(kept.stats().separated_pairs == 0, step > 0) << step;
        of_edges += kept.stats().edge_contacts;
        for (const Contact& c : kept.contacts()) of_separation += c.found == Found::separation;
    }
    EXPECT_GT(of_edges, 0u);
    EXPECT_GT(of_separation, 0u);
}

TEST_P(TemporalTest, ContactsOfEdgesAndOfContainedBodiesAreKeptWhileNothingMoves) {
    if (!GetParam().make()->certificates_pay()) GTEST_SKIP() << "it traces everything";
    for (const Coverage coverage : {Coverage::overlaps, Coverage::complete})
        expect_contacts_kept(GetParam(), coverage);
}

INSTANTIATE_TEST_SUITE_P(Backends, TemporalTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

/// Certified against off on every frame of simulated scenes.
using namespace scenes;

TEST(TemporalScenesTest, CertifiedGivesTheSameHashOnEveryFrame) {
    for (const char* name : {"tori", "bunnies"})
        for (bool soft : {false, true}) {
            const SceneSetup scene = make_scene(name, {12, soft, 3});
            Simulation simulation(scene, Method::rays, {"embree", 2});
            Recording recording = start_recording(scene, 1.0 / 60);
            for (int i = 0; i < 300; ++i) {
                simulation.record(recording);
                simulation.step(1.0 / 60);
            }
            for (bool vertices : {false, true}) {
                if (vertices && soft) continue;
                const Recording played = vertices ? as_deforming(recording) : recording;
                RaySettings off{"embree", 2}, certified{"embree", 2};
                off.world.coverage = name == std::string("bunnies") ? Coverage::overlaps
                                                                    : Coverage::vertices;
                certified.world.coverage = off.world.coverage;
                off.world.temporal = Temporal::off;
                certified.world.temporal = Temporal::certified;
                certified.world.may_rest = false;
                const auto a = make_detector(scene_of(played), Method::rays, off);
                const auto b = make_detector(scene_of(played), Method::rays, certified);
                std::uint64_t rays[2] = {};
                for (std::uint32_t f = 0; f < played.frame_count; ++f) {
                    put_frame(*a, played, f);
                    put_frame(*b, played, f);
                    const FrameResult expected = a->detect(), found = b->detect();
                    ASSERT_EQ(found.hash, expected.hash) << name << " frame " << f;
                    rays[0] += expected.rays;
                    rays[1] += found.rays;
                }
                EXPECT_LE(rays[1], rays[0]) << name;
            }
        }
}

TEST_P(TemporalTest, StepsRestWhereMemoryDoesNotPay) {
    const Recording moving = lattice(6, 60, LatticeMotion::soft),
                    resting = lattice(6, 60, LatticeMotion::rest);
    const auto play = [&](const Recording& recording, Settings settings) {
        const auto detector = make_detector(scene_of(recording), GetParam().make(), settings);
        std::vector<std::uint64_t> hashes;
        std::uint32_t rested = 0;
        for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
            put_frame(*detector, recording, f);
            const FrameResult result = detector->detect();
            hashes.push_back(result.hash);
            rested += result.rested;
            EXPECT_TRUE(result.rested == 0 || (result.walks == 0 && result.certified == 0));
        }
        return std::pair(hashes, rested);
    };
    const auto [off, never] = play(moving, {.temporal = Temporal::off});
    const auto [certified, rested] = play(moving, {.temporal = Temporal::certified});
    EXPECT_EQ(certified, off);
    EXPECT_EQ(never, 0u);
    if (GetParam().make()->certificates_pay()) {
        EXPECT_GT(rested, 30u) << "every vertex moves within its body in every step";
    }
    EXPECT_EQ(play(moving, {.temporal = Temporal::certified, .may_rest = false}).second, 0u);
    EXPECT_EQ(play(resting, {.temporal = Temporal::certified}).second, 0u);
}

TEST(TemporalSettingsTest, RefusesNonsense) {
    Settings settings;
    settings.full_every = 0;
    EXPECT_THROW(World(reference_backend(), settings), InputError);
    settings = {};
    settings.walk_threshold = -1;
    EXPECT_THROW(World(reference_backend(), settings), InputError);
    settings = {};
    settings.prediction_distance = std::nan("");
    EXPECT_THROW(World(reference_backend(), settings), InputError);
}

}  // namespace
}  // namespace pierce
