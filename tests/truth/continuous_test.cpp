// Meetings of moving features against rational arithmetic, and against the published queries with
// known answers.
#include "core/geometry/continuous.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "support/meeting_queries.hpp"
#include "support/random.hpp"

namespace pierce::test {
namespace {

using testing::HasSubstr;
using truth::exact;
using truth::ExactTime;
using truth::first_meeting_of_edges;
using truth::first_meeting_of_vertex_and_face;
using FourPoints = std::array<MovingPoint, 4>;

enum class Kind { vertex_and_face, edges };

bool meet(Kind kind, const FourPoints& c, Impact& impact) {
    return kind == Kind::edges ? edges_meet(c[0], c[1], c[2], c[3], impact)
                               : vertex_meets_face(c[0], c[1], c[2], c[3], impact);
}

std::optional<ExactTime> first_meeting(Kind kind, const ExactCorners& c) {
    return kind == Kind::edges ? first_meeting_of_edges(c) : first_meeting_of_vertex_and_face(c);
}

/// The largest coordinate of the other corners relative to the first.
double size_of(const FourPoints& c) {
    double size = 0;
    for (const MovingPoint& p : c)
        for (int axis = 0; axis < 3; ++axis)
            size = std::max({size, std::abs(p.start[axis] - c[0].start[axis]),
                             std::abs(p.end[axis] - c[0].end[axis])});
    return size;
}

/// Distance of the features at the reported time and place, without rounding before the root.
double distance_at(Kind kind, const ExactCorners& c, const Impact& impact) {
    const mpq_class t = impact.time, u = impact.u, v = impact.v;
    const std::array<mpq_class, 4> weight = kind == Kind::edges
                                                ? std::array<mpq_class, 4>{1 - u, u, v - 1, -v}
                                                : std::array<mpq_class, 4>{1, u + v - 1, -u, -v};
    mpq_class squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        mpq_class sum = 0;
        for (std::size_t k = 0; k < 4; ++k)
            sum += weight[k] * (c[k].start[axis] + t * (c[k].end[axis] - c[k].start[axis]));
        squared += sum * sum;
    }
    return std::sqrt(squared.get_d());
}

struct Tally {
    int queries = 0, meetings = 0, missed = 0, late = 0, far = 0, gave_up = 0, spurious = 0;
};

/// Compares one answer with the truth.
void check(Kind kind, const FourPoints& corners, Tally& tally) {
    const ExactCorners c = exact(corners);
    const std::optional<ExactTime> truth = first_meeting(kind, c);
    Impact impact;
    const bool found = meet(kind, corners, impact);
    ++tally.queries;
    tally.meetings += truth.has_value();
    tally.missed += truth && !found;
    if (!found) return;
    tally.late += truth && mpq_class(impact.time) > truth->upper;
    tally.spurious += !truth;
    const double bound = (1 + 1e-6) * constants::meeting_tolerance * size_of(corners);
    if (impact.gap > bound) {
        ++tally.gave_up;
        return;
    }
    const bool within = impact.u >= 0 && impact.v >= 0 &&
                        (kind == Kind::edges ? std::max(impact.u, impact.v)
                                             : impact.u + impact.v) <= 1 + 1e-15;
    tally.far += !within || !(distance_at(kind, c, impact) <= bound);
}

FourPoints random_corners(Random& random, double half) {
    FourPoints c;
    for (MovingPoint& p : c) p = {random.in_box(half), random.in_box(half)};
    return c;
}

Vec3d on_grid(Random& random, int half) {
    return {1.0 * random.integer(-half, half), 1.0 * random.integer(-half, half),
            1.0 * random.integer(-half, half)};
}

/// A convex combination of corners.
Vec3d place_in(Random& random, Vec3d a, Vec3d b, Vec3d c, bool at_border) {
    double u = random.uniform(0, 1), v = random.uniform(0, 1 - u);
    if (at_border) {
        u = 0.25 * random.integer(0, 4);
        v = random.integer(0, 1) ? 0.0 : 1 - u;
    }
    return (1 - u - v) * a + u * b + v * c;
}

/// Makes the first corner pass through the face of the others, or the first edge through the
/// second, at a time.
void aim(Random& random, Kind kind, FourPoints& c, double t, bool at_border) {
    const auto at = [&](std::size_t k) { return (1 - t) * c[k].start + t * c[k].end; };
    const Vec3d target = kind == Kind::edges ? place_in(random, at(2), at(3), at(3), at_border)
                                             : place_in(random, at(1), at(2), at(3), at_border);
    Vec3d by = target - at(0);
    if (kind == Kind::edges) {
        const double place = at_border ? random.integer(0, 1) : random.uniform(0, 1);
        by = target - ((1 - place) * at(0) + place * at(1));
        c[1] = {c[1].start + by, c[1].end + by};
    }
    c[0] = {c[0].start + by, c[0].end + by};
}

using Maker = FourPoints (*)(Random&, Kind);

struct Family {
    const char* name;
    Maker make;
    bool mostly_meets;  ///< at least a tenth does, exactly
};

const Family families[] = {
    {"generic", [](Random& r, Kind) { return random_corners(r, 1); }, false},
    {"on a small grid",
     [](Random& r, Kind) {
         FourPoints c;
         for (MovingPoint& p : c) p = {on_grid(r, 2), on_grid(r, 2)};
         return c;
     },
     true},
    {"in one plane",
     [](Random& r, Kind) {
         FourPoints c;
         const bool tilted = r.integer(0, 1) != 0;
         for (MovingPoint& p : c) {
             p = {on_grid(r, 4), on_grid(r, 4)};
             p.start.z = tilted ? p.start.x + 2 * p.start.y : 1.0;
             p.end.z = tilted ? p.end.x + 2 * p.end.y : -1.0;
         }
         return c;
     },
     true},
    {"nearly in one plane",
     [](Random& r, Kind) {
         FourPoints c = random_corners(r, 1);
         const double height = std::ldexp(1.0, -r.integer(5, 60));
         for (MovingPoint& p : c) p.start.z *= height, p.end.z *= height;
         return c;
     },
     false},
    {"aimed",
     [](Random& r, Kind kind) {
         FourPoints c = random_corners(r, 1);
         aim(r, kind, c, r.uniform(0, 1), false);
         return c;
     },
     true},
    {"aimed at the border",
     [](Random& r, Kind kind) {
         FourPoints c = random_corners(r, 1);
         aim(r, kind, c, r.uniform(0, 1), true);
         return c;
     },
     false},
    {"touching at the start or the end",
     [](Random& r, Kind kind) {
         FourPoints c;
         for (MovingPoint& p : c) p = {0.25 * on_grid(r, 8), 0.25 * on_grid(r, 8)};
         aim(r, kind, c, r.integer(0, 1), true);
         return c;
     },
     true},
    {"resting",
     [](Random& r, Kind kind) {
         FourPoints c;
         for (MovingPoint& p : c) p.start = p.end = 0.25 * on_grid(r, 8);
         if (r.integer(0, 1)) aim(r, kind, c, 0, true);
         for (MovingPoint& p : c) p.end = p.start;
         return c;
     },
     true},
    {"without area",
     [](Random& r, Kind kind) {
         FourPoints c;
         for (MovingPoint& p : c) p = {on_grid(r, 2), on_grid(r, 2)};
         switch (r.integer(0, 3)) {
             case 0:
                 c[3] = c[2];
                 break;
             case 1:
                 c[1] = c[2] = c[3];
                 break;
             case 2:
                 c[3].start = 2.0 * c[2].start - c[1].start, c[3].end = 2.0 * c[2].end - c[1].end;
                 break;
             default:
                 c[1] = c[0];
                 break;
         }
         if (r.integer(0, 1)) aim(r, kind, c, 0.5, true);
         return c;
     },
     true},
    {"turning while close",
     [](Random& r, Kind kind) {
         FourPoints c = random_corners(r, 1);
         aim(r, kind, c, 0, false);
         const FourPoints at_start = c;
         aim(r, kind, c, 1, false);
         for (std::size_t k = 0; k < 4; ++k) c[k].start = at_start[k].start;
         const Vec3d gap = std::ldexp(1.0, -r.integer(10, 40)) * r.unit_vector();
         c[0] = {c[0].start + gap, c[0].end + gap};
         return c;
     },
     false},
};

/// The same with other numbers: elsewhere, larger or smaller, all moving, in float32.
FourPoints varied(Random& random, FourPoints c) {
    const double scale = std::ldexp(1.0, random.integer(0, 1) ? 0 : random.integer(-20, 20));
    const Vec3d shift = random.integer(0, 2)
                            ? Vec3d{}
                            : scale * std::ldexp(1.0, random.integer(0, 22)) * on_grid(random, 1);
    const Vec3d motion = random.integer(0, 2)
                             ? Vec3d{}
                             : scale * std::ldexp(1.0, random.integer(0, 10)) * on_grid(random, 1);
    const bool in_float = random.integer(0, 1) != 0;
    for (MovingPoint& p : c) {
        p = {scale * p.start + shift, scale * p.end + shift + motion};
        if (in_float) p = {to_double(to_float(p.start)), to_double(to_float(p.end))};
    }
    return c;
}

class ContinuousTruthTest : public testing::TestWithParam<Kind> {};

TEST_P(ContinuousTruthTest, NoMeetingIsMissedAndNoneIsReportedFromAfar) {
    Random random(20);
    SCOPED_TRACE(testing::Message() << "seed " << random.seed());
    for (const Family& family : families) {
        SCOPED_TRACE(family.name);
        Tally tally;
        for (int round = 0; round < 300; ++round) {
            check(GetParam(), varied(random, family.make(random, GetParam())), tally);
            ASSERT_EQ(tally.missed, 0) << "round " << round;
            ASSERT_EQ(tally.late, 0) << "round " << round;
            ASSERT_EQ(tally.far, 0) << "round " << round;
        }
        RecordProperty(family.name, std::to_string(tally.meetings) + " meet, " +
                                        std::to_string(tally.spurious) + " nearly, " +
                                        std::to_string(tally.gave_up) + " given up");
        EXPECT_EQ(tally.gave_up, 0);
        if (family.mostly_meets) {
            EXPECT_GE(tally.meetings, tally.queries / 10);
        }
    }
}

/// What the answers to published queries were like.
struct Published {
    std::size_t queries = 0, meetings = 0, disputed = 0, rounded = 0, missed = 0, spurious = 0,
                gave_up = 0;
    double widest_gap = 0;  ///< of spurious meetings [size]
};

Published ask(Kind kind, const std::vector<MeetingQuery>& queries) {
    Published result;
    for (const MeetingQuery& query : queries) {
        const RoundedCorners as_double = rounded(query.corners);
        Impact impact;
        const bool found = meet(kind, as_double.corners, impact);
        ++result.queries;
        result.meetings += query.meets;
        result.rounded += !as_double.exact;
        result.disputed += first_meeting(kind, query.corners).has_value() != query.meets;
        result.missed += query.meets && !found;
        if (!query.meets && found) {
            ++result.spurious;
            result.widest_gap = std::max(result.widest_gap,
                                         impact.gap / size_of(as_double.corners));
        }
        result.gave_up += found && impact.gap > constants::meeting_tolerance *
                                                    size_of(as_double.corners) * 1.000001;
    }
    return result;
}

TEST_P(ContinuousTruthTest, QueriesOfOurOwnInThePublishedFormat) {
    const bool edges = GetParam() == Kind::edges;
    const auto files = meeting_query_files(PIERCE_TEST_DATA "/meeting_queries",
                                           edges ? "edge-edge" : "vertex-face");
    ASSERT_EQ(files.size(), 1u);
    const Published result = ask(GetParam(), read_meeting_queries(files[0]));
    EXPECT_EQ(result.queries, edges ? 5u : 6u);
    EXPECT_EQ(result.meetings, 3u);
    EXPECT_EQ(result.disputed, 0u);
    EXPECT_EQ(result.missed, 0u);
    EXPECT_EQ(result.spurious, 0u);
    EXPECT_EQ(result.gave_up, 0u);
}

TEST_P(ContinuousTruthTest, PublishedQueries) {
    const char* folder = std::getenv("PIERCE_CCD_QUERIES");
    if (!folder)
        GTEST_SKIP() << "PIERCE_CCD_QUERIES names no folder with the queries of Wang et al. (2021)";
    const std::string name = GetParam() == Kind::edges ? "edge-edge" : "vertex-face";
    const auto files = meeting_query_files(folder, name);
    ASSERT_FALSE(files.empty()) << "no " << name << "/*.csv below " << folder;
    for (const auto& file : files) {
        const Published result = ask(GetParam(), read_meeting_queries(file));
        std::printf(
            "%s: %zu queries, %zu meet; missed %zu, spurious %zu (gaps up to %.1e of the size), "
            "given up %zu; %zu not in "
            "double; exact truth disputes %zu\n",
            file.parent_path().parent_path().filename().c_str(), result.queries, result.meetings,
            result.missed, result.spurious, result.widest_gap, result.gave_up, result.rounded,
            result.disputed);
        EXPECT_EQ(result.missed, 0u) << file;
        EXPECT_EQ(result.disputed, 0u) << file;
        EXPECT_EQ(result.gave_up, 0u) << file;
    }
}

/// The message of the error that a file with these lines gives.
std::string error_of(const std::string& lines) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) /
                                       "pierce_meeting_queries.csv";
    std::ofstream(file) << lines;
    try {
        read_meeting_queries(file);
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    return {};
}

