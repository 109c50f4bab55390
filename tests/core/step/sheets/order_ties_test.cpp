// The order of features with the same key, against a stable sort.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/step/sheets/sheet_contacts.hpp"
#include "support/random.hpp"

namespace pierce::stages {
namespace {

TEST(OrderTiesTest, FeaturesOfOneKeyAreInTheOrderOfTheirOtherFeatures) {
    test::Random random(1);
    for (int i = 0; i < 500; ++i) {
        std::vector<FeaturePair> features;
        std::vector<std::uint64_t> keys;
        for (std::uint32_t key = 0; key < 20; ++key) {
            const auto few = static_cast<int>(constants::few_ties);
            const int ties = random.integer(0, 9) == 0 ? random.integer(1, 40 * few)
                                                       : random.integer(1, few + 2);
            for (int k = 0; k < ties; ++k) {
                FeaturePair f;
                f.other = static_cast<std::uint32_t>(random.integer(0, 2 * ties));
                features.push_back(f);
                keys.push_back(key);
            }
        }
        const auto size = static_cast<std::uint32_t>(keys.size());
        std::vector<std::uint32_t> order(size);
        std::iota(order.begin(), order.end(), 0u);
        std::vector<std::uint32_t> expected = order;
        std::stable_sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) {
            return keys[a] != keys[b] ? keys[a] < keys[b] : features[a].other < features[b].other;
        });
        const OrderTies ties{{features.data(), size}, {keys.data(), size}, {order.data(), size}};
        // From the back, so that no result rests on the order in which a backend takes the items.
        for (std::uint32_t k = size; k-- > 0;) ties(k);
        ASSERT_EQ(order, expected) << "seed " << random.seed() << ", case " << i;
    }
}

}  // namespace
}  // namespace pierce::stages
