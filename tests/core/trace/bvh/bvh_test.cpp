// Our own trees: that they are trees, that they find what brute force finds, and that they are good
// ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iostream>
#include <limits>
#include <numeric>
#include <thread>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/execute/serial_executor.hpp"
#include "core/mesh_build/leaves.hpp"
#include "core/step/pipeline_backend.hpp"
#include "core/trace/brute_force_tracer.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "core/trace/bvh/sah.hpp"
#include "cpu_embree/tbb_executor.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"
#include "support/sweep_sah.hpp"

namespace pierce {
namespace {

using bvh::BoxF;
using bvh::Forest;
using bvh::Item;
using bvh::Node;
using bvh::Place;
using bvh::Tree;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

constexpr TreeBuilder builders[] = {TreeBuilder::lbvh, TreeBuilder::hlbvh, TreeBuilder::trbvh,
                                    TreeBuilder::ploc};

std::string builder_name(const testing::TestParamInfo<TreeBuilder>& info) {
    switch (info.param) {
        case TreeBuilder::lbvh:
            return "lbvh";
        case TreeBuilder::hlbvh:
            return "hlbvh";
        case TreeBuilder::trbvh:
            return "trbvh";
        case TreeBuilder::ploc:
            return "ploc";
    }
    return "";
}

/// Deforming bodies, one per mesh, as stages see them.
class Bodies {
public:
    explicit Bodies(std::vector<MeshData> meshes)
        : meshes_(std::move(meshes)), leaves_(meshes_.size()), views_(meshes_.size()) {
        for (std::size_t b = 0; b < views_.size(); ++b) {
            leaves_[b] = bvh::leaves_of(meshes_[b]);
            views_[b].mesh.leaves = view_of(std::as_const(leaves_[b]));
            views_[b].motion = Motion::deforming;
            views_[b].mesh_key = b + 1;
        }
        moved();
    }

    MeshData& mesh(std::size_t b) { return meshes_[b]; }
    void leave_out(std::size_t b) { views_[b].active = false; }
    void take_in(std::size_t b) { views_[b].active = true; }
    View<const BodyView> views() const { return view_of(views_); }

    /// To be called after meshes were changed.
    void moved() {
        for (std::size_t b = 0; b < views_.size(); ++b) {
            BodyView& body = views_[b];
            body.mesh.triangles = view_of(std::as_const(meshes_[b].triangles));
            body.positions = view_of(std::as_const(meshes_[b].positions));
            body.world_box = {};
            body.active = true;
            for (Vec3f p : meshes_[b].positions) {
                body.world_box.extend(to_double(p));
                body.active = body.active && is_finite(p);
            }
            body.touch = constants::touch_tolerance * body.world_box.extent();
            body.mesh.mean_edge_length = body.world_box.extent();
            ++body.positions_version;
        }
    }

private:
    std::vector<MeshData> meshes_;
    std::vector<std::vector<bvh::Leaf>> leaves_;
    std::vector<BodyView> views_;
};

/// The trees of some bodies.
struct Trees {
    std::vector<Tree> trees;
    std::vector<std::uint32_t> tree_of_body, tree_of_leaf, visits;
    std::vector<Node> nodes;
    std::vector<Place> leaf_places;

    explicit Trees(View<const BodyView> bodies) {
        bvh::ForestPlan plan;
        plan.arrange(bodies);
        trees.assign(plan.trees().begin(), plan.trees().end());
        tree_of_body.assign(plan.tree_of_body().begin(), plan.tree_of_body().end());
        tree_of_leaf.assign(plan.tree_of_leaf().begin(), plan.tree_of_leaf().end());
        visits.resize(plan.leaf_count());
        // As after another build: nothing is where it belongs.
        Node used;
        used.child[0] = used.child[1] = Item::node(0);
        used.parent = Place::at(0, 1);
        nodes.resize(plan.leaf_count(), used);
        leaf_places.resize(plan.leaf_count(), used.parent);
    }