TEST(MeetingQueriesTest, BadFilesAreRefused) {
    const std::string line = "1,2,3,4,5,6,1\n";
    std::string query;
    for (int k = 0; k < 8; ++k) query += line;
    EXPECT_EQ(error_of(query), "");
    EXPECT_THAT(error_of(query + line), HasSubstr("less than eight lines"));
    EXPECT_THAT(error_of(query + "1,2,3,4,5,6\n"), HasSubstr(":9: not seven"));
    EXPECT_THAT(error_of(query + "1,2,3,4,5,x,1\n"), HasSubstr(":9: not seven"));
    EXPECT_THAT(error_of(line + "1,2,3,4,5,6,0\n"), HasSubstr(":2: another answer"));
    EXPECT_THAT(error_of("1,2,3,0,5,6,1\n"), HasSubstr("denominator is zero"));
    EXPECT_THROW(read_meeting_queries("/does/not/exist.csv"), std::runtime_error);
}

/// A vertex, or an edge, that moves along the axis a face, or an edge, turns about, and stays `gap`
/// away from it.
FourPoints hovering(Random& random, Kind kind, double gap) {
    const auto turning = [&](double x, double y) { return MovingPoint{{x, y, 0}, {x, 0, y}}; };
    const double from = random.uniform(-1, 1), to = random.uniform(-1, 1),
                 reach = random.uniform(0.5, 1);
    const auto ahead = [&](double by) {
        return MovingPoint{{from + by, -gap, gap}, {to + by, -gap, gap}};
    };
    if (kind == Kind::edges) {
        const double x = random.uniform(-1, 1), y = random.uniform(-1, 1);
        return {ahead(0), ahead(reach), turning(x, -1), turning(y, 1)};
    }
    return {ahead(0), turning(random.uniform(-3, -1), random.uniform(-2, 2)),
            turning(random.uniform(1, 3), random.uniform(-2, 2)),
            turning(random.uniform(-1, 1), random.uniform(-2, 2))};
}

