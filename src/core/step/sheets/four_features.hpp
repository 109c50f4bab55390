#pragma once

#include "core/device/bits.hpp"
#include "core/device/four.hpp"
#include "core/step/sheets/feature_bits.hpp"
#include "core/step/sheets/placed_triangle.hpp"
#include "core/step/sheets/quick_prism.hpp"
#include "pierce/constants.hpp"

#if defined(PIERCE_FOUR_LANES)

/// QuickPrism and may_cross_over() for four pairs of features at once: the same formulas with the
/// same bounds, a lane each.
namespace pierce::stages {

/// What is known of four pairs of features; a bit for each.
struct FourNearby {
    std::uint32_t possible = 0;  ///< they may be over each other and close
    std::uint32_t hidden = 0;    ///< of these, where one more direction is to be tried: rounding
                                 ///< hides the places
};

/// The bounds of rounding errors (quick_prism.hpp) for four.
inline Four made_up_of_four(Four size) {
    return Four(constants::quick_product_rounding) * (size * size) * (size * size);
}
inline Four made_up_across(FourVec3 n, Four size) {
    return Four(constants::quick_rounding) * sum_of_sizes(n) * size +
           Four(constants::quick_common_normal_rounding) * (size * size * size);
}
inline std::uint32_t is_beyond(Four margin, Four ahead, Four normal_squared) {
    return greater(ahead, 0) & greater(ahead * ahead, margin * margin * normal_squared);
}

/// QuickPrism::may_hold() of four points and the triangles `at`.
inline FourNearby may_hold(const FourVec3 (&at)[3], const FourVec3& p, Four margin, Four size) {
    const FourVec3 normal = cross(at[1] - at[0], at[2] - at[0]);
    const Four made_up = made_up_of_four(size), least = -made_up,
               squared = quick_dot(normal, normal);
    std::uint32_t out = is_beyond(
        margin, abs_of(quick_dot(normal, p - at[0])) - made_up_across(normal, size), squared);
    for (int k = 0; k < 3 && out != Four::all_bits; ++k)
        out |= greater(least, quick_dot(cross(normal, at[k == 2 ? 0 : k + 1] - at[k]), p - at[k]));
    const std::uint32_t possible = ~out & Four::all_bits;
    return {possible, possible & ~greater(squared, Four(constants::quick_hidden) * made_up)};
}

/// may_cross_over() of four pairs of edges, from `p` to `q` and from `r` to `s`.
inline FourNearby may_cross_over(const FourVec3& p, const FourVec3& q, const FourVec3& r,
                                 const FourVec3& s, Four margin, Four size) {
    const FourVec3 d = q - p, e = s - r, n = cross(d, e), way = r - p;
    const Four made_up = made_up_of_four(size), least = -made_up;
    const FourVec3 beside_e = cross(e, n);
    std::uint32_t out = greater(least, quick_dot(way, beside_e)) |
                        greater(quick_dot(r - q, beside_e), made_up);
    if (out == Four::all_bits) return {};
    const FourVec3 beside_d = cross(d, n);
    const Four squared = quick_dot(n, n);
    out |= greater(least, quick_dot(way, beside_d)) | greater(quick_dot(s - p, beside_d), made_up) |
           is_beyond(margin, abs_of(quick_dot(n, way)) - made_up_across(n, size), squared);
    const std::uint32_t possible = ~out & Four::all_bits;
    return {possible, possible & ~greater(squared, Four(constants::quick_hidden) * made_up)};
}

/// Some pairs of triangles, whose features are asked about four at a time.
class FourFeatures {
public:
    static constexpr std::uint32_t most = 32;  ///< pairs of triangles