    Forest forest() {
        return {view_of(trees),
                view_of(std::as_const(tree_of_body)),
                view_of(std::as_const(tree_of_leaf)),
                view_of(nodes),
                view_of(leaf_places),
                view_of(visits)};
    }
};

template <Executor E>
Trees build(E& executor, TreeBuilder how, View<const BodyView> bodies) {
    Trees trees(bodies);
    bvh::ForestBuilder<E>(how).build(executor, bodies, trees.forest());
    return trees;
}

Trees build(TreeBuilder how, View<const BodyView> bodies) {
    SerialExecutor executor;
    return build(executor, how, bodies);
}

bool same(const BoxF& a, const BoxF& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Checks links and boxes; returns the box of all. Boxes are exactly those around the leaves.
void expect_tree(const Trees& trees, const Tree& tree, const BodyView& body) {
    struct Open {
        Item item;
        Place place;
        BoxF box;  ///< that the node above has
    };
    std::vector<std::uint32_t> node_seen(trees.nodes.size()), leaf_seen(tree.count);
    std::vector<std::uint32_t> order;
    std::vector<Open> open{{tree.root, {}, {}}};
    std::vector<BoxF> box(trees.nodes.size());
    while (!open.empty()) {
        const Open now = open.back();
        open.pop_back();
        if (now.item.is_leaf()) {
            ASSERT_LT(now.item.index(), tree.count);
            ++leaf_seen[now.item.index()];
            EXPECT_EQ(trees.leaf_places[tree.first + now.item.index()].code, now.place.code);
            continue;
        }
        const std::uint32_t n = now.item.index();
        ASSERT_GE(n, tree.first);
        ASSERT_LT(n, tree.first + tree.count - 1);
        ASSERT_EQ(++node_seen[n], 1u) << "node " << n;
        EXPECT_EQ(trees.nodes[n].parent.code, now.place.code) << "node " << n;
        order.push_back(n);
        for (std::uint32_t side = 0; side < 2; ++side)
            open.push_back(
                {trees.nodes[n].child[side], Place::at(n, side), trees.nodes[n].box[side]});
    }
    EXPECT_EQ(std::ranges::count(leaf_seen, 1u), tree.count) << "every leaf exactly once";
    if (!body.active) return;
    std::ranges::reverse(order);
    for (std::uint32_t n : order) {
        const Node& node = trees.nodes[n];
        for (int side = 0; side < 2; ++side) {
            const Item child = node.child[side];
            EXPECT_TRUE(same(node.box[side], child.is_leaf() ? bvh::leaf_box(body, child.index())
                                                             : box[child.index()]))
                << "node " << n << ", side " << side;
        }
        box[n] = join(node.box[0], node.box[1]);
    }
}

void expect_trees(const Trees& trees, View<const BodyView> bodies) {
    for (std::size_t t = 0; t < trees.trees.size(); ++t) {
        SCOPED_TRACE("tree " + std::to_string(t));
        expect_tree(trees, trees.trees[t], bodies[trees.trees[t].body]);
    }
    EXPECT_EQ(std::ranges::count(trees.visits, 0u), std::ssize(trees.visits))
        << "ready for a refit";
}

bool same(const Trees& a, const Trees& b) {
    for (std::size_t t = 0; t < a.trees.size(); ++t) {
        const Tree& tree = a.trees[t];
        if (tree.root.code != b.trees[t].root.code) return false;
        for (std::uint32_t i = tree.first; i < tree.first + tree.count; ++i) {
            if (a.leaf_places[i].code != b.leaf_places[i].code) return false;
            if (i + 1 == tree.first + tree.count) continue;
            const Node &m = a.nodes[i], &n = b.nodes[i];
            if (m.parent.code != n.parent.code) return false;
            for (int side = 0; side < 2; ++side)
                if (m.child[side].code != n.child[side].code || !same(m.box[side], n.box[side]))
                    return false;
        }
    }
    return true;
}

/// Triangles strewn at random, long and short.
MeshData soup(test::Random& random, std::uint32_t count) {
    MeshData mesh;
    for (std::uint32_t t = 0; t < count; ++t) {
        const Vec3d at = random.in_box(1);
        const double size = std::pow(10, random.uniform(-3, 0));
        for (int k = 0; k < 3; ++k) mesh.positions.push_back(to_float(at + random.in_box(size)));
        mesh.triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}});
    }
    return mesh;
}

