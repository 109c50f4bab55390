#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace pierce {

/// Numbers that are joined to sets step by step (union-find with path halving).
class DisjointSets {
public:
    explicit DisjointSets(std::size_t size) : parent_(size) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    /// The number that stands for the set of `i`: the same for all numbers of the set.
    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }

    void join(std::uint32_t i, std::uint32_t j) { parent_[root(i)] = root(j); }

private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace pierce
