#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "pierce/error.hpp"
#include "pierce/ids.hpp"

namespace pierce {

/// Finds things by handle. Slots are reused, and a generation tells a new thing from an earlier one
/// in the same slot.
template <class Tag, class Thing>
class SlotMap {
public:
    struct Slot {
        Thing thing{};
        std::uint32_t generation = 1;
        bool used = false;
    };

    Id<Tag> add(Thing thing) {
        std::uint32_t index = first_free_;
        while (index < slots_.size() && slots_[index].used) ++index;
        if (index == slots_.size()) slots_.emplace_back();
        first_free_ = index + 1;
        slots_[index].thing = std::move(thing);
        slots_[index].used = true;
        return {index, slots_[index].generation};
    }

    void remove(Id<Tag> id, const char* what) {
        get(id, what);
        Slot& slot = slots_[id.index];
        slot.thing = {};
        slot.used = false;
        ++slot.generation;
        if (id.index < first_free_) first_free_ = id.index;
    }

    /// Throws InputError, naming `what`, for a handle that names no thing.
    Thing& get(Id<Tag> id, const char* what) {
        if (!id) throw InputError(std::string(what) + " handle is null");
        if (id.index >= slots_.size() || !slots_[id.index].used ||
            slots_[id.index].generation != id.generation)
            throw InputError(std::string(what) + " " + std::to_string(id.index) +
                             " was removed or is not of this world");
        return slots_[id.index].thing;
    }
    const Thing& get(Id<Tag> id, const char* what) const {
        return const_cast<SlotMap*>(this)->get(id, what);
    }

    std::vector<Slot>& slots() { return slots_; }
    const std::vector<Slot>& slots() const { return slots_; }

private:
    std::vector<Slot> slots_;
    std::uint32_t first_free_ = 0;  ///< no slot before this one is free
};

}  // namespace pierce
