#include "core/mesh_build/kept_order.hpp"

namespace pierce {

std::vector<std::uint32_t> kept_order(std::span<const std::uint32_t> before,
                                      std::span<const std::uint32_t> now_of, std::uint32_t count) {
    std::vector<bool> has_place(count, false);
    for (std::uint32_t now : now_of)
        if (now != is_gone) has_place[now] = true;

    std::vector<std::uint32_t> order;
    order.reserve(before.size());
    std::vector<std::size_t> free;
    for (std::uint32_t thing : before) {
        std::uint32_t now = now_of[thing];
        if (now == is_gone && thing < count && !has_place[thing]) {
            now = thing;
            has_place[thing] = true;
        }
        if (now == is_gone) free.push_back(order.size());
        order.push_back(now);
    }
    std::size_t filled = 0;
    for (std::uint32_t thing = 0; thing < count; ++thing) {
        if (has_place[thing]) continue;
        if (filled < free.size())
            order[free[filled++]] = thing;
        else
            order.push_back(thing);
    }
    for (; filled < free.size(); ++filled) {
        while (!order.empty() && order.back() == is_gone) order.pop_back();
        if (free[filled] >= order.size()) break;
        order[free[filled]] = order.back();
        order.pop_back();
    }
    return order;
}

}  // namespace pierce
