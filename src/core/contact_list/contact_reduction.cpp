#include "pierce/contact_reduction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"

namespace pierce {
namespace {

/// A force and its torque.
using Wrench = std::array<double, least_reduced>;

Vec3d place_of(const Contact& c) { return 0.5 * (c.point_a + c.point_b); }

/// Contacts of one pair, by their places in a list.
class PairReduction {
public:
    PairReduction(std::span<const Contact> list, std::span<const std::uint32_t> places)
        : list_(list), places_(places) {
        Box box;
        for (std::uint32_t place : places) box.extend(place_of(list[place]));
        center_ = box.center();
        size_ = box.extent() > 0 ? box.extent() : 1;
    }

    void reduce_to(std::uint32_t most, std::vector<ReducedContact>& result) {
        std::vector<std::uint32_t> pushing, resting;
        for (std::uint32_t i = 0; i < places_.size(); ++i)
            (contact(i).penetration_depth() > 0 ? pushing : resting).push_back(i);
        std::vector<Weighted> kept;
        for (std::uint32_t i : preferred(pushing, most)) kept.push_back({i, 1.0});
        while (kept.size() > most && drop_one(kept)) {
        }
        std::erase_if(kept, [](const Weighted& k) { return !(k.weight > 0); });
        const std::uint32_t room = most - static_cast<std::uint32_t>(
                                              std::min<std::size_t>(kept.size(), most));
        const std::vector<std::uint32_t> others = preferred(resting, room);
        for (std::uint32_t i = 0; i < std::min<std::size_t>(room, others.size()); ++i)
            kept.push_back({others[i], 1.0});
        for (const Weighted& k : kept) result.push_back({places_[k.contact], k.weight});
    }

private:
    struct Weighted {
        std::uint32_t contact = 0;
        double weight = 1;
    };

    /// The same contacts in another order: the deepest one, then `most` of them one after the
    /// other, each as far as can be from those before it, then the rest by depth.
    std::vector<std::uint32_t> preferred(std::vector<std::uint32_t> places,
                                         std::uint32_t most) const {
        std::ranges::stable_sort(places, {}, [&](std::uint32_t i) { return contact(i).distance; });
        std::vector<Left> left;
        left.reserve(places.size());
        for (const std::uint32_t i : places)
            left.push_back({i, place_of(contact(i)), contact(i).normal});
        places.clear();
        for (std::size_t taken = 0; !left.empty() && places.size() < most;) {
            const Left last = left[taken];
            places.push_back(last.contact);
            // The others keep their order.
            left.erase(left.begin() + static_cast<std::ptrdiff_t>(taken));
            taken = 0;
            for (std::size_t i = 0; i < left.size(); ++i) {
                left[i].gap = std::min(left[i].gap, between(left[i], last));
                if (left[i].gap > left[taken].gap) taken = i;
            }
        }
        for (const Left& other : left) places.push_back(other.contact);
        return places;
    }

    /// A contact that was not taken yet, and how far it is from those that were.
    struct Left {
        std::uint32_t contact;
        Vec3d place, normal;
        double gap = std::numeric_limits<double>::infinity();
    };

    double between(const Left& a, const Left& b) const {
        return length_squared((1 / size_) * (a.place - b.place)) +
               length_squared(a.normal - b.normal);
    }

    Wrench wrench_of(std::uint32_t i) const {
        const Contact& c = contact(i);
        const Vec3d force = c.penetration_depth() * c.normal,
                    torque = (1 / size_) * cross(place_of(c) - center_, force);
        return {force.x, force.y, force.z, torque.x, torque.y, torque.z};
    }

