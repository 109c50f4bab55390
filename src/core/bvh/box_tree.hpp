#pragma once

#include <cstdint>
#include <vector>

#include "pierce/core/box.hpp"

namespace pierce {

/// Boxes in a balanced tree, for questions asked once when a mesh is made.
class BoxTree {
public:
    explicit BoxTree(std::vector<Box> boxes);

    /// Calls visit(i) for every box i that overlaps `region`.
    template <class F>
    void for_each_in(const Box& region, F visit) const {
        std::vector<std::uint32_t> open{0};
        while (!open.empty()) {
            const Node node = nodes_[open.back()];
            open.pop_back();
            if (!overlap(node.box, region)) continue;
            if (node.count == 0) {
                open.push_back(node.first);
                open.push_back(node.first + 1);
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                if (overlap(boxes_[order_[i]], region)) visit(order_[i]);
        }
    }

private:
    struct Node {
        Box box;
        std::uint32_t first = 0;  ///< of a leaf's boxes in order_, or of two children in nodes_
        std::uint32_t count = 0;  ///< of boxes in a leaf; 0: not a leaf
    };

    void split(std::uint32_t node, std::uint32_t first, std::uint32_t last);

    std::vector<Box> boxes_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace pierce