    /// Adds two triangles. `features`: those to ask about (FeatureBits), vertices and edges.
    void add(const DriftingTriangle& first, const DriftingTriangle& second, float thickness,
             float margin, std::uint32_t features) {
        const Four origin = Four::at(&first.corner[0]);
        Four* const row = &rows_[rows_per_pair * count_];
        Four largest = 0;
        for (std::uint32_t k = 0; k < 3; ++k) {
            row[k] = Four::at(&first.corner[k]) - origin;
            row[of_second + k] = Four::at(&second.corner[k]) - origin;
            largest = max_of(abs_of(row[k]), max_of(abs_of(row[of_second + k]), largest));
        }
        row[3] = row[0];
        row[of_second + 3] = row[of_second];
        sizes_[count_] = {quick_max(largest[0], quick_max(largest[1], largest[2])), thickness,
                          margin};
        const std::uint32_t vertices = features & ((1u << FeatureBits::edges) - 1);
        list<2>(vertices, vertices_, vertex_count_);
        list<4>(features & ~vertices, edges_, edge_count_);
        ++count_;
    }

    /// For each two triangles: which of the features may be over each other and close.
    void answer(std::uint32_t* answers) {
        for (std::uint32_t k = 0; k < count_; ++k) answers[k] = 0;
        each_four(vertices_, vertex_count_, answers,
                  [&](const Question* asked) { return ask_vertices(asked); });
        each_four(edges_, edge_count_, answers,
                  [&](const Question* asked) { return ask_edges(asked); });
    }

private:
    /// The corners of two triangles at the end of the step, relative to one of them: those of the
    /// first and its first one again, then those of the second likewise.
    static constexpr std::uint32_t rows_per_pair = 8, of_second = 4;

    struct Sizes {
        float size;  ///< no coordinate is larger
        float thickness, margin;
    };
    /// A vertex and the first corner of a triangle, or the first ends of two edges, by their rows.
    /// All in one word, so that it is made by one sum.
    class Question {
    public:
        Question() = default;
        /// A feature of the pair 0.
        constexpr explicit Question(std::uint32_t bit) {
            const std::uint32_t both = bit - FeatureBits::edges;
            if (bit < FeatureBits::vertex_of_second)
                word_ = word(bit, of_second, 0, bit);
            else if (bit < FeatureBits::edges)
                word_ = word(of_second + bit - FeatureBits::vertex_of_second, 0, 0, bit);
            else
                word_ = word(both / 4, of_second + both % 4, 0, bit);
        }
        /// The same feature of another pair.
        constexpr Question of_pair(std::uint32_t pair) const {
            Question q{};
            q.word_ = word_ + pair * word(rows_per_pair, rows_per_pair, 1, 0);
            return q;
        }
        std::uint32_t first() const { return word_ & 0xff; }
        std::uint32_t second() const { return word_ >> 8 & 0xff; }
        std::uint32_t pair() const { return word_ >> 16 & 0xff; }
        std::uint32_t bit() const { return word_ >> 24; }

    private:
        static constexpr std::uint32_t word(std::uint32_t first, std::uint32_t second,
                                            std::uint32_t pair, std::uint32_t bit) {
            return first | second << 8 | pair << 16 | bit << 24;
        }
        std::uint32_t word_;
    };
    static_assert(rows_per_pair * most <= 256);

    struct AllQuestions {
        Question of_bit[FeatureBits::count + 1];

        constexpr AllQuestions() : of_bit{} {
            for (std::uint32_t bit = 0; bit <= FeatureBits::count; ++bit)
                of_bit[bit] = Question(bit);
        }
    };

    /// Puts a question for each bit at the end of a list. As many as there usually are at most are
    /// written, however many there are: there is no branch to predict.
    template <std::uint32_t usual>
    void list(std::uint32_t bits, Question* questions, std::uint32_t& end) const {
        static constexpr AllQuestions all;
        constexpr std::uint32_t none = 1u << FeatureBits::count;
        for (std::uint32_t k = 0; k < usual; ++k, bits &= bits - 1) {
            questions[end] = all.of_bit[lowest_bit(bits | none)].of_pair(count_);
            end += bits != 0;
        }
        for (; bits != 0; bits &= bits - 1)
            questions[end++] = all.of_bit[lowest_bit(bits)].of_pair(count_);
    }

