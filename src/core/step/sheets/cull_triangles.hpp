#pragma once

#include "core/device/bits.hpp"
#include "core/device/interleaved.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/step/sheets/flat_stars.hpp"
#include "core/step/sheets/four_drifting_pairs.hpp"
#include "core/step/sheets/quick_triangle.hpp"
#include "core/step/sheets/sheet_search.hpp"
#include "pierce/min_max.hpp"

/// Sheets, first part, continued: which of the triangles whose boxes are near are kept apart by a
/// direction, or hang together where nothing folds.
namespace pierce::stages {

/// Two triangles whose features are to be tested.
struct alignas(16) TrianglePair {
    std::uint32_t pair = 0;
    std::uint32_t first = 0, second = 0;  ///< places of triangles of the pair's first and second
                                          ///< body
    std::uint32_t separate = 0;           ///< 1: it is known that they do not meet
};

/// For a triangle and another one of its body that is near: 1 if they hang together where nothing
/// folds.
struct HangTogether {
    View<const NearInGroup> near;
    View<const FlatCorners> flat_corners;

    PIERCE_HD std::uint32_t operator()(std::uint32_t i, std::uint32_t bit) const {
        const NearInGroup n = read_whole(near[i]);
        return read_whole(flat_corners[n.first])
            .shares_one(read_whole(flat_corners[n.others + bit]));
    }
};

/// Per triangle with others near: those that do not hang together with it where nothing folds, and
/// that no normal of the two and no line between their middles keeps apart.
struct CullTriangles {
    View<const SheetPair> pairs;
    View<const NearInGroup> near;
    Interleaved<const DriftingTriangle> drifting;
    View<const FlatCorners> flat_corners;

    static constexpr std::uint32_t separate_shift = asked_bits;  ///< shift of the bits for
                                                                 ///< triangles that do not meet
    static_assert(asked_bits == constants::group_size);

    /// A bit for each triangle, and in the upper half one more if the two do not meet. Triangles
    /// that hang together are taken out first: in a GPU's warp they would wait for the others.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const { return ask_bits(asked(i), i, *this); }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) {
        return bit_count(found & ((1u << separate_shift) - 1));
    }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         TrianglePair* triangles) const {
        write_bits<asked_bits>(
            found, i, place,
            [&](std::uint32_t item, std::uint32_t mask, std::uint32_t bit, std::uint32_t at) {
                const NearInGroup n = read_whole(near[item]);
                write_whole(triangles[at],
                            {n.pair, n.first, n.others + bit, mask >> (separate_shift + bit) & 1});
            });
    }

    /// For a triangle and another one near: 0 if a direction keeps them apart, else 1, and 2 more
    /// if they do not meet.
    PIERCE_HD std::uint32_t operator()(std::uint32_t i, std::uint32_t bit) const {
        const NearInGroup n = read_whole(near[i]);
        const float margin = pairs[n.pair].quick_margin;
        const DriftingPair both(drifting.read(n.first), drifting.read(n.others + bit));
        Company company = both.along_normal_of_a(margin);
        if (!company.is_settled()) company.learn(both.along_normal_of_b(margin));
        if (!company.is_settled()) company.learn(both.along_middles(margin));
        return company.is_settled() ? 0 : 1 | static_cast<std::uint32_t>(company.separate) << 1;
    }

#if defined(PIERCE_FOUR_LANES)
    /// What find() would find, four pairs of triangles at a time.
    void find_all(std::uint32_t begin, std::uint32_t end, std::uint32_t* found) const {
        for (std::uint32_t next = begin; begin < end; begin = next, found += some) {
            next = min_of(begin + some, end);
            Job jobs[some * constants::group_size];
            std::uint32_t count = 0;
            for (std::uint32_t i = begin; i < next; ++i) {
                found[i - begin] = 0;
                for (std::uint32_t left = asked(i); left != 0; left &= left - 1)
                    jobs[count++] = {i - begin, lowest_bit(left)};
            }
            for (std::uint32_t k = 0; k < count; k += Four::count)
                ask_four(jobs + k, min_of(count - k, Four::count), begin, found);
        }
    }
#endif

private:
    /// The triangles near that do not hang together with the item's.
    PIERCE_HD std::uint32_t asked(std::uint32_t i) const {
        const NearInGroup n = read_whole(near[i]);
        const bool in_itself = pairs[n.pair].is_self();
        return n.mask & ~ask_bits(in_itself ? n.mask : 0, i, HangTogether{near, flat_corners});
    }

#if defined(PIERCE_FOUR_LANES)
    static constexpr std::uint32_t some = 32;  ///< items whose triangles are asked about together

    /// An item and a bit of its mask.
    struct Job {
        std::uint32_t item, bit;
    };

    /// Asks about one to four pairs.
    void ask_four(const Job* jobs, std::uint32_t count, std::uint32_t begin,
                  std::uint32_t* found) const {
        FourTriangles a{}, b{};
        float margin[Four::count];
        for (std::uint32_t lane = 0; lane < Four::count; ++lane) {
            // The last one stands in all lanes that are left.
            const Job& job = jobs[min_of(lane, count - 1)];
            const NearInGroup& n = near[begin + job.item];
            a.triangle[lane] = &drifting.items[n.first];
            b.triangle[lane] = &drifting.items[n.others + job.bit];
            margin[lane] = pairs[n.pair].quick_margin;
        }
        const FourDriftingPairs both(a, b);
        const Four margins = Four::FourLanes{margin[0], margin[1], margin[2], margin[3]};
        FourCompanies companies = both.along_normal_of_a(margins);
        if (companies.settled() != Four::all_bits) companies.learn(both.along_middles(margins));
        if (companies.settled() != Four::all_bits) companies.learn(both.along_normal_of_b(margins));
        for (std::uint32_t left = ~companies.settled() & ((1u << count) - 1); left != 0;
             left &= left - 1) {
            const std::uint32_t lane = lowest_bit(left);
            found[jobs[lane].item] |= (1u | (companies.separate >> lane & 1) << separate_shift)
                                      << jobs[lane].bit;
        }
    }
#endif
};

}  // namespace pierce::stages
