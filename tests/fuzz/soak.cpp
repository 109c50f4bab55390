// One world of many bodies for a long time: bodies come, go, deform, are cut, jump, turn to NaN and
// come back, and the world goes on with other numbers of threads. Memory must stay flat, and
// sampled steps are compared with brute force.
#include <fmt/format.h>
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "fuzz/shapes.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"

namespace pierce::fuzz {
namespace {

struct Options {
    double seconds = 60;
    std::uint32_t bodies = 500;
    std::uint64_t seed = 1;
    std::uint32_t check_every = 25;
};

class Soak {
public:
    explicit Soak(const Options& options)
        : options_(options), engine_(options.seed), world_(embree_backend(1)) {
        for (std::uint64_t seed = 0; meshes_.size() < 12; ++seed) {
            const std::vector<std::uint8_t> bytes = bytes_of(seed);
            Choices choices(bytes);
            data_.push_back(proper_mesh(choices));
            meshes_.push_back(
                world_.add_mesh("mesh " + std::to_string(seed), data_.back(), {.threads = 1}));
        }
        // Bodies of a place in the list keep their kind, so that the world as a whole stays as
        // large as it is.
        side_ = 1.2 * std::cbrt(options.bodies);
        bodies_.resize(options.bodies);
        for (std::uint32_t b = 0; b < options.bodies; ++b) add(b);
    }

    int run() {
        using Clock = std::chrono::steady_clock;
        const auto begin = Clock::now();
        const auto passed = [&] {
            return std::chrono::duration<double>(Clock::now() - begin).count() / options_.seconds;
        };
        for (double now = 0; now < 1; now = passed()) {
            change();
            if (step_ % options_.check_every == 0) check();
            world_.detect();
            contacts_ += world_.stats().contacts;
            excluded_ += world_.stats().excluded_bodies;
            const bool warm = now > 0.2, late = now > 0.6;
            // What a world needs doubles and halves with its contacts. So a world that has gone on
            // for long is compared with one that was restored from it.
            if (warm && step_ % steps_per_life == 0)
                (late ? late_ : early_).add(aged_ / bytes_in_use());
            if (step_ % steps_per_life == steps_per_life - 1) {
                aged_ = bytes_in_use();
                go_on_with(1 + static_cast<int>(step_ / steps_per_life % 3));
                if (warm) (late ? left_late_ : left_early_).add(left_);
            }
            ++step_;
        }
        // What is left when a world is gone must not grow, nor what age adds to a world.
        const double growth = late_.median() / early_.median() - 1;
        const double leak = (left_late_.median() - left_early_.median()) / aged_;
        fmt::print(
            "{} steps of {} bodies from seed {}, {:.0f} s: {} contacts, {} bodies left out, {} "
            "changes, {} steps compared, {} of them differ; {:.2f} MiB; an old world has {:.3f} of "
            "the memory of a new one, then {:.3f}: {:+.2f} %; without the world {:+.3f} %\n",
            step_, options_.bodies, options_.seed, options_.seconds, contacts_, excluded_, changes_,
            compared_, differ_, aged_ / (1 << 20), early_.median(), late_.median(), 100 * growth,
            100 * leak);
        // Lives are few, and by chance the ratios of their halves differ by up to a tenth.
        constexpr double flat = 0.01, chance = 0.2;
        return differ_ == 0 && compared_ > 0 && contacts_ > 0 && leak < flat && growth < chance ? 0
                                                                                                : 1;
    }

private:
    /// Steps from one change of the number of threads to the next.
    static constexpr std::uint64_t steps_per_life = 32;

    struct Body {
        BodyId id;
        std::uint32_t mesh = 0;
        Motion motion = Motion::rigid;
        Vec3d place;
    };
    /// A tracer's threads may hold on to memory for a moment, so single values may be far off.
    struct Median {
        std::vector<double> values;

        void add(double x) { values.push_back(x); }
        double median() const {
            std::vector<double> sorted = values;
            std::ranges::sort(sorted);
            return sorted.empty() ? 1 : sorted[sorted.size() / 2];
        }
    };

    /// What is allocated in the arenas of all threads. mallinfo2() knows only one of them, and
    /// which thread makes what depends on chance.
    static double bytes_in_use() {
        char* buffer = nullptr;
        std::size_t size = 0;
        std::FILE* const out = open_memstream(&buffer, &size);
        malloc_info(0, out);
        std::fclose(out);
        const std::string text(buffer, size);
        std::free(buffer);
        const std::size_t sums = text.rfind("</heap>");
        const auto number = [&](const char* element) {
            const std::size_t at = text.find("size=\"", text.find(element, sums));
            return std::strtod(text.c_str() + at + 6, nullptr);
        };
        return number("<system type=\"current\"") - number("<total type=\"fast\"") -
               number("<total type=\"rest\"") + number("<total type=\"mmap\"");
    }

    std::uint64_t below(std::uint64_t count) { return engine_() % count; }
    double uniform(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(engine_);
    }
    Vec3d anywhere() { return {uniform(0, side_), uniform(0, side_), uniform(0, side_)}; }
    Pose pose_at(Vec3d place) {
        return {place, {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)}};
    }