/// The first `count` triangles of a mesh.
MeshData part(MeshData mesh, std::size_t count) {
    mesh.triangles.resize(count);
    return mesh;
}

/// A triangle, `count` times.
MeshData coincident(std::size_t count) {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Triangle>(count, Triangle{{0, 1, 2}})};
}

/// Triangles around one point, which all their boxes have as their centre, each larger than the
/// last by a factor, and on the other side.
MeshData concentric(std::uint32_t count, float factor) {
    MeshData mesh;
    for (std::uint32_t t = 0; t < count; ++t) {
        const float r = (t % 2 == 0 ? 1.0f : -1.0f) * std::pow(factor, static_cast<float>(t));
        for (Vec3f p : {Vec3f{-r, -r, -r}, Vec3f{r, r, -r}, Vec3f{r, -r, r}})
            mesh.positions.push_back(p);
        mesh.triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}});
    }
    return mesh;
}

/// Everything that has ever troubled a builder, side by side.
std::vector<MeshData> many_meshes(test::Random& random) {
    std::vector<MeshData> meshes;
    for (std::size_t count : {1, 2, 3, 6, 7, 8, 14})
        meshes.push_back(part(scenes::sphere(1, 1), count));
    for (std::size_t count : {2, 100}) meshes.push_back(coincident(count));
    // The best tree is a chain, deeper than the traversal's stack.
    for (float factor : {1.1f, 0.9f, 2.0f}) meshes.push_back(concentric(100, factor));
    for (int i = 0; i < 20; ++i) meshes.push_back(test::random_closed_mesh(random));
    for (int i = 0; i < 5; ++i)
        meshes.push_back(soup(random, static_cast<std::uint32_t>(random.integer(1, 500))));
    meshes.push_back(scenes::torus(1, 0.3, 60, 30));
    meshes.push_back(scenes::sphere(1e18, 2));
    meshes.push_back(scenes::sphere(1e25, 2));  // areas overflow
    meshes.push_back(scenes::sphere(1, 2));
    for (std::size_t v = 0; v < meshes.back().positions.size(); v += 5)
        meshes.back().positions[v].y = nan;
    meshes.push_back(scenes::sphere(1, 2));
    for (Vec3f& p : meshes.back().positions) p = {nan, nan, nan};
    return meshes;
}

std::vector<Ray> random_rays(test::Random& random, View<const BodyView> bodies, int per_body) {
    std::vector<Ray> rays;
    for (std::uint32_t b = 0; b < bodies.size; ++b) {
        const Box& box = bodies[b].world_box;
        for (int i = 0; bodies[b].active && i < per_body; ++i) {
            Ray ray;
            for (int k = 0; k < 3; ++k) ray.origin[k] = random.uniform(box.lower[k], box.upper[k]);
            if (i % 5 == 0) ray.origin = box.center();
            ray.direction = random.unit_vector();
            if (i % 4 == 0) ray.direction = {0, 0, i % 8 == 0 ? 1.0 : -1.0};
            ray.t_max = box.extent() * random.uniform(0, 1);
            ray.outward = i % 2 == 0 ? 0 : 0.1 * box.extent();
            ray.target = b;
            ray.touch = bodies[b].touch;
            rays.push_back(ray);
        }
    }
    return rays;
}

template <class T>
std::vector<Hit> hits_of(T& tracer, View<const BodyView> bodies, const std::vector<Ray>& rays) {
    SerialExecutor executor;
    std::vector<Hit> hits(rays.size());
    const std::vector<std::uint32_t> wanted(bodies.size, 1);
    tracer.update(executor, bodies, view_of(wanted));
    tracer.closest_hits(executor, bodies, static_cast<std::uint32_t>(rays.size()), view_of(rays),
                        view_of(hits));
    return hits;
}

/// Runs stages one by one and counts them.
struct CountingExecutor : SerialExecutor {
    std::uint32_t stages = 0;

