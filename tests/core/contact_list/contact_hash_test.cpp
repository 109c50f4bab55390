// Which fields of a contact its hash sees.
#include "pierce/contact_hash.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace pierce {
namespace {

using Change = std::function<void(Contact&)>;

std::uint64_t hash_after(const Change& change) {
    Contact contact;
    change(contact);
    return contact_hash({&contact, 1});
}

TEST(ContactHashTest, SeesEveryFieldButAgeAndHowItWasFound) {
    const std::uint64_t before = hash_after([](Contact&) {});
    const std::vector<Change> seen = {
        [](Contact& c) { c.a.index = 1; },         [](Contact& c) { c.a.generation = 1; },
        [](Contact& c) { c.b.index = 1; },         [](Contact& c) { c.b.generation = 1; },
        [](Contact& c) { c.source = Side::b; },    [](Contact& c) { c.grazing = true; },
        [](Contact& c) { c.reprojected = true; },  [](Contact& c) { c.of_sheet = true; },
        [](Contact& c) { c.unknown_side = true; }, [](Contact& c) { c.vertex = 1; },
        [](Contact& c) { c.edge_end = 1; },        [](Contact& c) { c.edge = 1; },
        [](Contact& c) { c.chord = 1; },           [](Contact& c) { c.other_edge = 1; },
        [](Contact& c) { c.triangle = 1; },        [](Contact& c) { c.along = 0.5; },
        [](Contact& c) { c.time = 0.5; },          [](Contact& c) { c.distance = -1; },
        [](Contact& c) { c.barycentric[0] = 1; },  [](Contact& c) { c.barycentric[1] = 1; },
        [](Contact& c) { c.barycentric[2] = 1; },  [](Contact& c) { c.point_a.x = 1; },
        [](Contact& c) { c.point_b.y = 1; },       [](Contact& c) { c.normal.z = 1; },
        [](Contact& c) { c.face_normal.x = 1; },
    };
    std::vector<std::uint64_t> hashes = {before};
    for (const Change& change : seen) hashes.push_back(hash_after(change));
    std::ranges::sort(hashes);
    EXPECT_EQ(std::ranges::adjacent_find(hashes), hashes.end());

    EXPECT_EQ(hash_after([](Contact& c) { c.age = 1; }), before);
    EXPECT_EQ(hash_after([](Contact& c) { c.found = Found::walk; }), before);
    EXPECT_EQ(hash_after([](Contact& c) { c.distance = -0.0; }), before) << "zeros are equal";
}

}  // namespace
}  // namespace pierce
