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
        const auto is_taken = [](const Slot& slot) {
            return slot.used || slot.generation == 0;  // all of its generations are used up
        };
        while (index < slots_.size() && is_taken(slots_[index])) ++index;
        if (index == slots_.size()) slots_.emplace_back();
        first_free_ = index + 1;
        slots_[index].thing = std::move(thing);
        slots_[index].used = true;
        ++arrivals_;
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

    /// Puts a thing where a handle says, in place of what is there.
    void put(Id<Tag> id, Thing thing) {
        if (id.index >= slots_.size()) slots_.resize(id.index + std::size_t{1});
        slots_[id.index] = {std::move(thing), id.generation, true};
        ++arrivals_;
    }

    /// Makes a handle invalid for ever, whether or not it was ever put here.
    void retire(Id<Tag> id) {
        if (id.index >= slots_.size()) slots_.resize(id.index + std::size_t{1});
        Slot& slot = slots_[id.index];
        if (slot.generation > id.generation) return;
        slot = {{}, id.generation + 1, false};
        if (id.index < first_free_) first_free_ = id.index;
    }

    /// Takes a thing away; its handle may be put again.
    Thing take(Id<Tag> id, const char* what) {
        Thing thing = std::move(get(id, what));
        slots_[id.index] = {{}, id.generation, false};
        if (id.index < first_free_) first_free_ = id.index;
        return thing;
    }

    /// True if the handle names a thing.
    bool contains(Id<Tag> id) const {
        return id.index < slots_.size() && slots_[id.index].used &&
               slots_[id.index].generation == id.generation;
    }
    /// Throws InputError, naming `what`, for a handle that names no thing.
    Thing& get(Id<Tag> id, const char* what) {
        if (!id) throw InputError(std::string(what) + " handle is null");
        if (!contains(id))
            throw InputError(std::string(what) + " " + std::to_string(id.index) +
                             " was removed or is not of this world");
        return slots_[id.index].thing;
    }
    const Thing& get(Id<Tag> id, const char* what) const {
        return const_cast<SlotMap*>(this)->get(id, what);
    }

    /// How many things have been added or put here.
    std::uint64_t arrivals() const { return arrivals_; }

    std::vector<Slot>& slots() { return slots_; }
    const std::vector<Slot>& slots() const { return slots_; }

private:
    std::vector<Slot> slots_;
    std::uint32_t first_free_ = 0;  ///< no slot before this one is free
    std::uint64_t arrivals_ = 0;
};

}  // namespace pierce
