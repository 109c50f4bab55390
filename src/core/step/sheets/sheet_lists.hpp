#pragma once

#include <cstdint>
#include <span>

#include "core/execute/executor.hpp"
#include "core/step/common/contact_keys.hpp"
#include "core/step/common/records.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/step/sheets/flat_stars.hpp"
#include "core/step/sheets/sheet_contacts.hpp"

/// The lists of sheets in a step, grouped by the stages that write them. They grow and are kept.
namespace pierce {

/// What a step remembers of sheets for the next one, where the executor keeps it.
template <Executor E>
struct SheetRecords {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    SheetKey sheet_key;             ///< of `keys`
    Buffer<std::uint64_t> keys;     ///< per contact, in the order of the contacts
    Buffer<SheetRecord> records;    ///< per contact
    Buffer<std::uint32_t> deepest;  ///< per pair, how far vertices are on the wrong side, as the
                                    ///< bits of a float32; not 0 if something touches

    void forget() {
        keys.clear();
        records.clear();
        deepest.clear();
    }
    void save(const E& executor, StepMemory& m) const {
        m.sheet_bits = sheet_key.bits;
        m.sheet_keys = executor.download(keys);
        m.sheet_records = executor.download(records);
        m.deepest = executor.download(deepest);
    }
    void restore(E& executor, const StepMemory& m) {
        sheet_key.bits = m.sheet_bits;
        executor.upload(std::span(m.sheet_keys), keys);
        executor.upload(std::span(m.sheet_records), records);
        executor.upload(std::span(m.deepest), deepest);
    }
};

/// Where the sections, blocks and vertices of wanted bodies are among those of all; per body.
template <Executor E>
struct SheetPlaces {
    typename E::template Buffer<std::uint32_t> wanted, section_counts, block_counts, vertex_counts,
        section_offsets, block_offsets, vertex_offsets;
};

/// Where vertices and triangles are over the step, and bounds of groups, blocks and sections.
template <Executor E>
struct SheetBounds {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::MovingVertex> vertices;
    Buffer<stages::DriftingTriangle> triangles;
    Buffer<QuickBox> triangle_boxes, group_boxes, block_boxes;
    Buffer<GridBoxes> in_groups, in_blocks, in_sections;
    Buffer<stages::Slab> group_slabs, block_slabs;
    Buffer<stages::GroupHeights> group_heights;  ///< on the host only
    Buffer<std::uint32_t> section_begins, section_ends;
    Buffer<std::uint32_t> flat;  ///< per vertex: nothing folds around it
    Buffer<stages::FlatCorners> flat_corners;
};

/// Pairs with a sheet, and which parts of them may be close: from sections to triangles.
template <Executor E>
struct SheetSearchLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::SheetPair> pairs;
    Buffer<std::uint32_t> links;  ///< per pair, which of last step's pairs it was; no_pair if
                                  ///< sheets forget
    Buffer<stages::SectionRow> section_rows;
    Buffer<stages::ClosePair> sections, blocks, groups;
    Buffer<stages::NearInGroup> near;
    Buffer<stages::TrianglePair> triangles;
};

/// Features that may meet, in any order and in that of the contacts, and what becomes of them.
template <Executor E>
struct SheetFeatureLists {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<stages::MeetingTriangles> triangles;
    Buffer<std::uint32_t> open;  ///< of the triangles, those whose features are found by exact
                                 ///< tests
    Buffer<stages::FeaturePair> features;
    Buffer<std::uint64_t> keys;
    Buffer<std::uint32_t> order;
    Buffer<stages::SheetMeeting> meetings;
    Buffer<stages::Judgement> judgements;
    Buffer<std::uint32_t> undecided, ages, kept;
    Buffer<Contact> contacts;
};

}  // namespace pierce