    template <class F>
    void for_each(std::uint32_t n, const F& stage) {
        ++stages;
        SerialExecutor::for_each(n, stage);
    }
};

/// Runs the items of a stage from the last to the first.
struct BackwardExecutor : SerialExecutor {
    template <class F>
    void for_each(std::uint32_t n, const F& stage) {
        while (n > 0) stage(--n);
    }
};

/// Runs a stage on threads that take turns at its items.
struct ThreadsExecutor : SerialExecutor {
    static constexpr std::uint32_t threads = 4;

    template <class F>
    void for_each(std::uint32_t n, const F& stage) {
        std::vector<std::jthread> running;
        for (std::uint32_t t = 0; t < threads; ++t)
            running.emplace_back([=, &stage] {
                for (std::uint32_t i = t; i < n; i += threads) stage(i);
            });
    }
};

class BvhTest : public testing::TestWithParam<TreeBuilder> {
protected:
    test::Random random_{7};
    testing::ScopedTrace trace_{__FILE__, __LINE__, "seed " + std::to_string(random_.seed())};
};

TEST_P(BvhTest, BuildsTrees) {
    const Bodies bodies(many_meshes(random_));
    expect_trees(build(GetParam(), bodies.views()), bodies.views());
}

TEST_P(BvhTest, BuildsATreeAlone) {
    for (std::size_t count : {1, 2, 3, 7, 20}) {
        const Bodies bodies({part(scenes::sphere(1, 1), count)});
        expect_trees(build(GetParam(), bodies.views()), bodies.views());
    }
}

/// Large enough that treelets are improved level by level.
TEST_P(BvhTest, BuildsALargeTree) {
    const Bodies bodies({scenes::torus(1, 0.4, 700, 360)});
    CountingExecutor executor;
    const Trees trees = build(executor, GetParam(), bodies.views());
    expect_trees(trees, bodies.views());
    ThreadsExecutor threads;
    EXPECT_TRUE(same(trees, build(threads, GetParam(), bodies.views())));
    CountingExecutor of_few;
    build(of_few, GetParam(), Bodies({scenes::sphere(1, 1)}).views());
    EXPECT_TRUE(GetParam() != TreeBuilder::hlbvh || executor.stages > of_few.stages)
        << "ranges of cells are not that large";
}

TEST_P(BvhTest, TakesFewStages) {
    for (const MeshData& mesh : {scenes::sphere(1, 4), coincident(5000), soup(random_, 5000)}) {
        const Bodies bodies({mesh, mesh});
        CountingExecutor executor;
        build(executor, GetParam(), bodies.views());
        EXPECT_LT(executor.stages, 150u);
    }
}

TEST_P(BvhTest, SharesATreeAmongRigidBodies) {
    const MeshData mesh = scenes::sphere(1, 2);
    const std::vector<bvh::Leaf> leaves = bvh::leaves_of(mesh);
    std::vector<BodyView> bodies(3);
    for (BodyView& body : bodies) {
        body.motion = Motion::rigid;
        body.mesh_key = 1;
        body.mesh.triangles = view_of(mesh.triangles);
        body.mesh.leaves = view_of(leaves);
        body.positions = view_of(mesh.positions);
        for (Vec3f p : mesh.positions) body.mesh.box.extend(to_double(p));
    }
    const Trees trees = build(GetParam(), view_of(std::as_const(bodies)));
    EXPECT_EQ(trees.trees.size(), 1u);
    expect_trees(trees, view_of(std::as_const(bodies)));
}

TEST_P(BvhTest, HitsWhatBruteForceHits) {
    const Bodies bodies(many_meshes(random_));
    const std::vector<Ray> rays = random_rays(random_, bodies.views(), 100);
    BvhTracer<SerialExecutor> tracer({GetParam()});
    BruteForceTracer reference;
    EXPECT_EQ(hits_of(tracer, bodies.views(), rays), hits_of(reference, bodies.views(), rays));
}