    template <class Ask>
    static void each_four(Question* questions, std::uint32_t count, std::uint32_t* answers,
                          const Ask& ask) {
        if (count == 0) return;
        // The last four may be fewer: the last one then stands in all lanes left.
        for (std::uint32_t k = 0; k < Four::count - 1; ++k)
            questions[count + k] = questions[count - 1];
        for (std::uint32_t i = 0; i < count; i += Four::count)
            for (std::uint32_t left = ask(questions + i); left != 0; left &= left - 1) {
                const Question& q = questions[i + lowest_bit(left)];
                answers[q.pair()] |= 1u << q.bit();
            }
    }

    /// The rows that are `k` after the questions' first ones, and after their second ones.
    FourVec3 firsts(const Question* asked, std::uint32_t k) const {
        Four unused = 0;
        return FourVec3::gathered(&rows_[asked[0].first() + k], &rows_[asked[1].first() + k],
                                  &rows_[asked[2].first() + k], &rows_[asked[3].first() + k],
                                  unused);
    }
    FourVec3 seconds(const Question* asked, std::uint32_t k) const {
        Four unused = 0;
        return FourVec3::gathered(&rows_[asked[0].second() + k], &rows_[asked[1].second() + k],
                                  &rows_[asked[2].second() + k], &rows_[asked[3].second() + k],
                                  unused);
    }
    Four gather(const Question* asked, float Sizes::*number) const {
        return Four::FourLanes{sizes_[asked[0].pair()].*number, sizes_[asked[1].pair()].*number,
                               sizes_[asked[2].pair()].*number, sizes_[asked[3].pair()].*number};
    }
    Vec3f at(std::uint32_t row) const { return {rows_[row][0], rows_[row][1], rows_[row][2]}; }

    /// Which of four features are possible, after one more test of those that are hidden, each
    /// alone.
    template <class Test>
    static std::uint32_t without_far(const FourNearby& nearby, const Test& is_far) {
        std::uint32_t possible = nearby.possible;
        for (std::uint32_t left = nearby.hidden; left != 0; left &= left - 1)
            if (is_far(lowest_bit(left))) possible &= ~(1u << lowest_bit(left));
        return possible;
    }

    std::uint32_t ask_vertices(const Question* asked) const {
        const FourVec3 face[3] = {seconds(asked, 0), seconds(asked, 1), seconds(asked, 2)};
        const FourNearby nearby = may_hold(face, firsts(asked, 0), gather(asked, &Sizes::margin),
                                           gather(asked, &Sizes::size));
        return without_far(nearby, [&](std::uint32_t lane) {
            const Question& q = asked[lane];
            const Sizes& s = sizes_[q.pair()];
            const Vec3f point[1] = {at(q.first())},
                        corners[3] = {at(q.second()), at(q.second() + 1), at(q.second() + 2)};
            return is_past(point[0] - corners[0], point, corners, s.margin, s.size);
        });
    }

    std::uint32_t ask_edges(const Question* asked) const {
        const FourNearby nearby = may_cross_over(
            firsts(asked, 0), firsts(asked, 1), seconds(asked, 0), seconds(asked, 1),
            gather(asked, &Sizes::thickness), gather(asked, &Sizes::size));
        return without_far(nearby, [&](std::uint32_t lane) {
            const Question& q = asked[lane];
            const Sizes& s = sizes_[q.pair()];
            return are_far_beside(at(q.first()), at(q.first() + 1), at(q.second()),
                                  at(q.second() + 1), s.thickness, s.size);
        });
    }

    Four rows_[rows_per_pair * most];
    Sizes sizes_[most];
    Question vertices_[6 * most + Four::count], edges_[9 * most + Four::count];
    std::uint32_t count_ = 0, vertex_count_ = 0, edge_count_ = 0;
};

}  // namespace pierce::stages

#endif