    std::vector<Vec3f> bent(const Body& body) {
        std::vector<Vec3f> positions;
        for (const Vec3f& p : data_[body.mesh].positions)
            positions.push_back(to_float(to_double(p) + body.place +
                                         Vec3d{uniform(-0.02, 0.02), uniform(-0.02, 0.02),
                                               0.1 * std::sin(static_cast<double>(p.x))}));
        return positions;
    }

    void add(std::uint32_t b) {
        Body& body = bodies_[b];
        body.motion = b % 10 == 0 ? Motion::fixed : b % 3 == 0 ? Motion::deforming : Motion::rigid;
        body.mesh = b % static_cast<std::uint32_t>(meshes_.size());
        body.place = anywhere();
        if (body.motion == Motion::fixed) {
            body.id = world_.add_fixed_body(meshes_[body.mesh], pose_at(body.place));
        } else if (body.motion == Motion::rigid) {
            body.id = world_.add_rigid_body(meshes_[body.mesh], pose_at(body.place));
        } else {
            body.id = world_.add_deforming_body(meshes_[body.mesh], bent(body));
            if (b % 2 == 0) world_.set_collision(body.id, {.self = SelfCollision::on});
            if (b % 5 == 0)
                world_.set_collision(body.id,
                                     {.self = SelfCollision::on, .sheet = true, .thickness = 0.02});
        }
    }

    void move(Body& body) {
        if (body.motion == Motion::deforming)
            world_.set_positions(body.id, bent(body));
        else
            world_.set_pose(body.id, pose_at(body.place));
    }

    void change() {
        for (std::uint32_t b = 0; b < bodies_.size(); ++b) {
            if (below(3) != 0) continue;
            Body& body = bodies_[b];
            body.place += Vec3d{uniform(-0.02, 0.02), uniform(-0.02, 0.02), uniform(-0.02, 0.02)};
            move(body);
            ++changes_;
        }
        for (int k = 0; k < 3; ++k) {
            const auto b = static_cast<std::uint32_t>(below(bodies_.size()));
            world_.remove_body(bodies_[b].id);
            add(b);
            Body& jumps = bodies_[below(bodies_.size())];
            jumps.place = anywhere();
            move(jumps);
        }
        // One is nowhere for a while; the next time that it moves it is back.
        Body& lost = bodies_[below(bodies_.size())];
        if (lost.motion == Motion::deforming)
            world_.set_positions(
                lost.id, std::vector<Vec3f>(data_[lost.mesh].positions.size(),
                                            Vec3f{std::numeric_limits<float>::quiet_NaN(), 0, 0}));
        else
            world_.set_pose(lost.id, {{std::numeric_limits<double>::infinity(), 0, 0}, {}});
        // One is cut: another mesh in its place, and back again later, when it is removed.
        Body& cut = bodies_[3 * below(bodies_.size() / 3)];
        if (cut.motion == Motion::deforming) {
            cut.mesh = (cut.mesh + 1) % static_cast<std::uint32_t>(meshes_.size());
            world_.set_mesh(cut.id, meshes_[cut.mesh], bent(cut));
        }
    }

    std::string saved() const {
        std::ostringstream out;
        world_.save(out);
        return out.str();
    }

    void go_on_with(int threads) {
        std::istringstream in(saved());
        world_ = World();
        left_ = bytes_in_use() - static_cast<double>(in.view().size());
        world_ = World::restore(in, embree_backend(threads));
    }

    /// The next step, from here, by brute force.
    void check() {
        std::istringstream in(saved());
        World same = World::restore(in, reference_backend());
        same.detect();
        const std::uint64_t expected = contact_hash(same.contacts());
        std::istringstream again(saved());
        World embree = World::restore(again, embree_backend(2));
        embree.detect();
        ++compared_;
        differ_ += contact_hash(embree.contacts()) != expected;
    }

    Options options_;
    std::mt19937_64 engine_;
    World world_;
    double side_ = 1;
    std::vector<MeshData> data_;
    std::vector<MeshId> meshes_;
    std::vector<Body> bodies_;
    std::uint64_t step_ = 0, contacts_ = 0, excluded_ = 0, changes_ = 0, compared_ = 0, differ_ = 0;
    double aged_ = 1;  ///< [bytes] in use before the world was restored
    double left_ = 0;  ///< [bytes] in use when the last world was gone
    Median early_, late_, left_early_, left_late_;
};

}  // namespace
}  // namespace pierce::fuzz

int main(int argc, char** argv) {
    pierce::fuzz::Options options;
    CLI::App app{"One world for a long time"};
    app.add_option("--seconds", options.seconds, "time");
    app.add_option("--bodies", options.bodies, "how many");
    app.add_option("--seed", options.seed, "of all that is random");
    app.add_option("--check-every", options.check_every,
                   "steps from one that is compared with brute force to the next");
    CLI11_PARSE(app, argc, argv);
    return pierce::fuzz::Soak(options).run();
}