TEST_P(ContinuousTruthTest, ASearchThatGivesUpSaysSo) {
    Random random(21);
    SCOPED_TRACE(testing::Message() << "seed " << random.seed());
    Tally wide, narrow;
    for (int round = 0; round < 300; ++round) {
        check(
            GetParam(),
            hovering(random, GetParam(), std::ldexp(random.uniform(1, 2), -random.integer(2, 16))),
            wide);
        check(GetParam(), hovering(random, GetParam(), std::ldexp(random.uniform(1, 2), -22)),
              narrow);
    }
    for (const Tally& tally : {wide, narrow}) {
        EXPECT_EQ(tally.missed, 0);
        EXPECT_EQ(tally.late, 0);
        EXPECT_EQ(tally.far, 0);
    }
    EXPECT_EQ(wide.gave_up, 0);
    EXPECT_EQ(wide.spurious, 0);
    EXPECT_EQ(narrow.spurious, narrow.gave_up);
    if (GetParam() == Kind::vertex_and_face) {
        EXPECT_GT(narrow.gave_up, 0);
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ContinuousTruthTest,
                         testing::Values(Kind::vertex_and_face, Kind::edges), [](const auto& kind) {
                             return kind.param == Kind::edges ? "edges" : "vertex_and_face";
                         });

}  // namespace
}  // namespace pierce::test