/// Two cones of `sides` triangles each, base to base.
MeshData spindle(std::uint32_t sides) {
    MeshData mesh;
    mesh.positions = {{0, 0, 1}, {0, 0, -1}};
    for (std::uint32_t k = 0; k < sides; ++k) {
        const float angle = 6.2831853f * static_cast<float>(k) / static_cast<float>(sides);
        mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
        const std::uint32_t here = 2 + k, next = 2 + (k + 1) % sides;
        mesh.triangles.push_back({{0, here, next}});
        mesh.triangles.push_back({{1, next, here}});
    }
    return mesh;
}

TEST_P(BvhTest, TracesRaysThatMayCrossManyTriangles) {
    for (std::uint32_t sides : {14u, 15u, 16u, 30u, 31u, 32u, 200u}) {
        const Bodies bodies({spindle(sides)});
        std::vector<Ray> rays = random_rays(random_, bodies.views(), 20);
        // Through an apex, which is all triangles of a cone at once; and from one, to which they do
        // not belong.
        for (double x : {0.0, 1e-9, 0.1}) {
            Ray ray;
            ray.origin = {x, 0, 0.25};
            ray.direction = normalized(Vec3d{-x, 0, 0.75});
            ray.t_max = 4;
            ray.touch = bodies.views()[0].touch;
            rays.push_back(ray);
            ray.origin = {0, 0, 1};
            ray.direction = normalized(Vec3d{x, 0, -2});
            ray.excluded[0] = ray.excluded[1] = 0;
            rays.push_back(ray);
        }
        BvhTracer<SerialExecutor> tracer({GetParam()});
        BruteForceTracer reference;
        EXPECT_EQ(hits_of(tracer, bodies.views(), rays), hits_of(reference, bodies.views(), rays))
            << sides << " sides";
    }
}

TEST_P(BvhTest, FindsTheClosestTrianglesOfBruteForce) {
    const Bodies bodies(many_meshes(random_));
    const std::vector<Ray> rays = random_rays(random_, bodies.views(), 50);
    const auto measure = [&](auto tracer) {
        SerialExecutor executor;
        std::vector<std::uint32_t> triangles(rays.size());
        const std::vector<std::uint32_t> wanted(bodies.views().size, 1);
        tracer.update(executor, bodies.views(), view_of(wanted));
        tracer.closest_triangles(executor, bodies.views(), static_cast<std::uint32_t>(rays.size()),
                                 view_of(rays), view_of(triangles));
        return triangles;
    };
    EXPECT_EQ(measure(BvhTracer<SerialExecutor>({GetParam()})), measure(BruteForceTracer()));
}

TEST_P(BvhTest, IsTheSameFromEveryExecutor) {
    const Bodies bodies(many_meshes(random_));
    const Trees serial = build(GetParam(), bodies.views());
    BackwardExecutor backward;
    EXPECT_TRUE(same(serial, build(backward, GetParam(), bodies.views()))) << "backward";
    ThreadsExecutor threads;
    for (int repeat = 0; repeat < 5; ++repeat)
        EXPECT_TRUE(same(serial, build(threads, GetParam(), bodies.views()))) << "threads";
#if !defined(__SANITIZE_THREAD__)
    for (int count : {1, 4}) {
        TbbExecutor executor(count);
        for (int repeat = 0; repeat < 5; ++repeat)
            EXPECT_TRUE(same(serial, build(executor, GetParam(), bodies.views())))
                << "oneTBB, " << count << " threads";
    }
#endif
}

TEST_P(BvhTest, RefitsToWhatARebuildHasToo) {
    Bodies bodies(many_meshes(random_));
    Trees trees = build(GetParam(), bodies.views());
    for (std::size_t b = 0; b < bodies.views().size; ++b)
        for (Vec3f& p : bodies.mesh(b).positions)
            p = to_float(1.5 * to_double(p) + random_.in_box(0.5));
    bodies.moved();
    SerialExecutor executor;
    const std::vector<std::uint32_t> wanted(bodies.views().size, 1);
    for (int repeat = 0; repeat < 2; ++repeat)
        executor.for_each(static_cast<std::uint32_t>(trees.visits.size()),
                          bvh::Refit{bodies.views(), view_of(wanted), trees.forest()});
    std::ranges::fill(trees.visits, 0u);
    expect_trees(trees, bodies.views());
}

