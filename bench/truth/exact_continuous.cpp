#include "truth/exact_continuous.hpp"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace pierce::truth {
namespace {

/// A polynomial of time; coefficients from the constant up, the last one not zero.
class Polynomial {
public:
    Polynomial() = default;
    explicit Polynomial(std::vector<mpq_class> coefficients) : c_(std::move(coefficients)) {
        while (!c_.empty() && c_.back() == 0) c_.pop_back();
    }

    bool is_zero() const { return c_.empty(); }
    int degree() const { return static_cast<int>(c_.size()) - 1; }

    mpq_class at(const mpq_class& t) const {
        mpq_class value = 0;
        for (auto c = c_.rbegin(); c != c_.rend(); ++c) value = value * t + *c;
        return value;
    }

    Polynomial derivative() const {
        std::vector<mpq_class> d;
        for (std::size_t k = 1; k < c_.size(); ++k) d.push_back(c_[k] * static_cast<int>(k));
        return Polynomial(d);
    }

    friend Polynomial operator+(const Polynomial& a, const Polynomial& b) {
        std::vector<mpq_class> sum(std::max(a.c_.size(), b.c_.size()));
        for (std::size_t k = 0; k < a.c_.size(); ++k) sum[k] += a.c_[k];
        for (std::size_t k = 0; k < b.c_.size(); ++k) sum[k] += b.c_[k];
        return Polynomial(sum);
    }
    friend Polynomial operator-(const Polynomial& a, const Polynomial& b) {
        return a + Polynomial({-1}) * b;
    }
    friend Polynomial operator*(const Polynomial& a, const Polynomial& b) {
        if (a.is_zero() || b.is_zero()) return {};
        std::vector<mpq_class> product(a.c_.size() + b.c_.size() - 1);
        for (std::size_t i = 0; i < a.c_.size(); ++i)
            for (std::size_t j = 0; j < b.c_.size(); ++j) product[i + j] += a.c_[i] * b.c_[j];
        return Polynomial(product);
    }

    /// Quotient and remainder; `b` is not zero.
    friend std::pair<Polynomial, Polynomial> divided(const Polynomial& a, const Polynomial& b) {
        std::vector<mpq_class> rest = a.c_, quotient;
        while (rest.size() >= b.c_.size()) {
            const mpq_class factor = rest.back() / b.c_.back();
            const std::size_t shift = rest.size() - b.c_.size();
            for (std::size_t k = 0; k < b.c_.size(); ++k) rest[shift + k] -= factor * b.c_[k];
            rest.pop_back();
            quotient.insert(quotient.begin(), factor);
        }
        return {Polynomial(quotient), Polynomial(rest)};
    }

private:
    std::vector<mpq_class> c_;
};

Polynomial common_divisor(Polynomial a, Polynomial b) {
    while (!b.is_zero()) a = std::exchange(b, divided(a, b).second);
    return a;
}

/// Counts the roots of a polynomial that is not zero (Sturm 1829).
class RootCounter {
public:
    explicit RootCounter(const Polynomial& p) {
        const Polynomial simple = divided(p, common_divisor(p, p.derivative())).first;
        chain_ = {simple, simple.derivative()};
        while (!chain_.back().is_zero())
            chain_.push_back(Polynomial() -
                             divided(chain_[chain_.size() - 2], chain_.back()).second);
    }

    /// Different roots in (low, high].
    int count(const mpq_class& low, const mpq_class& high) const {
        return changes(low) - changes(high);
    }

private:
    int changes(const mpq_class& t) const {
        int changes = 0, last = 0;
        for (const Polynomial& p : chain_) {
            const int s = sgn(p.at(t));
            if (s == 0) continue;
            changes += last != 0 && s != last;
            last = s;
        }
        return changes;
    }

    std::vector<Polynomial> chain_;
};

/// A real number: the only root of a polynomial in (lower, upper].
struct Root {
    Polynomial polynomial;
    RootCounter counter;
    mpq_class lower, upper;

    void refine() {
        const mpq_class middle = (lower + upper) / 2;
        (counter.count(lower, middle) == 1 ? upper : lower) = middle;
    }

