#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace pierce {

/// Where things of several items each lie in one long array: one after the other at first. A thing
/// that outgrows its place moves into the room behind them.
class Places {
public:
    /// Lays the things out anew, with room for `spare` items behind them.
    void lay_out(std::span<const std::uint32_t> sizes, std::uint32_t spare) {
        places_.clear();
        used_ = 0;
        for (std::uint32_t size : sizes) {
            places_.push_back({.first = used_, .size = size, .room = size});
            used_ += size;
        }
        room_ = used_ + spare;
    }

    /// Gives a thing another size, and a place that is large enough, with room to grow. False if
    /// there is no room for it: all must be laid out anew then.
    bool resize(std::uint32_t thing, std::uint32_t size) {
        Place& place = places_[thing];
        if (size > place.room) {
            const std::uint32_t with_room = size + size / growth_share;
            if (with_room > room_ - used_) return false;
            place = {.first = used_, .size = size, .room = with_room};
            used_ += with_room;
        }
        place.size = size;
        return true;
    }

    std::uint32_t first(std::uint32_t thing) const { return places_[thing].first; }
    std::uint32_t size(std::uint32_t thing) const { return places_[thing].size; }
    /// How many items the array has, used or not.
    std::uint32_t room() const { return room_; }

private:
    static constexpr std::uint32_t growth_share = 4;  ///< a thing that has grown may grow again

    struct Place {
        std::uint32_t first = 0, size = 0, room = 0;
    };

    std::vector<Place> places_;
    std::uint32_t used_ = 0, room_ = 0;
};

}  // namespace pierce