INSTANTIATE_TEST_SUITE_P(Builders, BvhTest, testing::ValuesIn(builders), builder_name);

/// A sphere with waves.
MeshData bumpy_sphere(int levels) {
    MeshData mesh = scenes::sphere(1, levels);
    for (Vec3f& p : mesh.positions) p = (1 + 0.3f * std::sin(9 * p.x) * std::sin(7 * p.y)) * p;
    return mesh;
}

/// What every builder's tree of a mesh costs, and the sweep's last.
std::vector<double> costs(const MeshData& mesh) {
    const Bodies bodies({mesh});
    std::vector<double> found;
    for (TreeBuilder how : builders) {
        Trees trees = build(how, bodies.views());
        found.push_back(bvh::sah_cost(trees.forest(), trees.trees[0]));
    }
    found.push_back(test::sweep_sah_cost(bodies.views()[0]));
    return found;
}

TEST(TreeQualityTest, RestructuredTreesAreAsGoodAsASweeps) {
    test::Random random(8);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    struct Case {
        const char* name;
        MeshData mesh;
        double above_sweep;
    };
    const Case cases[] = {{"torus", scenes::torus(1, 0.4, 200, 100), 1.05},
                          {"slim torus", scenes::torus(1, 0.02, 1000, 20), 1.05},
                          {"sphere", scenes::sphere(1, 5), 1.05},
                          {"bumpy sphere", bumpy_sphere(5), 1.07},
                          {"soup", soup(random, 20000), 0.9}};
    std::cout << "SAH cost: lbvh hlbvh trbvh ploc sweep\n";
    for (const Case& one : cases) {
        SCOPED_TRACE(one.name);
        const std::vector<double> cost = costs(one.mesh);
        std::cout << one.name << ", " << one.mesh.triangles.size() << " triangles:";
        for (double c : cost) std::cout << ' ' << c;
        std::cout << '\n';
        const double lbvh = cost[0], hlbvh = cost[1], trbvh = cost[2], ploc = cost[3],
                     sweep = cost[4];
        EXPECT_LT(hlbvh, 0.99 * lbvh);
        EXPECT_LT(ploc, 0.97 * lbvh);
        EXPECT_LT(trbvh, 0.93 * lbvh);
        EXPECT_LT(trbvh, one.above_sweep * sweep);
    }
}

TEST(TreeQualityTest, TheBodyOfTheBenchmarksIsWithinATwentiethOfASweep) {
    const std::vector<double> cost = costs(scenes::torus(2, 0.5, 30, 10));
    std::cout << "torus of 600 triangles: " << cost[0] << ' ' << cost[1] << ' ' << cost[2] << ' '
              << cost[3] << ' ' << cost[4] << '\n';
    EXPECT_LT(cost[2], 1.05 * cost[4]);
}

/// Small spheres in a row, which then change places at random: the tree holds boxes as long as the
/// row, until it is rebuilt.
TEST(BvhTracerTest, RebuildsADecayedTree) {
    test::Random random(9);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    constexpr int count = 50;
    const MeshData one = scenes::sphere(0.5, 0);
    MeshData row;
    for (int i = 0; i < count; ++i)
        for (Triangle t : one.triangles) {
            for (std::uint32_t& v : t.vertex)
                v += static_cast<std::uint32_t>(i * std::ssize(one.positions));
            row.triangles.push_back(t);
        }
    row.positions.resize(count * one.positions.size());
    Bodies bodies({row});
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&] {
        for (std::size_t v = 0; v < row.positions.size(); ++v) {
            const int at = order[v / one.positions.size()];
            bodies.mesh(0).positions[v] = one.positions[v % one.positions.size()] +
                                          Vec3f{static_cast<float>(at), 0, 0};
        }
        bodies.moved();
    };
    for (TreeBuilder how : builders) {
        SCOPED_TRACE(static_cast<int>(how));
        BvhTracer<SerialExecutor> tracer({how});
        BruteForceTracer reference;
        SerialExecutor executor;
        std::ranges::sort(order);
        TracerCounts counts;
        for (int step = 0; step < 20; ++step) {
            place();
            const std::vector<Ray> rays = random_rays(random, bodies.views(), 1000);
            EXPECT_EQ(hits_of(tracer, bodies.views(), rays),
                      hits_of(reference, bodies.views(), rays));
            tracer.add_up(executor);
            counts = tracer.counts(executor);
            if (step != 5) continue;
            EXPECT_EQ(counts.rebuilds, 0u) << "nothing has decayed yet";
            for (int i = count - 1; i > 0; --i)
                std::swap(order[static_cast<std::size_t>(i)],
                          order[static_cast<std::size_t>(random.integer(0, i))]);
        }
        EXPECT_EQ(counts.rebuilds, 1u);
        EXPECT_EQ(counts.builds, 2u);
        EXPECT_GT(counts.refits, 0u);
    }
}