    /// The sign of another polynomial there.
    int sign_of(const Polynomial& p) {
        if (p.is_zero()) return 0;
        const Polynomial shared = common_divisor(polynomial, p);
        if (shared.degree() > 0 && RootCounter(shared).count(lower, upper) == 1) return 0;
        const RootCounter roots(p);
        while (roots.count(lower, upper) > 0) refine();
        return sgn(p.at(upper));
    }
};

/// The roots in [0, 1] of a polynomial that is not zero.
std::vector<Root> roots_of(const Polynomial& p) {
    const RootCounter counter(p);
    std::vector<Root> roots;
    const std::function<void(const mpq_class&, const mpq_class&)> isolate =
        [&](const mpq_class& low, const mpq_class& high) {
            const int count = counter.count(low, high);
            if (count == 1) roots.push_back({p, counter, low, high});
            if (count < 2) return;
            const mpq_class middle = (low + high) / 2;
            isolate(low, middle);
            isolate(middle, high);
        };
    isolate(-1, 1);
    std::erase_if(roots, [](Root& root) { return root.sign_of(Polynomial({0, 1})) < 0; });
    return roots;
}

using Vector = std::array<Polynomial, 3>;

Vector operator-(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Polynomial dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector path(const ExactMovingPoint& p) {
    Vector v;
    for (std::size_t k = 0; k < 3; ++k) v[k] = Polynomial({p.start[k], p.end[k] - p.start[k]});
    return v;
}

/// Conditions on the signs of polynomials: some are zero, some not negative.
struct Conditions {
    std::vector<Polynomial> zero, not_negative;

    bool hold(Root& time) const {
        for (const Polynomial& p : zero)
            if (time.sign_of(p) != 0) return false;
        for (const Polynomial& p : not_negative)
            if (time.sign_of(p) < 0) return false;
        return true;
    }
};

/// What says whether two features meet at a time at which all lies in one plane.
struct Question {
    Polynomial coplanar;             ///< zero at such times
    Vector normal;                   ///< of the face, or of both edges
    Conditions regular;              ///< they meet, where there is a normal
    std::vector<Conditions> flat{};  ///< any: they meet, where there is none
};

Conditions on_segment(const Vector& p, const Vector& a, const Vector& b) {
    const Vector n = cross(p - a, p - b);
    return {{n[0], n[1], n[2]}, {dot(p - a, b - p)}};
}

/// The first time at which the answer is yes. The times at which it is are a closed set; it ends
/// where the sign of one of the polynomials changes, so the first of them is 0 or a root of one of
/// those.
std::optional<ExactTime> first_time(const Question& question) {
    std::vector<Root> candidates = roots_of(Polynomial({0, 1}));
    const auto add = [&](const Polynomial& p) {
        if (p.is_zero()) return;
        for (Root& root : roots_of(p)) candidates.push_back(root);
    };
    if (question.coplanar.is_zero()) {
        for (const Polynomial& p : question.normal) add(p);
        for (const Polynomial& p : question.regular.not_negative) add(p);
        for (const Conditions& c : question.flat) {
            for (const Polynomial& p : c.zero) add(p);
            for (const Polynomial& p : c.not_negative) add(p);
        }
    } else {
        add(question.coplanar);
    }
    const Conditions no_normal{{question.normal[0], question.normal[1], question.normal[2]}, {}};
    std::optional<ExactTime> first;
    for (Root& time : candidates) {
        if (time.sign_of(question.coplanar) != 0) continue;
        const bool meets = no_normal.hold(time)
                               ? std::any_of(question.flat.begin(), question.flat.end(),
                                             [&](const Conditions& c) { return c.hold(time); })
                               : question.regular.hold(time);
        if (!meets) continue;
        while (time.upper - time.lower > mpq_class(1) / (mpz_class(1) << 64)) time.refine();
        if (!first || time.upper < first->upper) first = {time.lower, time.upper};
    }
    return first;
}

}  // namespace

ExactCorners exact(const std::array<MovingPoint, 4>& corners) {
    ExactCorners result;
    for (std::size_t k = 0; k < 4; ++k)
        for (int axis = 0; axis < 3; ++axis) {
            result[k].start[static_cast<std::size_t>(axis)] = corners[k].start[axis];
            result[k].end[static_cast<std::size_t>(axis)] = corners[k].end[axis];
        }
    return result;
}

std::optional<ExactTime> first_meeting_of_vertex_and_face(const ExactCorners& corners) {
    const Vector p = path(corners[0]), a = path(corners[1]), b = path(corners[2]),
                 c = path(corners[3]);
    Question question;
    question.normal = cross(b - a, c - a);
    question.coplanar = dot(question.normal, p - a);
    question.regular.not_negative = {dot(question.normal, cross(b - a, p - a)),
                                     dot(question.normal, cross(c - b, p - b)),
                                     dot(question.normal, cross(a - c, p - c))};
    question.flat = {on_segment(p, a, b), on_segment(p, b, c), on_segment(p, c, a)};
    return first_time(question);
}

std::optional<ExactTime> first_meeting_of_edges(const ExactCorners& corners) {
    const Vector a0 = path(corners[0]), a1 = path(corners[1]), b0 = path(corners[2]),
                 b1 = path(corners[3]);
    const Vector a = a1 - a0, b = b1 - b0, between = b0 - a0;
    Question question;
    question.normal = cross(a, b);
    question.coplanar = dot(question.normal, between);
    const Polynomial size = dot(question.normal, question.normal);
    const Polynomial first = dot(question.normal, cross(between, b)),
                     second = dot(question.normal, cross(between, a));
    question.regular.not_negative = {first, size - first, second, size - second};
    question.flat = {on_segment(a0, b0, b1), on_segment(a1, b0, b1), on_segment(b0, a0, a1),
                     on_segment(b1, a0, a1)};
    return first_time(question);
}

}  // namespace pierce::truth
