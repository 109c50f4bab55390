// The whole pipeline on several threads, and several worlds at once: the thread sanitizer looks on.
// Without Embree, which is not compiled for it.
#include <gtest/gtest.h>

#include <thread>

#include "core/step/pipeline_backend.hpp"
#include "core/trace/brute_force_tracer.hpp"
#include "cpu_embree/tbb_executor.hpp"
#include "fuzz/generator.hpp"
#include "fuzz/player.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/error.hpp"
#include "pierce/partitioned_backend.hpp"
#include "pierce/reference_backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

std::unique_ptr<Backend> threads_without_embree() {
    return std::make_unique<PipelineBackend<TbbExecutor, BruteForceTracer>>(
        "brute force, 3 threads", std::make_unique<TbbExecutor>(3),
        std::make_unique<BruteForceTracer>());
}

fuzz::Program program_of_seed(std::uint64_t seed) {
    const std::vector<std::uint8_t> bytes = fuzz::bytes_of(seed);
    fuzz::Choices choices(bytes);
    return fuzz::random_program(choices);
}

/// The hashes of a program's steps; none if its settings are refused.
std::vector<std::uint64_t> hashes(const fuzz::Program& program, const fuzz::MakeBackend& backend) {
    std::vector<std::uint64_t> all;
    try {
        fuzz::Player player(backend, program.settings);
        for (const fuzz::Call& call : program.calls) {
            player.play(call);
            if (call.kind == fuzz::Call::Kind::detect)
                all.push_back(contact_hash(player.world().contacts()));
        }
    } catch (const InputError&) {
    }
    return all;
}

TEST(PipelineThreadsTest, StepsOnSeveralThreadsAreThoseOfOne) {
    constexpr std::uint64_t first = 500;
    SCOPED_TRACE("seeds from " + std::to_string(first));
    for (std::uint64_t seed = first; seed < first + 40; ++seed) {
        const fuzz::Program program = program_of_seed(seed);
        EXPECT_EQ(hashes(program, threads_without_embree), hashes(program, reference_backend))
            << "seed " << seed;
    }
}

std::unique_ptr<Backend> own_trees() { return bvh_backend(); }

TEST(TwoWorldsTest, RunInTwoThreadsAsTheyDoAlone) {
    constexpr std::uint64_t first = 600;
    SCOPED_TRACE("seeds from " + std::to_string(first));
    for (std::uint64_t seed = first; seed < first + 20; ++seed) {
        const fuzz::Program one = program_of_seed(seed), other = program_of_seed(seed + 1000);
        std::vector<std::uint64_t> of_one, of_other;
        {
            const std::jthread beside([&] { of_other = hashes(other, own_trees); });
            of_one = hashes(one, own_trees);
        }
        EXPECT_EQ(of_one, hashes(one, own_trees)) << "seed " << seed;
        EXPECT_EQ(of_other, hashes(other, own_trees)) << "seed " << seed + 1000;
    }
}

std::unique_ptr<Backend> parts_with_own_trees() {
    std::vector<Part> parts;
    for (int k = 0; k < 3; ++k) parts.push_back({.backend = bvh_backend(), .share = 1});
    return partitioned_backend(std::move(parts));
}

TEST(PartsThreadsTest, PartsInTheirThreadsFindWhatOneFinds) {
    constexpr std::uint64_t first = 700;
    SCOPED_TRACE("seeds from " + std::to_string(first));
    for (std::uint64_t seed = first; seed < first + 20; ++seed) {
        const fuzz::Program program = program_of_seed(seed);
        EXPECT_EQ(hashes(program, parts_with_own_trees), hashes(program, own_trees))
            << "seed " << seed;
    }
}

}  // namespace
}  // namespace pierce
