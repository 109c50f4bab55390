// Lists that stages emit: on any number of threads what one thread finds, in the order of the
// items. Sums, likewise.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "core/device/view.hpp"
#include "core/execute/host_executor.hpp"
#include "core/execute/serial_executor.hpp"
#include "cpu_embree/tbb_executor.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

/// Of each item as many things as `counts` says, each the item and a number of its own.
struct Things {
    View<const std::uint32_t> counts;

    std::uint32_t find(std::uint32_t i) const { return counts[i]; }
    static std::uint32_t count(std::uint32_t found) { return found; }
    void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
               std::uint64_t* list) const {
        for (std::uint32_t k = 0; k < found; ++k) list[place + k] = std::uint64_t{i} << 32 | k;
    }
    void write(std::uint32_t i, std::uint32_t found, std::uint32_t place, std::uint64_t* list,
               std::uint32_t* items) const {
        write(i, found, place, list);
        for (std::uint32_t k = 0; k < found; ++k) items[place + k] = i;
    }
};

/// Each item finds a third of what a list may have.
struct TooMany {
    static std::uint32_t find(std::uint32_t i) { return i; }
    static std::uint32_t count(std::uint32_t) { return 0x55555556u; }
    static void write(std::uint32_t, std::uint32_t, std::uint32_t) {}
};

TEST(EmitTest, ListsThatAreTooLongAreRefused) {
    SerialExecutor serial;
    EXPECT_NO_THROW(serial.emit(ListId::pairs, 2, TooMany{}));
    EXPECT_THROW(serial.emit(ListId::pairs, 3, TooMany{}), std::length_error);
    TbbExecutor executor(2);
    for (const std::uint32_t n : {3u, 100u, 20000u})
        EXPECT_THROW(executor.run([&] { executor.emit(ListId::pairs, n, TooMany{}); }),
                     std::length_error);
    const std::vector<std::uint32_t> counts{0x80000000u, 0x7fffffffu, 1u};
    std::vector<std::uint32_t> places(counts.size());
    EXPECT_EQ(serial.exclusive_scan(ListId::pairs, 2, view_of(counts), view_of(places)), ~0u);
    EXPECT_THROW(serial.exclusive_scan(ListId::pairs, 3, view_of(counts), view_of(places)),
                 std::length_error);
}

TEST(EmitTest, ThingsComeInTheOrderOfTheirItems) {
    test::Random random(1);
    for (const int threads : {1, 2, 5}) {
        TbbExecutor executor(threads);
        SerialExecutor serial;
        HostBuffer<std::uint64_t> list, of_one_thread;
        HostBuffer<std::uint32_t> items;
        for (const std::uint32_t n : {0u, 1u, 31u, 32u, 33u, 64u, 1000u, 20000u}) {
            std::vector<std::uint32_t> counts(n);
            std::vector<std::uint64_t> expected;
            for (std::uint32_t i = 0; i < n; ++i) {
                counts[i] = random.integer(0, 2) == 0
                                ? static_cast<std::uint32_t>(random.integer(0, 40))
                                : 0;
                for (std::uint32_t k = 0; k < counts[i]; ++k)
                    expected.push_back(std::uint64_t{i} << 32 | k);
            }
            const Things things{view_of(std::as_const(counts))};
            executor.run([&] { executor.emit(ListId::pairs, n, things, list); });
            serial.emit(ListId::pairs, n, things, of_one_thread);
            ASSERT_EQ(std::vector(list.begin(), list.end()), expected)
                << "seed " << random.seed() << ", " << n << " items";
            ASSERT_EQ(std::vector(of_one_thread.begin(), of_one_thread.end()), expected);
            executor.run([&] { executor.emit(ListId::pairs, n, things, list, items); });
            ASSERT_EQ(std::vector(list.begin(), list.end()), expected);
            ASSERT_EQ(items.size(), expected.size());
            for (std::size_t k = 0; k < items.size(); ++k) ASSERT_EQ(items[k], expected[k] >> 32);
        }
    }
}

/// What a term says is not lost, nor asked twice.
struct NoteTerm {
    View<const double> terms;
    View<std::uint32_t> asked;

    double operator()(std::uint32_t i) const {
        ++asked[i];
        return terms[i];
    }
};

TEST(ReduceTest, SumsDoNotDependOnTheNumberOfThreads) {
    test::Random random(2);
    for (const std::uint32_t n : {0u, 1u, 15u, 16u, 17u, 1000u, 20001u}) {
        std::vector<double> terms(n);
        for (double& term : terms) term = random.uniform(-1, 1) * std::exp(random.uniform(0, 20));
        double of_one_thread = 0, in_order = 0;
        for (const int threads : {1, 2, 5}) {
            TbbExecutor executor(threads);
            std::vector<std::uint32_t> asked(n);
            double sum = -1;
            executor.run([&] {
                executor.reduce(n, NoteTerm{view_of(std::as_const(terms)), view_of(asked)}, sum);
            });
            if (threads == 1) of_one_thread = sum;
            ASSERT_EQ(sum, of_one_thread)
                << "seed " << random.seed() << ", " << n << " terms, " << threads << " threads";
            ASSERT_EQ(asked, std::vector<std::uint32_t>(n, 1));
        }
        for (const double term : terms) in_order += term;
        ASSERT_NEAR(of_one_thread, in_order, 1e-9 * n * std::exp(20)) << "seed " << random.seed();
    }
}

}  // namespace
}  // namespace pierce
