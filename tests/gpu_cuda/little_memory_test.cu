// Steps that run out of the device's memory.
#include <gtest/gtest.h>

#include <cuda_runtime.h>

#include <cstdint>
#include <string>
#include <vector>

#include "gpu_cuda/cuda_check.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/cuda_backend.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using cuda::check;

/// A memory pool of the device in which a few pieces are left.
class LittleMemory {
public:
    explicit LittleMemory(int left) {
        check(cudaDeviceGetMemPool(&before_, 0), "the device's memory pool");
        cudaMemPoolProps properties{};
        properties.allocType = cudaMemAllocationTypePinned;
        properties.location = {.type = cudaMemLocationTypeDevice, .id = 0};
        properties.maxSize = pool_bytes;
        check(cudaMemPoolCreate(&pool_, &properties), "a memory pool");
        void* piece = nullptr;
        while (cudaMallocFromPoolAsync(&piece, piece_bytes, pool_, nullptr) == cudaSuccess)
            taken_.push_back(piece);
        cudaGetLastError();
        for (int i = 0; i < left && !taken_.empty(); ++i, taken_.pop_back())
            check(cudaFreeAsync(taken_.back(), nullptr), "return of device memory");
        check(cudaStreamSynchronize(nullptr), "waiting for the device");
    }
    LittleMemory(const LittleMemory&) = delete;
    ~LittleMemory() {
        give_back();
        for (void* piece : taken_) cudaFreeAsync(piece, nullptr);
        cudaStreamSynchronize(nullptr);
        cudaMemPoolDestroy(pool_);
    }
    void take() const { cudaDeviceSetMemPool(0, pool_); }
    void give_back() const { cudaDeviceSetMemPool(0, before_); }

private:
    static constexpr std::size_t piece_bytes = std::size_t{2} << 20, pool_bytes = 16 * piece_bytes;

    cudaMemPool_t before_ = nullptr, pool_ = nullptr;
    std::vector<void*> taken_;
};

TEST(CudaLittleMemoryTest, AStepThatRunsOutOfMemoryIsForgotten) {
    if (!cuda_problem().empty()) GTEST_SKIP() << cuda_problem();
    test::Random random(5);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const MeshData ring = scenes::torus(1, 0.4, 18, 10);
    int failed = 0;
    for (const bool deforms : {false, true})
        for (const int left : {0, 1, 2}) {
            const LittleMemory little(left);  // outlives what is allocated from it
            World there(cuda_backend()), here(bvh_backend());
            constexpr std::size_t bodies = 10;
            std::vector<BodyId> ids[2];
            for (World* world : {&there, &here}) {
                const MeshId mesh = world->add_mesh("ring", ring);
                for (std::size_t b = 0; b < bodies; ++b)
                    ids[world == &here].push_back(deforms ? world->add_deforming_body(mesh)
                                                          : world->add_rigid_body(mesh));
            }
            const auto move = [&](double spread) {
                for (std::size_t b = 0; b < bodies; ++b) {
                    const Pose pose{random.in_box(spread), random.rotation()};
                    for (World* world : {&there, &here}) {
                        const BodyId body = ids[world == &here][b];
                        if (deforms)
                            world->set_positions(body, test::placed(ring, pose));
                        else
                            world->set_pose(body, pose);
                    }
                }
            };
            const auto step = [&] {
                there.detect();
                here.detect();
                ASSERT_EQ(contact_hash(there.contacts()), contact_hash(here.contacts()))
                    << left << " pieces left";
            };
            // What fails, if it does, is a first step, or one that finds more than those before.
            const auto step_with_little = [&] {
                little.take();
                try {
                    there.detect();
                } catch (const OutOfMemory& error) {
                    EXPECT_NE(std::string(error.what()).find("out of memory"), std::string::npos)
                        << error.what();
                    EXPECT_TRUE(there.contacts().empty());
                    ++failed;
                }
                little.give_back();
            };
            move(1.5);
            step_with_little();
            // Steps are captured by the end of these.
            for (int i = 0; i < 8; ++i) {
                move(20);
                step();
            }
            // Every step finds more than the one before.
            for (int i = 0; i < 6; ++i) {
                const double spread = 2 - 0.3 * i;
                move(spread);
                step_with_little();
                if (i % 2 == 0) move(spread);
                step();
            }
        }
    EXPECT_GT(failed, 3);
}

}  // namespace
}  // namespace pierce
