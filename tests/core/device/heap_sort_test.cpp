// Sorting in place against the standard library's sort.
#include "core/device/heap_sort.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/random.hpp"

namespace pierce {
namespace {

TEST(HeapSortTest, SortsAsTheStandardLibraryDoes) {
    test::Random random(1);
    for (int i = 0; i < 2000; ++i) {
        const int count = random.integer(0, 100), values = random.integer(1, 100);
        std::vector<int> items;
        for (int k = 0; k < count; ++k) items.push_back(random.integer(0, values));
        std::vector<int> expected = items;
        std::sort(expected.begin(), expected.end());
        heap_sort(items.data(), static_cast<std::uint32_t>(items.size()),
                  [](int a, int b) { return a < b; });
        ASSERT_EQ(items, expected) << "seed " << random.seed() << ", case " << i;
    }
}

TEST(HeapSortTest, TakesNLogNStepsWhateverTheOrder) {
    constexpr std::uint32_t count = 1 << 14, log = 14;
    for (const int way : {1, -1, 0}) {
        std::vector<int> items;
        for (std::uint32_t k = 0; k < count; ++k) items.push_back(way * static_cast<int>(k));
        std::uint64_t compared = 0;
        heap_sort(items.data(), count, [&](int a, int b) {
            ++compared;
            return a < b;
        });
        EXPECT_TRUE(std::is_sorted(items.begin(), items.end()));
        EXPECT_LT(compared, std::uint64_t{3} * count * log);
    }
}

}  // namespace
}  // namespace pierce
