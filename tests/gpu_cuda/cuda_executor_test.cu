// What a bounded step does when a list outgrows its room.
#include "gpu_cuda/cuda_executor.cuh"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "core/device/view.hpp"

namespace pierce {
namespace {

constexpr std::uint32_t poison = 0xffffffffu;
constexpr std::uint32_t few = 4, many = 5000;  // many do not fit into the room of a few

/// Every item lists itself.
struct ListAll {
    PIERCE_HD std::uint32_t find(std::uint32_t i) const { return i; }
    PIERCE_HD static std::uint32_t count(std::uint32_t) { return 1; }
    PIERCE_HD void write(std::uint32_t, std::uint32_t found, std::uint32_t place,
                         std::uint32_t* list) const {
        list[place] = found;
    }
};

/// Counts what is read: items of the list, and items that nobody has written.
struct ReadList {
    View<const std::uint32_t> list;
    std::uint32_t* seen;

    __device__ void operator()(std::uint32_t i) const { atomicAdd(seen + (list[i] == poison), 1u); }
};

class BoundedStepTest : public testing::Test {
protected:
    void SetUp() override {
        int devices = 0;
        if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0)
            GTEST_SKIP() << "there is no GPU";
        executor_.emplace();
        executor_->assign(list_, many, poison);
        executor_->begin_exact(0);
        executor_->emit(ListId::undecided_features, few, ListAll{}, list_);
        executor_->end();
        ASSERT_TRUE(executor_->finish());
        executor_->assign(list_, many, poison);
        executor_->assign(seen_, 2, 0u);
    }

    void emit_and_read(std::uint32_t count) {
        executor_->emit(ListId::undecided_features, count, ListAll{}, list_);
        executor_->for_each(count_of(list_), ReadList{view_of(list_), seen_.data()});
    }

    std::vector<std::uint32_t> seen() { return executor_->download(seen_); }

    std::optional<CudaExecutor> executor_;
    CudaExecutor::Buffer<std::uint32_t> list_, seen_;
};

TEST_F(BoundedStepTest, AListThatFitsIsReadAsAWhole) {
    executor_->begin_bounded(1);
    executor_->beside([&] { emit_and_read(few); });
    executor_->join();
    executor_->end();
    EXPECT_TRUE(executor_->finish());
    EXPECT_EQ(seen(), (std::vector<std::uint32_t>{few, 0}));
}

TEST_F(BoundedStepTest, AListThatHasOutgrownItsRoomIsNotRead) {
    executor_->begin_bounded(1);
    emit_and_read(many);
    executor_->end();
    EXPECT_FALSE(executor_->finish());
    EXPECT_EQ(seen()[1], 0u);
}

TEST_F(BoundedStepTest, NorIsOneOfTheWorkBesideTheRest) {
    executor_->begin_bounded(1);
    executor_->beside([&] { emit_and_read(many); });
    executor_->join();
    executor_->end();
    EXPECT_FALSE(executor_->finish());
    EXPECT_EQ(seen()[1], 0u);
}

}  // namespace
}  // namespace pierce
