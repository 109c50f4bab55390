#pragma once

#include <cstdint>
#include <vector>

#include "pierce/box.hpp"

namespace pierce {

/// Boxes in a balanced tree, for questions asked once when a mesh is made.
class BoxTree {
public:
    explicit BoxTree(std::vector<Box> boxes);

    /// Calls visit(i) for every box i that `wanted` is true for. `wanted` must also be true for
    /// every box around such a box.
    template <class Test, class F>
    void for_each_that(Test wanted, F visit) const {
        std::vector<std::uint32_t> open{0};
        while (!open.empty()) {
            const Node node = nodes_[open.back()];
            open.pop_back();
            if (!wanted(node.box)) continue;
            if (node.count == 0) {
                open.push_back(node.first);
                open.push_back(node.first + 1);
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                if (wanted(boxes_[order_[i]])) visit(order_[i]);
        }
    }

    /// Calls visit(i) for every box i that overlaps `region`.
    template <class F>
    void for_each_in(const Box& region, F visit) const {
        for_each_that([&](const Box& box) { return overlap(box, region); }, visit);
    }

private:
    struct Node {
        Box box;
        std::uint32_t first = 0;  ///< of a leaf's boxes in order_, or of two children in nodes_
        std::uint32_t count = 0;  ///< number of boxes in a leaf; 0: not a leaf
    };

    void split(std::uint32_t node, std::uint32_t first, std::uint32_t last);

    std::vector<Box> boxes_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace pierce
