// Structs of other versions, and what becomes of exceptions.
#include "c_api/versioned.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "c_api/border.hpp"
#include "pierce/pierce.h"

namespace pierce::c {

/// A struct in three versions.
struct First {
    std::size_t struct_size;
    std::uint64_t a;
};
struct Second {
    std::size_t struct_size;
    std::uint64_t a, b;
};
struct Third {
    std::size_t struct_size;
    std::uint64_t a, b, c;
};

template <>
inline constexpr std::size_t first_size<Second> = sizeof(First);

namespace {

constexpr Second defaults{sizeof(Second), 10, 20};

/// A library that knows the second version reads what a program of another version gives it.
template <class Given>
Second read_of(const Given& given) {
    return read_struct(reinterpret_cast<const Second*>(&given), defaults, "thing");
}

TEST(VersionedTest, AnEarlierStructHasDefaultsInNewFields) {
    const Second read = read_of(First{sizeof(First), 1});
    EXPECT_EQ(read.a, 1u);
    EXPECT_EQ(read.b, 20u);
    EXPECT_EQ(read.struct_size, sizeof(Second));
}

TEST(VersionedTest, ALaterStructIsTakenIfItsNewFieldsAreZero) {
    EXPECT_EQ(read_of(Third{sizeof(Third), 1, 2, 0}).b, 2u);
    EXPECT_THROW(read_of(Third{sizeof(Third), 1, 2, 3}), InputError);
}

TEST(VersionedTest, ImpossibleSizesAreRefused) {
    for (const std::size_t size :
         {std::size_t{0}, sizeof(First) - 1, most_bytes + 1, ~std::size_t{0}})
        EXPECT_THROW(read_of(Second{size, 1, 2}), InputError) << size;
    EXPECT_THROW(read_struct<Second>(nullptr, defaults, "thing"), InputError);
}

TEST(VersionedTest, WritingStaysWithinTheCallersStruct) {
    Third out{sizeof(First), 7, 8, 9};
    write_struct(defaults, reinterpret_cast<Second*>(&out));
    EXPECT_EQ(out.struct_size, sizeof(First));
    EXPECT_EQ(out.a, 10u);
    EXPECT_EQ(out.b, 8u);
    out.struct_size = sizeof(Third);
    write_struct(defaults, reinterpret_cast<Second*>(&out));
    EXPECT_EQ(out.struct_size, sizeof(Third));
    EXPECT_EQ(out.b, 20u);
    EXPECT_EQ(out.c, 0u);
}

// border.cpp is in the library, and not to be seen from here: what is tested is which status an
// exception becomes.
pierce_status last_status = PIERCE_OK;

}  // namespace

pierce_status failed(pierce_status status, const char*) noexcept { return last_status = status; }

namespace {

template <class Thrown>
pierce_status status_of(Thrown thrown) {
    return guarded([&] { throw thrown; });
}

TEST(BorderTest, EveryExceptionIsAStatus) {
    EXPECT_EQ(status_of(InputError("x")), PIERCE_INVALID_INPUT);
    EXPECT_EQ(status_of(NotBuilt("x")), PIERCE_NOT_BUILT);
    EXPECT_EQ(status_of(std::bad_alloc()), PIERCE_OUT_OF_MEMORY);
    EXPECT_EQ(status_of(std::runtime_error("x")), PIERCE_INTERNAL);
    EXPECT_EQ(status_of(std::invalid_argument("x")), PIERCE_INTERNAL);
    EXPECT_EQ(status_of(7), PIERCE_INTERNAL);
    EXPECT_EQ(last_status, PIERCE_INTERNAL);
    EXPECT_EQ(guarded([] {}), PIERCE_OK);
}

TEST(BorderTest, MessagesAreOfTheirThread) {
    ASSERT_EQ(pierce_detect(nullptr), PIERCE_INVALID_INPUT);
    const std::string here = pierce_last_error();
    std::string there = "none";
    std::thread([&] { there = pierce_last_error(); }).join();
    EXPECT_EQ(here, "world is null");
    EXPECT_EQ(there, "");
}

TEST(BorderTest, LongMessagesAreCut) {
    pierce_world* world = nullptr;
    ASSERT_EQ(pierce_create_world(nullptr, nullptr, &world), PIERCE_OK);
    const std::string name(5000, 'n');
    const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::uint32_t corners[3] = {0, 1, 3};
    pierce_mesh_id mesh = 0;
    EXPECT_EQ(pierce_add_mesh(world, name.c_str(), points, 3, corners, 1, nullptr, &mesh),
              PIERCE_INVALID_INPUT);
    EXPECT_EQ(std::string(pierce_last_error()).size(), 1023u);
    pierce_destroy_world(world);
}

}  // namespace
}  // namespace pierce::c