    /// Leaves out one of the last seven contacts; the others' weights make up for it. Seven vectors
    /// with six numbers depend on each other: some multiple of that dependence takes one weight to
    /// zero and leaves the others positive. Of the two ways, the shorter one lets weights grow
    /// less.
    bool drop_one(std::vector<Weighted>& kept) const {
        constexpr std::size_t count = least_reduced + 1;
        const std::size_t begin = kept.size() - count;
        std::array<Wrench, count> columns{};
        for (std::size_t k = 0; k < count; ++k) columns[k] = wrench_of(kept[begin + k].contact);
        const std::array<double, count> dependence = null_vector(columns);
        std::size_t gone = count;
        double step = std::numeric_limits<double>::infinity();
        for (const double sign : {1.0, -1.0})
            for (std::size_t k = 0; k < count; ++k) {
                const double down = -sign * dependence[k];
                if (!(down > 0) || !(kept[begin + k].weight / down < std::fabs(step))) continue;
                step = sign * kept[begin + k].weight / down;
                gone = k;
            }
        if (gone == count) return false;
        for (std::size_t k = 0; k < count; ++k)
            kept[begin + k].weight = std::max(kept[begin + k].weight + step * dependence[k], 0.0);
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(begin + gone));
        return true;
    }

    /// Numbers, not all zero, by which the columns add up to zero: by elimination with the largest
    /// pivot of what is left.
    static std::array<double, least_reduced + 1> null_vector(
        std::array<Wrench, least_reduced + 1> columns) {
        constexpr std::size_t rows = least_reduced, count = least_reduced + 1;
        std::array<std::size_t, count> order{};
        for (std::size_t k = 0; k < count; ++k) order[k] = k;
        double largest = 0;
        for (const Wrench& c : columns)
            for (double x : c) largest = std::max(largest, std::fabs(x));
        std::size_t rank = 0;
        for (; rank < rows; ++rank) {
            std::size_t row = rank, column = rank;
            for (std::size_t c = rank; c < count; ++c)
                for (std::size_t r = rank; r < rows; ++r)
                    if (std::fabs(columns[c][r]) > std::fabs(columns[column][row])) {
                        row = r;
                        column = c;
                    }
            if (!(std::fabs(columns[column][row]) > largest * constants::double_rounding)) break;
            std::swap(columns[rank], columns[column]);
            std::swap(order[rank], order[column]);
            for (Wrench& c : columns) std::swap(c[rank], c[row]);
            for (std::size_t r = rank + 1; r < rows; ++r) {
                const double factor = columns[rank][r] / columns[rank][rank];
                for (std::size_t c = rank; c < count; ++c)
                    columns[c][r] -= factor * columns[c][rank];
            }
        }
        // The first column without a pivot in terms of those with one.
        std::array<double, count> numbers{};
        std::array<double, count> result{};
        numbers[rank] = 1;
        for (std::size_t r = rank; r-- > 0;) {
            double sum = 0;
            for (std::size_t c = r + 1; c <= rank; ++c) sum += columns[c][r] * numbers[c];
            numbers[r] = -sum / columns[r][r];
        }
        for (std::size_t k = 0; k < count; ++k) result[order[k]] = numbers[k];
        return result;
    }

    const Contact& contact(std::uint32_t i) const { return list_[places_[i]]; }

    std::span<const Contact> list_;
    std::span<const std::uint32_t> places_;
    Vec3d center_;
    double size_ = 1;
};

}  // namespace

std::vector<ReducedContact> reduce(std::span<const Contact> contacts, std::uint32_t most_per_pair) {
    if (most_per_pair < least_reduced)
        throw InputError("contacts are reduced to " + std::to_string(least_reduced) +
                         " a pair or more, not " + std::to_string(most_per_pair));
    // A sheet and a solid have contacts of solids and, further on, contacts of sheets.
    std::vector<std::uint32_t> places(contacts.size());
    std::iota(places.begin(), places.end(), 0u);
    const auto pair_of = [&](std::uint32_t i) {
        return std::pair(contacts[i].a.index, contacts[i].b.index);
    };
    std::ranges::stable_sort(places, {}, pair_of);
    std::vector<ReducedContact> result;
    for (std::size_t begin = 0, end = 0; begin < places.size(); begin = end) {
        while (end < places.size() && pair_of(places[end]) == pair_of(places[begin])) ++end;
        const std::span of_pair = std::span(places).subspan(begin, end - begin);
        if (of_pair.size() > most_per_pair)
            PairReduction(contacts, of_pair).reduce_to(most_per_pair, result);
        else
            for (const std::uint32_t place : of_pair) result.push_back({place, 1.0});
    }
    std::ranges::sort(result, {}, &ReducedContact::contact);
    return result;
}

}  // namespace pierce