/// A device gets the positions of a body when it first takes part. They may be as old as its tree.
TEST(BvhTracerTest, FitsABodyThatTookNoPartWhenTreesWereBuilt) {
    test::Random random(13);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    Bodies bodies({scenes::sphere(1, 2), scenes::sphere(1, 2)});
    const std::vector<Vec3f> there = bodies.mesh(1).positions;
    for (TreeBuilder how : builders) {
        SCOPED_TRACE(static_cast<int>(how));
        BvhTracer<SerialExecutor> tracer({how});
        BruteForceTracer reference;
        SerialExecutor executor;
        std::ranges::fill(bodies.mesh(1).positions, Vec3f{9, 9, 9});
        bodies.leave_out(1);
        const std::vector<std::uint32_t> wanted(2, 1);
        tracer.update(executor, bodies.views(), view_of(wanted));
        bodies.mesh(1).positions = there;
        bodies.take_in(1);
        const std::vector<Ray> rays = random_rays(random, bodies.views(), 1000);
        EXPECT_EQ(hits_of(tracer, bodies.views(), rays), hits_of(reference, bodies.views(), rays));
    }
}

TEST(BvhTracerTest, MeshesMayChangeWhenAllTreesAreBuiltAnew) {
    using Tracer = BvhTracer<SerialExecutor>;
    World built(std::make_unique<PipelineBackend<SerialExecutor, Tracer>>(
        "built", std::make_unique<SerialExecutor>(),
        std::make_unique<Tracer>(TreeOptions{.rebuild = true}))),
        plain(reference_backend());
    test::Random random(12);
    std::vector<BodyId> bodies;
    for (int b = 0; b < 9; ++b)
        for (World* world : {&built, &plain}) {
            const MeshId mesh = world->add_mesh("ball", scenes::sphere(1, 2));
            const BodyId body = b % 2 == 0 ? world->add_deforming_body(mesh)
                                           : world->add_rigid_body(mesh);
            if (world == &plain) bodies.push_back(body);
        }
    for (int step = 0; step < 12; ++step) {
        const auto changed = static_cast<std::size_t>(random.integer(0, 8));
        const MeshData other = scenes::sphere(1, random.integer(1, 3));
        std::vector<Vec3d> places;
        for (std::size_t b = 0; b < bodies.size(); ++b) places.push_back(random.in_box(1.5));
        for (World* world : {&built, &plain}) {
            const MeshId mesh = world->add_mesh("other", other);
            if (changed % 2 == 0)
                world->set_mesh(bodies[changed], mesh, other.positions);
            else
                world->set_mesh(bodies[changed], mesh);
            for (std::size_t b = 0; b < bodies.size(); ++b) {
                const Pose pose{places[b], {0, 0, 0, 1}};
                const auto rest = world->mesh(world->mesh_of(bodies[b])).positions();
                if (b % 2 == 0)
                    world->set_positions(bodies[b],
                                         test::placed({{rest.begin(), rest.end()}, {}}, pose));
                else
                    world->set_pose(bodies[b], pose);
            }
            world->detect();
        }
        ASSERT_GT(plain.contacts().size(), 0u);
        ASSERT_EQ(contact_hash(built.contacts()), contact_hash(plain.contacts()))
            << "step " << step << ", seed " << random.seed();
    }
}

}  // namespace
}  // namespace pierce
