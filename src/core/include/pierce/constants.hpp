#pragma once

#include <cstdint>

/// Every tolerance and limit of the library, with its unit and its reason.
/// Lengths are relative: they are multiplied by the extent of the geometry they apply to.
namespace pierce::constants {

/// Distance between 1 and the next float32 [1]: the relative accuracy of positions.
inline constexpr double float_ulp = 0x1p-23;
/// Crossings closer together than this times the target's extent are one crossing, and a vertex
/// closer than this to a surface touches it [target extent]. Eight ulp: the rounding of a position,
/// of a pose and of their sum, twice over.
inline constexpr double touch_tolerance = 8 * float_ulp;

/// How far a tree's boxes reach beyond the triangles [largest coordinate]. A tracer may round the
/// ray to float32 (half an ulp for the origin, half an ulp per unit of length for the direction)
/// and its slab test rounds again.
inline constexpr double tree_margin = 4 * float_ulp;

/// How far a tree's boxes reach beyond the triangles at least [length]. So a body that is a point,
/// or so small that its margin is subnormal, has boxes with an extent. The exact tests in the
/// leaves decide as before.
inline constexpr double least_tree_margin = 0x1p-100;

/// How far boxes are grown for a float32 slab test [largest coordinate]. The ray's origin, its
/// product with the reciprocal and the box's product are each off by half an ulp. Direction,
/// reciprocal and sum each add half an ulp of a distance of up to two coordinates. That is four and
/// a half in all.
inline constexpr double slab_margin = 8 * float_ulp;

/// A direction's component along an axis is taken to be at least smallest_slope, and at least
/// slope_per_coordinate times the largest coordinate [1]. So no product with a reciprocal
/// overflows, and within a box a ray is off by less than slab_margin.
inline constexpr float smallest_slope = 0x1p-60f, slope_per_coordinate = 0x1p-120f;

/// Places of a traversal's stack.
inline constexpr std::uint32_t traversal_stack = 64;

/// Cost of visiting a node of a tree and of testing a leaf, for reports [1] (Karras and Aila 2013).
inline constexpr double node_cost = 1.2, leaf_cost = 1.0;

/// Parts of a treelet. The best tree over n parts is found in 3^n / 2 steps; seven are enough
/// (Karras and Aila 2013).
inline constexpr std::uint32_t treelet_parts = 7;

/// Rounds of treelet restructuring. A round looks at subtrees with at least twice as many leaves as
/// the one before.
inline constexpr std::uint32_t treelet_rounds = 3;

/// When no more treelets than this are ready, lanes climb on to the treelets above by themselves. A
/// GPU that has room for all of them gains nothing from a launch per level, and waits for every
/// launch.
inline constexpr std::uint32_t treelet_crowd = std::uint32_t{1} << 14;

/// How far a cluster looks for the neighbour it joins, either way along the Morton curve (Meister
/// and Bittner 2018): twice as far doubles the work and gains a few per cent of a tree's cost.
inline constexpr std::uint32_t cluster_radius = 8;
/// Leading Morton bits of the grid whose cells an HLBVH starts from: 16 cells a side.
inline constexpr std::uint32_t cell_bits = 12;
/// Bins along each axis between which a split of cells is tried (Wald 2007), except for few cells:
/// looking at each of them is less work, and more exact.
inline constexpr std::uint32_t split_bins = 16, few_cells = 8;
/// A range of at most so many cells is split down to its cells at once. With more, the halves of a
/// range would wait for each other; with less, there would be more launches.
inline constexpr std::uint32_t split_alone_bits = 6,
                               split_alone = std::uint32_t{1} << split_alone_bits;

/// A triangle whose three edge functions are all below this lies in a plane with the ray
/// [sum of the products of the vertex distances]. Double rounding of nine products, with a factor
/// of 16 to spare.
inline constexpr double coplanar_tolerance = 0x1p-46;

/// A triangle with less area than this has no usable normal and is never hit [longest edge
/// squared]: below four float32 ulp its sign is rounding. Behind so many there is a sound one.
inline constexpr double degenerate_area = 4 * float_ulp;
inline constexpr std::uint32_t degenerate_in_a_row = 8;

/// A sum of normals shorter than this is rounding of faces that cancel [1; of a vertex, the angles
/// around it]. angle_of() is wrong by less than half of that.
inline constexpr double vanishing_normal = float_ulp;

/// The number that stands for half a turn around a ray, when the triangles that the ray meets in
/// one point are added up. It is finer than the rounding of angles and leaves room for 2^23
/// triangles.
inline constexpr std::int64_t half_turn = std::int64_t{1} << 40;
/// Smallest net sum that counts as a crossing. Exact sums of closed fans are zero or two half
/// turns; the angles of open fans lie in between.
inline constexpr std::int64_t crossing_weight = half_turn / 2;

/// The direction of a ray that only tells whether its origin is inside: in no plane that is common.
inline constexpr double any_direction[3] = {3, 5, 7};

/// At a smaller sine between ray and face, depth changes a thousand times faster than the vertex.
inline constexpr double grazing_sine = 1e-3;

/// The key of a pair, where bodies have worlds: so many bits for each body, the rest for the world.
inline constexpr std::uint32_t body_bits = 22, most_worlds = (1u << (64 - 2 * body_bits)) - 1;

/// The largest number of vertices, and of edges, of a mesh. Contacts are sorted by keys that keep
/// thirty bits for each.
inline constexpr std::uint32_t max_elements = std::uint32_t{1} << 30;

/// `nudge`: how far edges that only touch are moved before they are cast again; `skin`: how deep
/// both bodies must be there to overlap [touch tolerance]. Both are more than the distance from
/// which two crossings count as two, at any angle that is not small.
inline constexpr double nudge = 4, skin = 16;
/// How much nearer than its box says a triangle may be crossed by an edge [touch tolerance]: one
/// for the ends of an edge, where crossings count a little before and after, and the rest for
/// rounding.
inline constexpr double edge_tolerance = 4;

/// Which edges are near the other body is remembered until the bodies have moved further than the
/// skin: as far as they move in `edge_skin_steps`, but not less than `edge_skin_least` and not more
/// than `edge_skin_most` [mean edge length]. Nothing is remembered of pairs that would have moved
/// further after `edge_skin_wait` steps.
inline constexpr double edge_skin_steps = 16, edge_skin_least = 1.0 / 16, edge_skin_most = 0.25,
                        edge_skin_wait = 2;

/// The parts of a scene that several backends share: how much more than its share of the work a
/// part may have until space is cut anew, and how much of a body's work a ghost is [1]; how much
/// further than bodies reach residents are chosen, ghosts half as much, and how large a body is
/// that counts by itself [mean extent]; boxes of a part's reach; cuts; when waking threads pays.
inline constexpr double uneven_parts = 1.2, ghost_work = 0.5, spare_reach = 0.5, large_body = 4;
inline constexpr std::uint32_t part_cells = 64, cut_rounds = 3, many_bodies = 4096;

/// For how many steps a pair that has contacts without its edges keeps them; and bodies with no
/// more edges are coarse: few of their vertices are inside each other where two of them meet.
inline constexpr std::uint32_t edge_unasked_steps = 16, coarse_edges = 512;

/// A proof that an edge crosses one triangle at most looks as far as the bodies move in
/// `edge_look_steps`, but not less far than `edge_look_least` [mean edge length]: looking further
/// meets more triangles. The triangles near an edge are looked for again once those that were found
/// are known to be all only up to `edge_look_again` of the distance that a look covers [1].
inline constexpr double edge_look_steps = 2, edge_look_least = 1.0 / 16, edge_look_again = 0.25;

/// It is noted that an edge crosses a surface once at most, instead of how far away it is, if that
/// holds so many times longer.
inline constexpr double edge_once_pays = 2;

/// Slabs are not asked for more than what is known of an edge that is this far beyond the box
/// around its target [the lesser of a cell and the source's mean edge length].
inline constexpr double edge_beyond_enough = 0.0625;

/// How deep both bodies must be where an edge inside the other body gives the pair its only
/// contacts [touch tolerance]; a way out into a ridge's own faces is much shorter [way to it].
inline constexpr double least_inside = 2, ridge_share = 0.5;

/// How exact translations that part a pair are [longest one asked for by a contact], and at which
/// squared sine two normals are one direction. What it leaves of the overlap is far less than the
/// touch tolerance unless the pair is a hundred times as deep as it is long.
inline constexpr double translation_rounding = 1.0 / (1 << 26);

/// How often a search for a translation goes on once all contacts had a turn; how many searches.
inline constexpr std::uint32_t translation_rounds = 64, translation_tries = 7;

/// The search for a short translation that parts a pair: how many products of vectors a convex pair
/// may take (0.1 s); how often others are moved again by what contacts demand; a way at most
/// `parting_enough` times as long as the deepest contact is short enough; otherwise, along how many
/// normals of contacts the pair is moved, from which cosine on two are one, which cosine to one's
/// normal counts as this one in a guess, and how often what was too far is halved.
inline constexpr std::uint32_t parting_rounds = 32, parting_halvings = 5;
inline constexpr double parting_enough = 1.1, parting_same_direction = 0.98, parting_slope = 0.5;
inline constexpr std::size_t parting_directions = 6, parting_products = 50'000'000;

/// The direction in which edges that only touch are moved [1]. A mesh has edges or faces along it
/// only by intent.
inline constexpr double nudge_direction[3] = {0.5570860145311556, 0.37139067635410373,
                                              0.7427813527082074};

/// Vertices of a body inside another from which the way out is measured, besides one vertex of the
/// part inside [1]: enough for a stable rest.
inline constexpr std::uint32_t separation_vertices = 4;

/// Vertices per patch: few enough to be small against a body, enough to fill vector registers.
inline constexpr std::uint32_t patch_size = 16;
/// Patches per block: one register's width of them is culled at a time.
inline constexpr std::uint32_t block_size = 16;

/// Triangles per group, and groups per block, when sheets are searched: a mask of sixteen bits says
/// which of another group's sixteen are near.
inline constexpr std::uint32_t group_size = 16;

/// Cells along the longest side of a clearance grid. Measured on 100 tori: 96 and 128 save rays,
/// but cost as much in cache misses, and up to eight times the memory.
inline constexpr std::uint32_t grid_resolution = 64;
/// Clearance is stored in one byte, in steps of this part of a cell [1 / cell].
inline constexpr std::uint32_t clearance_steps_per_cell = 8;

/// Cells along the longest side of a grid of slabs: about two per edge of the mesh, at least and at
/// most.
inline constexpr std::uint32_t slab_resolution_least = 16, slab_resolution = 34;

/// How far from a cell of a grid its slab still holds the surface [cell].
inline constexpr double slab_reach = 1;

/// A segment is looked at in parts no longer than this [cell], if so many times four are enough.
inline constexpr double slab_part = 1.5;
inline constexpr std::uint32_t slab_fours_most = 8;

/// Places in a clearance grid are rounded by less than this [cell]: they are below 2^7 cells, and
/// eight roundings of float32 by half an ulp each lead to one.
inline constexpr double slab_rounding = 0x1p-14;
/// Of a segment that ends further away than this, slabs tell nothing [cell]: clipping it to the
/// grid would round by more than 2^-20 of a cell.
inline constexpr double slab_far = 0x1p30;

/// A slab's planes are stored in steps of this part of a cell [1 / cell], its normal in steps of
/// this part of its length.
inline constexpr double slab_units = 0x1p12;
inline constexpr double slab_normal_unit = 127;

/// If both ends of a segment move by less than this part of its length, times some number up to 1,
/// its direction changes by less than that number: if its length stays, 1/2 would do, otherwise the
/// square root of 1/8.
inline constexpr double slab_turn = 1.0 / 3;

/// Triangles whose box has a diagonal below this are not clipped to find a slab [cell].
inline constexpr double slab_small_triangle = 0.5;

/// Diagonal of a cube [edge length].
inline constexpr double cell_diagonal = 1.7320508075688774;

/// A wedge is tested as a triangle with sides this long from its tip [unit vectors].
inline constexpr double wedge_length = 0x1p20;

/// Squarings of a matrix after which its columns are a rotation near the best fit of a body's
/// vertices, and iterations that turn it into the best fit. Any rotation gives right results; a
/// better fit culls more.
inline constexpr std::uint32_t frame_fit_squarings = 6, frame_fit_iterations = 3;

/// A body with a coordinate beyond this is left out of a step [length]. Squares of differences must
/// be finite in float32, and Embree's trees hold no coordinate beyond 2^60.
inline constexpr double largest_coordinate = 0x1p60;

/// A quaternion whose squared length is not between these two has lost digits or has none [1].
inline constexpr double smallest_rotation = 0x1p-1000, largest_rotation = 0x1p1000;

/// The default length of an open body's rays, which no inside ends [mean edge length].
inline constexpr double open_body_range = 2.0;

/// What double arithmetic on poses may lose in a step, 32 times over [largest coordinate].
inline constexpr double double_rounding = 0x1p-47;

/// What double arithmetic on moving corners may lose [largest coordinate relative to one of them].
/// The sum of the roundings is written out where it is used (separating_direction.hpp), with half
/// as much to spare.
inline constexpr double motion_rounding = 0x1p-46;

/// The same in float32, which has 29 bits less.
inline constexpr float quick_rounding = 0x1p-17f;

/// A grid of boxes is at least this thick [largest coordinate]: one step of the grid is then still
/// an ulp.
inline constexpr float grid_thinness = 0x1p-16f;

/// What a triangle's corners may reach along their own normal in float32 [largest coordinate
/// relative to one of them, to the third]. The sum of the roundings is written out where it is used
/// (quick_triangle.hpp), with half as much to spare.
inline constexpr float quick_normal_rounding = 0x1p-20f;

/// The same of two edges along their common normal, or of a triangle, with coordinates relative to
/// any place [largest coordinate to the third]: quick_prism.hpp, with three quarters as much to
/// spare.
inline constexpr float quick_common_normal_rounding = 0x1p-14f;

/// What a product of four lengths in float32 may lose [largest coordinate to the fourth]. The sum
/// of the roundings is written out where it is used (quick_prism.hpp), with half as much to spare.
inline constexpr float quick_product_rounding = 0x1p-12f;

/// Where a squared normal is below this many times its bound of quick_product_rounding, places
/// along its sides may be off by an eighth, and one more direction is tried [1].
inline constexpr float quick_hidden = 8;

/// What float32 may lose of a gap between a segment and a triangle: along the triangle's normal
/// [side squared], along the product of a side with the segment [side times segment], across a side
/// [side to the third], by the length of the direction [1], and by the coordinates [largest
/// coordinate]. The sums of the roundings are written out where they are used (segment_gap.hpp).
inline constexpr float gap_lost_normal = 0x1p-13f, gap_lost_product = 0x1p-14f,
                       gap_lost_side = 0x1p-11f, gap_lost_length = 0x1p-5f,
                       gap_lost_coordinates = 0x1p-21f;

/// What a search for the closest triangle in float32 takes for rounding: 32 halves of an ulp
/// [distance, and largest coordinate of a triangle relative to the point], and the part of a
/// coordinate that two float32 numbers do not hold, 2^-48, several times [largest coordinate].
inline constexpr float point_rounding = 0x1p-19f;
inline constexpr double point_pad = 0x1p-42;

/// The lengths between which float32 products of four lengths are used [length]. Below
/// quick_smallest their rounding comes near the smallest float32. Above quick_largest their squares
/// may exceed the largest float32.
inline constexpr float quick_smallest = 0x1p-24f, quick_largest = 0x1p19f;

/// Moving features that come closer than this meet [largest coordinate of the corners relative to
/// one of them]: half a float32 ulp. With less than 2^-26, the direction between closest points
/// would be rounding, and a search would take twice as long.
inline constexpr double meeting_tolerance = 0.5 * float_ulp;

/// How often a feature is halved at most when the time of a meeting is looked for. Weights of its
/// parts stay exact.
inline constexpr int meeting_halvings = 40;

/// Advances of a search for a meeting, after which it answers that there is one. Measured on two
/// layers of cloth that shake through each other: 12 where they meet, 69 at most. Close beside a
/// turning face, a search takes 8 advances over the square root of the relative gap.
inline constexpr int meeting_advances = 1 << 14;

/// A solid is not in contact with itself at places that are closer together than this at rest [mean
/// edge length]. These are three rings of triangles, which bend but do not meet.
inline constexpr double self_distance = 3.0;

/// Up to so many features of one key are sorted by insertion; a heap takes as long for fewer.
inline constexpr std::uint32_t few_ties = 16;

/// What is near an edge is looked for all around it below this cosine between its triangles'
/// normals, and from this touch tolerance over a triangle's height on [1].
inline constexpr double wedge_cosine = -0.5, wedge_slack = 0.1;
/// Between edges at an angle with at least this sine, the way at right angles to both is known as a
/// unit vector to `way_slack` if it is longer than the touch tolerance of their coordinates [1].
inline constexpr double edges_sine = 0.01, way_slack = 1e-6;
/// How far ridges of a pair may have passed each other [margin], and [depth of the pair].
inline constexpr double passed_share = 0.25, passed_depths = 4;

/// Steps from one full pass of a pair to the next.
inline constexpr std::uint32_t full_every = 8;

/// Displacement up to which walks are tried [mean edge length]. Two edges are four steps of a walk
/// on average.
inline constexpr double walk_threshold = 2.0;

/// Steps of a walk from triangle to triangle at most: twice what two edges of displacement need on
/// average, and two more.
inline constexpr std::uint32_t walk_steps = 10;

/// Predictions reach this far at most [mean edge length].
inline constexpr double prediction_limit = 2.0;

/// A predicted vertex is looked at again when the bodies have moved by this part of the vertex's
/// distance to the plane it may enter through [1]. It is half, as the surface need not be flat.
inline constexpr double prediction_wait = 0.5;

/// Vertices are proved to be outside up to here [mean edge of the target]: further costs too much.
inline constexpr double certificate_limit = 1.0;

/// A proof that is expected to expire within this many steps is skipped, and a proof that failed is
/// retried only after as many [steps].
inline constexpr double certificate_steps = 16;

/// Steps remember as long as this share of the vertices near a target needs no full ray [1]; the
/// second holds where a body deforms, as its vertices are compared with the last step's. Measured
/// on piles of 16 and 100 rigid tori and bunnies, one thread: below 0.55 remembering costs up to
/// 20 %, at 0.75 it gains 11 to 46 %; on soft piles it costs 3 to 8 % up to 0.8.
inline constexpr double memory_share = 0.65, memory_share_deforming = 0.9;

/// Steps before memory is judged, steps in a row that do not pay before it rests, steps of the
/// first rest, and how often the next rest is twice as long: 64 steps at most, so that memory is
/// tried in 5 of 69 steps. It does not rest while at most one body in `memory_still` changes.
inline constexpr std::uint32_t memory_trial = 3, memory_patience = 2, memory_first_rest = 32,
                               memory_doublings = 1, memory_still = 10;

/// Bodies from which on those at rest may become a part; steps without a change that make one of
/// these; steps' worth of looking at them until parts are chosen anew, and the most if none pays.
inline constexpr std::uint32_t rest_bodies = 256, rest_steps = 16, rest_patience = 8,
                               rest_most_patience = 256;

/// Cost of rebuilding a tree [triangle tests per triangle], measured with Embree 3.13: 0.5 us
/// against 25 ns; rays after which a tree's cost per ray is known well enough.
inline constexpr double rebuild_cost = 20.0;
inline constexpr std::uint64_t rebuild_baseline_rays = 256;

/// The gap of a ring is smaller than it could be by less than this [reach of the ring].
inline constexpr double ring_gap_loss = 0x1p-6;
/// A run of so few triangles is not divided further, and a run counts as one dipole for points that
/// are so many times its radius away (Barill et al. 2018): hundredths of a winding number are lost.
inline constexpr std::uint32_t winding_leaf = 8;
inline constexpr double winding_reach = 2.0;

/// A triangle of a solid's surface has a winding number within this of 1/2. A patch is left out if
/// this share of the area of its samples has not. So many lines from each look for a way out.
inline constexpr double surface_winding = 0.25, wall_share = 0.9;
inline constexpr std::uint32_t wall_samples = 16, wall_rounds = 8, sight_lines = 32;

/// Borders so near [mean edge length] are the sides of a gap if the band between them has less than
/// this share of two caps' area, and vertices so near [shortest edge] are. A part of less volume
/// [area^(3/2)] faces no way.
inline constexpr double gap_width = 1.0, gap_area = 0.5, seam_width = 0.25, flat_part = 1e-6;
/// A hole of so many edges gets the cap of the least area; the work grows with their cube.
inline constexpr std::uint32_t gap_neighbors = 16, exact_cap_edges = 128;

/// A mesh is nearly closed up to this share of caps among its area and among its triangles, if each
/// cap has few edges or this share of the area [1]. So a cube may lack a triangle, but not a side.
inline constexpr double caps_of_area = 1.0 / 6, caps_of_triangles = 0.125, small_cap = 0.02;
inline constexpr std::uint32_t small_cap_edges = 12;
/// Caps with more of the area make no solid [1]: a sheet's cap is the sheet once more.
inline constexpr double largest_caps = 0.75;

/// Places that a finding of the mesh check keeps: enough to look at, few enough to print.
inline constexpr std::uint32_t finding_places = 8;

}  // namespace pierce::constants
