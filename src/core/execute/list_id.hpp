#pragma once

#include <cstddef>
#include <cstdint>

namespace pierce {

/// The lists whose length a step finds out. An executor tells lists apart by this, and may size a
/// list by its length in earlier steps.
enum class ListId : std::uint8_t {
    // solids
    pairs,
    box_pairs,
    swept_pairs,
    pair_blocks,
    near_patches,
    near_vertices,
    walks,
    full_rays,
    candidates,
    contacts,
    uncertain_rays,
    // edges
    edge_blocks,
    edge_groups,
    found_edges,
    edges_in_boxes,
    near_edges,
    asked_edges,
    crossed_pairs,
    chords,
    chords_at_ends,
    late_candidates,
    touching_edges,
    chords_forward,
    chords_back,
    deep_touches,
    // self_overlap and separation
    self_candidates,
    outward_rays,
    entering_rays,
    inward_rays,
    stranded_vertices,
    deep_vertices,
    stranded_chords,
    deep_chords,
    parts,
    contained_parts,
    deep_pairs,
    separated_rays,
    touching_rays,
    // margin
    margin_blocks,
    margin_patches,
    margin_vertices,
    near_contacts,
    margin_edge_blocks,
    margin_edge_groups,
    margin_edges,
    margin_ridges,
    margin_ridge_groups,
    near_edge_pairs,
    first_contacts,
    // sheets
    sheet_vertices,
    sheet_sections,
    sheet_blocks,
    section_rows,
    section_pairs,
    block_pairs,
    group_pairs,
    near_triangles,
    triangle_pairs,
    feature_triangles,
    open_triangles,
    features,
    undecided_features,
    sheet_contacts,
    // trees
    tree_cells,
    tree_clusters,
    tree_ranges,
    treelets,
    count
};

inline constexpr std::size_t list_count = static_cast<std::size_t>(ListId::count);

}  // namespace pierce
