#include "scenes/named/hard_cases.hpp"

#include <cmath>
#include <numbers>

#include "scenes/named/hard_meshes.hpp"

namespace pierce::scenes {
namespace {

using namespace hard;
using std::numbers::sqrt2, std::numbers::sqrt3;

HardContacts by_vertices(int a, int b, double depth, Vec3d push = {}) {
    return {.vertices_a = a,
            .vertices_b = b,
            .edges_a = 0,
            .edges_b = 0,
            .separated = false,
            .depth = depth,
            .push = push};
}
HardContacts by_edges(int a, int b, double depth, Vec3d push = {}) {
    return {0, 0, a, b, false, depth, push};
}
HardContacts by_separation(double depth, Vec3d push) { return {0, 0, 0, 0, true, depth, push}; }

/// 1 to 12: single rays against a mesh.
void add_rays(std::vector<HardCase>& cases) {
    const Vec3d down{0, 0, -1}, up{0, 0, 1}, right{1, 0, 0}, in{-1, -1, -1}, center{0.5, 0.5, 0.25};
    cases.push_back({1,
                     "edge_diagonal_hit",
                     {{cube(), center, down, Meets::exit, 0.25}},
                     {},
                     {},
                     "one exit at 1/4",
                     ""});
    cases.push_back({2,
                     "vertex_fan_hit",
                     {{octahedron(), {0, 0, 0.25}, down, Meets::exit, 1.25}},
                     {},
                     {},
                     "one exit at 5/4",
                     ""});
    cases.push_back({3,
                     "resting_t0",
                     {{cube(), {0.3, 0.6, 1}, up, Meets::touching, 0}},
                     {{"", spike({0.3f, 0.6f, 1}, {0.3f, 0.6f, 2}, 0.25f), cube(), 0,
                       by_vertices(1, 0, 0), by_vertices(1, 0, 0), 0}},
                     {},
                     "touching, depth 0",
                     ""});
    cases.push_back({4,
                     "corner_kiss",
                     {{placed(cube(), 1, {1, 1, 1}), {1, 1, 1}, in, Meets::touching, 0}},
                     {{"", cube(), placed(cube(), 1, {1, 1, 1}), 0, by_vertices(1, 1, 0),
                       by_vertices(1, 1, 0), 0}},
                     {},
                     "touching, depth 0, once from either body",
                     ""});
    cases.push_back(
        {5,
         "identical_pose",
         {{cube(), {1, 1, 1}, in, Meets::exit, sqrt3}},
         {{"", cube(), cube(), 1, by_vertices(8, 8, sqrt3), by_vertices(8, 8, sqrt3), sqrt3}},
         {},
         "every corner inside, along a diagonal of sqrt 3; the bodies would part by 1",
         ""});
    cases.push_back({6,
                     "coplanar_slide",
                     {{cube(), {0.5, 0, 0.5}, right, Meets::touching, 0}},
                     {},
                     {},
                     "touching, depth 0",
                     ""});
    cases.push_back({7,
                     "ridge_graze",
                     {{prism({0, 0, 0}, {2, 0, 0}, {1, 0, 1}, {0, 1, 0}),
                       {-1, 0.5, 1},
                       right,
                       Meets::nothing,
                       0}},
                     {},
                     {},
                     "nothing: entry and exit at 2 cancel",
                     ""});
    cases.push_back(
        {8,
         "zero_area_filler",
         {{cube_with_filler(), {0.5, 0.25, 0.25}, down, Meets::exit, 0.25},
          {cube_with_filler(), {0.5, 0.25, 0.25}, {0, -1, -1}, Meets::exit, 0.25 * sqrt2}},
         {},
         {{cube_with_filler(), MeshDefect::degenerate_triangle, 1}},
         "exits at 1/4 and at sqrt 2 / 4, the edge point",
         ""});
    cases.push_back({9,
                     "needle_grazing",
                     {{{{{0, 0, 0}, {1, 0, 0}, {0.5f, 1e-6f, 0}}, {{{0, 1, 2}}}},
                       {0.5, 0.5, 0x1p-10},
                       {0, 1, -0x1p-20},
                       Meets::nothing,
                       0}},
                     {},
                     {},
                     "nothing",
                     ""});
    const double far = 0x1p20, tiny = 0x1p-40;
    cases.push_back({10,
                     "far_from_origin",
                     {{placed(cube(), 1, {0x1p20f, 0x1p20f, 0x1p20f}),
                       center + Vec3d{far, far, far}, down, Meets::exit, 0.25}},
                     {},
                     {},
                     "one exit at 1/4",
                     ""});
    const MeshData slab = box({-far, -far, -8}, {far, far, 0});
    cases.push_back({11,
                     "huge_face_small_depth",
                     {{slab, {1.0 / 3, 1.0 / 7, -4}, up, Meets::exit, 4},
                      {slab, {1.0 / 3, 1.0 / 7, -0x1p-10}, up, Meets::exit, 0x1p-10}},
                     {},
                     {},
                     "exits 4 and 2^-10 away",
                     ""});
    cases.push_back({12,
                     "micro_scale",
                     {{placed(cube(), 0x1p-40f, {}), tiny * center, down, Meets::exit, tiny / 4}},
                     {},
                     {},
                     "one exit at 2^-42",
                     ""});
}

/// 13 to 17: pairs of closed bodies.
void add_pairs(std::vector<HardCase>& cases) {
    const Vec3d up{0, 0, 1}, down{0, 0, -1};
    cases.push_back(
        {13,
         "plate_in_block",
         {},
         {{"",
           box({-1, -1, 0}, {1, 1, 0.01}),
           box({-2, -2, -2}, {2, 2, 2}),
           2,
           {},
           by_separation(2, up),
           2}},
         {},
         "vertices: nothing, every ray leaves the plate first; complete: depth 2, upward",
         ""});
    const double lift = static_cast<double>(0.1f);
    cases.push_back({14,
                     "crossed_bars",
                     {},
                     {{"",
                       box({-2, -0.1, -0.1}, {2, 0.1, 0.1}),
                       box({-0.1, -2, 0}, {0.1, 2, 0.2}),
                       lift,
                       {},
                       by_edges(3, 3, lift * sqrt2, down),
                       lift}},
                     {},
                     "vertices: nothing, none is inside; complete: depth 0.1 sqrt 2 at four ridges "
                     "and 0.1 at two "
                     "diagonals; the first bar down",
                     ""});
    const double dip = static_cast<double>(0.02f);
    cases.push_back(
        {15,
         "coin_on_table",
         {},
         {{"", box({2, 1, -0.02}, {2.1, 1.1, 0.08}), box({-5, -5, -1}, {5, 5, 0}), dip,
           by_vertices(4, 0, dip * sqrt3, up), by_vertices(4, 0, dip * sqrt3, up), dip}},
         {},
         "the coin's four lower corners, 0.02 sqrt 3 deep along their rays and 0.02 re-projected; "
         "none of the table",
         ""});
    const float ridge = 0.05f;
    cases.push_back({16,
                     "crossed_wedges",
                     {},
                     {{"",
                       prism({-2, 0, -ridge}, {-2, -1, 1 - ridge}, {-2, 1, 1 - ridge}, {4, 0, 0}),
                       prism({0, -2, 0}, {-1, -2, -1}, {1, -2, -1}, {0, 4, 0}),
                       static_cast<double>(ridge),
                       {},
                       by_edges(1, 1, static_cast<double>(ridge), up),
                       static_cast<double>(ridge)}},
                     {},
                     "vertices: nothing, none is inside; complete: depth 0.05 at both ridges",
                     ""});
    const double sting = 1 - static_cast<double>(0.9f);
    cases.push_back({17,
                     "spike_in_face",
                     {{cube(), {0.5, 0.5, static_cast<double>(0.9f)}, up, Meets::exit, sting}},
                     {{"",
                       spike({0.5f, 0.5f, 0.9f}, {0.5f, 0.5f, 2}, 0.5f),
                       cube(),
                       sting,
                       by_vertices(1, 0, sting, up),
                       {1, 0, 0, 1, false, sting, up},
                       sting}},
                     {},
                     "the apex, 0.1 deep, upward",
                     ""});
}

/// 18 to 23: meshes with defects, and open ones.
void add_defects(std::vector<HardCase>& cases) {
    const Vec3d up{0, 0, 1}, down{0, 0, -1}, right{1, 0, 0}, center{0.5, 0.5, 0.5},
        at_defect{0.25, -0.25, 0.5};
    const MeshData layer = box({-4, -4, -0.125}, {4, 4, 0.125});
    // So far the corner that both tips share is from either side of the layer.
    const double bowtie_depth = 0.125;
    cases.push_back(
        {18,
         "bowtie_vertex",
         {},
         {{"reflected in the tip",
           bowtie(false),
           layer,
           1.125,
           {},
           {0, 0, 0, 2, false, -1, {}},
           bowtie_depth},
          {"reflected in a plane",
           bowtie(true),
           layer,
           1.125,
           {},
           {0, 0, 0, 2, false, -1, {}},
           bowtie_depth}},
         {{bowtie(false), MeshDefect::bowtie_vertex, 1},
          {bowtie(false), MeshDefect::no_inward_direction, 1},
          {bowtie(true), MeshDefect::bowtie_vertex, 1}},
         "along inward rays no contact at the tip, whose normals cancel; by default the tip is "
         "0.125 deep",
         "the exact answer has a normal and a ray for each of the two fans: Pierce's vertices have "
         "one normal, the mesh check names those with two fans, and by default a vertex needs no "
         "normal to be in contact with the closest point"});
    cases.push_back({19,
                     "no_visible_cone",
                     {},
                     {{"",
                       pyramid_over_c(),
                       box({-9, -9, -0.25}, {9, 9, 1}),
                       0.25,
                       {1, 0, 0, 0, false, -1, {}},
                       {1, 0, 0, 2, false, -1, {}},
                       0.25}},
                     {{pyramid_over_c(), MeshDefect::no_inward_direction, 0}},
                     "the apex is in contact: the direction against its normal is not behind all "
                     "triangles, but leads inside",
                     "the exact answer flags the apex and sends a ray for each triangle; Pierce "
                     "flags a vertex only if the "
                     "direction against its normal leaves the solid, and by default that direction "
                     "does not matter"});
    const double third = static_cast<double>(1.0f / 3.0f), height = static_cast<double>(0.98f);
    const Vec3f place{1.0f / 3.0f, 0.25f, 0.98f};
    cases.push_back(
        {20,
         "cloth_wrong_side",
         {{cube(), {third, 0.25, height}, down, Meets::exit, height},
          {cube(), {third, 0.25, height}, up, Meets::exit, 1 - height}},
         {{"facing down", sheet(place, 0.125f, false), cube(), 1 - height,
           by_vertices(5, 0, 1 - height, up), by_vertices(5, 0, 1 - height, up), 1 - height},
          {"facing up",
           sheet(place, 0.125f, true),
           cube(),
           1 - height,
           {},
           by_separation(1 - height, up),
           1 - height}},
         {},
         "depth 0.02, upward, if the sheet faces down; if it faces up, complete finds "
         "this and vertices nothing",
         "facing up, the sheet's inward rays go down: 0.98 is beyond an open body's "
         "range, so vertices report nothing, "
         "neither 0.98 nor 0.02; as a sheet (World::set_collision) it is pushed out by "
         "0.02 whichever way it faces"});
    cases.push_back(
        {21,
         "flipped_triangle",
         {{cube_with_flipped_triangle(), center, at_defect, Meets::entry, std::sqrt(0.375)},
          {cube_with_flipped_triangle(), center, right, Meets::exit, 0.5}},
         {{"",
           small_cube_around({0.5f, 0.5f, 0.5f}),
           cube_with_flipped_triangle(),
           0.5625,
           {},
           by_separation(0.5625, {}),
           0.5625}},
         {{cube_with_flipped_triangle(), MeshDefect::flipped_edge, 3}},
         "an entry through the flipped triangle, exits through others; the center is inside "
         "(winding number 5/6), and the small cube leaves by 0.5625",
         ""});
    cases.push_back({22,
                     "missing_triangle",
                     {{cube_with_missing_triangle(), center, at_defect, Meets::nothing, 0},
                      {cube_with_missing_triangle(), center, right, Meets::exit, 0.5}},
                     {{"",
                       small_cube_around({0.5f, 0.5f, 0.5f}),
                       cube_with_missing_triangle(),
                       0.5625,
                       {},
                       by_separation(0.5625, {}),
                       0.5625}},
                     {{cube_with_missing_triangle(), MeshDefect::border_edge, 3}},
                     "nothing through the hole, exits elsewhere; the center is inside (winding "
                     "number 11/12), and the small cube leaves by 0.5625",
                     ""});
    cases.push_back({23,
                     "internal_wall",
                     {{joined(cube(), placed(cube(), 1, {1, 0, 0})),
                       {0.5, 1.0 / 3, 1.0 / 3},
                       right,
                       Meets::exit,
                       1.5}},
                     {},
                     {},
                     "one exit at 3/2",
                     ""});
}

/// 24 and 25: motions.
void add_motions(std::vector<HardCase>& cases) {
    const MeshData plate = box({-1, -1, -0.005}, {1, 1, 0.005});
    cases.push_back(
        {24,
         "bullet_through_plate",
         {{plate, {0, 0, 1}, {0, 0, -1}, Meets::entry, 1 - static_cast<double>(0.005f)}},
         {{"before the step", small_cube_around({0, 0, 1}), plate, -1, {}, {}},
          {"after it", small_cube_around({0, 0, -1}), plate, -1, {}, {}}},
         {},
         "outside before and after the step; a ray along the motion enters at 0.4975 of it",
         "not answered by a single pose; the corners of a sheet that moves so meet the plate at "
         "0.4975 of the step"});
    const MeshData low = sheet({0, 0, 0}, 1, true), high = sheet({0, 0, 0.1f}, 1, true);
    cases.push_back(
        {25,
         "comoving_fold",
         {},
         {{"before the step", low, high, -1, {}, {}},
          {"after it", sheet({0, 0, 0.2f}, 1, true), sheet({0, 0, 0.3f}, 1, true), -1, {}, {}}},
         {},
         "no collision",
         "not answered by a single pose; as one sheet the layers have no contact, and one by the "
         "rays as published"});
}

}  // namespace

std::vector<HardCase> hard_cases() {
    std::vector<HardCase> cases;
    add_rays(cases);
    add_pairs(cases);
    add_defects(cases);
    add_motions(cases);
    return cases;
}

}  // namespace pierce::scenes
