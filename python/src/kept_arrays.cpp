#include "kept_arrays.hpp"

#include <utility>

namespace pierce::python {

void KeptArrays::keep(std::span<const BodyId> bodies, nb::object array) {
    std::uint32_t slot = 0;
    if (array.is_valid()) {
        while (slot < slots_.size() && slots_[slot].bodies > 0) ++slot;
        if (slot == slots_.size()) slots_.emplace_back();
        slots_[slot].array = std::move(array);
        ++slot;
    } else if (slot_of_.empty()) {
        return;
    }
    for (const BodyId body : bodies) {
        if (body.index >= slot_of_.size()) slot_of_.resize(body.index + 1, 0);
        const std::uint32_t last = slot_of_[body.index];
        slot_of_[body.index] = slot;
        if (slot > 0) ++slots_[slot - 1].bodies;
        if (last > 0 && --slots_[last - 1].bodies == 0) slots_[last - 1].array.reset();
    }
}

}  // namespace pierce::python
