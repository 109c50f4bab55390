#pragma once

#include <memory>
#include <utility>

#include "core/base/archive.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/records.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/world/world_state.hpp"

/// What a world consists of, as bytes: for every type, the parts it consists of.
namespace pierce {

template <class A, class Tag>
void transfer(A& archive, Id<Tag>& id) {
    transfer_all(archive, id.index, id.generation);
}

template <class A>
void transfer(A& archive, Settings& s) {
    transfer_all(archive, s.open_body_range, s.margin, s.reproject, s.predict, s.may_rest,
                 s.prediction_distance, s.full_every, s.walk_threshold);
    transfer(archive, s.coverage, Coverage::overlaps);
    transfer(archive, s.temporal, Temporal::certified);
}

template <class A>
void transfer(A& archive, MemoryRest& r) {
    transfer_all(archive, r.tried, r.poor, r.resting, r.rests);
}

template <class A>
void transfer(A& archive, Triangle& t) {
    transfer(archive, t.vertex);
}

template <class A>
void transfer(A& archive, Pose& p) {
    transfer_all(archive, p.position, p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w);
}

template <class A>
void transfer(A& archive, Collision& c) {
    transfer(archive, c.self, SelfCollision::published);
    transfer_all(archive, c.sheet, c.thickness, c.margin);
}

template <class A>
void transfer(A& archive, Filter& f) {
    transfer_all(archive, f.groups, f.meets, f.chain, f.world);
}

template <class A>
void transfer(A& archive, Frame& f) {
    for (Vec3d& row : f.rotation.row) transfer(archive, row);
    transfer(archive, f.origin);
}

template <class A>
void transfer(A& archive, SeenPatch& p) {
    transfer_all(archive, p.center, p.offsets.x, p.offsets.y, p.offsets.z);
}

template <class A>
void transfer(A& archive, BodyEntry& b) {
    transfer(archive, b.mesh);
    transfer(archive, b.motion, Motion::deforming);
    transfer_all(archive, b.pose, b.positions, b.start, b.start_pose, b.moved, b.collision,
                 b.filter, b.seen, b.positions_version, b.usable);
}

template <class A>
void transfer(A& archive, BodyKinds& k) {
    transfer_all(archive, k.solids, k.deforming, k.margins, k.sheets, k.velocity_rays,
                 k.meets_itself, k.worlds, k.feature_bits);
}

template <class A>
void transfer(A& archive, BodyIdPair& p) {
    transfer_all(archive, p.a, p.b);
}

template <class A>
void transfer(A& archive, PairIdentity& p) {
    transfer_all(archive, p.a, p.b, p.mesh_a, p.mesh_b, p.sheet_a, p.sheet_b, p.margin);
    transfer(archive, p.self_a, SelfCollision::published);
    transfer(archive, p.self_b, SelfCollision::published);
}

template <class A>
void transfer(A& archive, SeenBody& b) {
    transfer_all(archive, b.id, b.fit, b.active);
}

template <class A>
void transfer(A& archive, SheetRecord& r) {
    transfer_all(archive, r.other, r.age, r.side, r.is_self, r.is_edge, r.distance);
    transfer(archive, r.found, Found::separation);
}

template <class A>
void transfer(A& archive, PairMemory& m) {
    transfer_all(archive, m.relative, m.step, m.odometer, m.at_full, m.since_full, m.known,
                 m.first_block);
    transfer(archive, m.pass, Pass::walk);
}

template <class A>
void transfer(A& archive, BlockRecord& r) {
    transfer_all(archive, r.expiry, r.kept, r.first_patch);
}

template <class A>
void transfer(A& archive, PatchRecord& r) {
    transfer_all(archive, r.mask, r.first_vertex, r.expiry);
}

template <class A>
void transfer(A& archive, VertexRecord& r) {
    transfer_all(archive, r.triangle, r.predicted, r.expiry, r.retry, r.contact, r.seen_triangle,
                 r.seen_weight, r.seen_offset);
}

template <class A>
void transfer(A& archive, Contact& c) {
    transfer_all(archive, c.a, c.b, c.grazing, c.reprojected, c.of_sheet, c.unknown_side, c.vertex,
                 c.edge_end, c.edge, c.chord, c.other_edge, c.triangle, c.age, c.along, c.time,
                 c.distance, c.barycentric, c.point_a, c.point_b, c.normal, c.face_normal);
    transfer(archive, c.source, Side::b);
    transfer(archive, c.found, Found::separation);
}

template <class A>
void transfer(A& archive, StepMemory& m) {
    transfer_all(archive, m.by_world, m.pair_keys, m.identities, m.bodies, m.directed, m.blocks,
                 m.patches, m.vertices, m.contact_keys, m.ages, m.contacts, m.sheet_bits,
                 m.sheet_keys, m.sheet_records, m.deepest);
}

/// A mesh as it is saved.
struct SavedMesh {
    std::string name;
    MeshData data;
    Inside inside = Inside::closed;
    std::uint64_t key = 0;
};

template <class A>
void transfer(A& archive, SavedMesh& m) {
    transfer_all(archive, m.name, m.data.positions, m.data.triangles, m.key);
    transfer(archive, m.inside, Inside::none);
}

inline SavedMesh saved(const MeshEntry& entry) {
    return {.name = entry.mesh->name(),
            .data = entry.mesh->data(),
            .inside = rule_that_made(entry.mesh->inside()),
            .key = entry.key};
}

inline MeshEntry made_from(SavedMesh saved) {
    return {std::make_shared<const Mesh>(std::move(saved.name), std::move(saved.data),
                                         MeshOptions{.inside = saved.inside}),
            saved.key};
}

}  // namespace pierce
