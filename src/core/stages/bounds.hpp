#pragma once

#include "pierce/core/body.hpp"
#include "pierce/core/patch.hpp"

/// Stage 1, bounds: where every body is, how far it is from its rest shape, and spheres around its patches.
/// Deforming bodies are measured in chunks of constants::chunk_patches patches, so sums are the same on any machine.
namespace pierce::stages {

/// A chunk of a deforming body's patches.
struct Chunk {
    std::uint32_t body = 0;
    std::uint32_t first_patch = 0;
    std::uint32_t last_patch = 0;  ///< one past the end
};

/// Sums over a chunk from which the best-fitting rotation follows.
struct Moments {
    Vec3d sum;             ///< of positions, relative to the body's first vertex
    Matrix3 correlation;   ///< of those positions with the rest positions relative to the rest centroid
};

/// Per chunk: adds up moments. Reads positions; writes moments.
struct MeasureMoments {
    View<const BodyView> bodies;
    View<const Chunk> chunks;
    View<Moments> moments;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Chunk chunk = chunks[i];
        const BodyView& body = bodies[chunk.body];
        Moments m{{}, {{{}, {}, {}}}};
        if (body.active) {
            const Vec3d base = to_double(body.positions[0]);
            const std::uint32_t begin = chunk.first_patch * constants::patch_size;
            const std::uint32_t end = min_of(chunk.last_patch * constants::patch_size, body.positions.size);
            for (std::uint32_t k = begin; k < end; ++k) {
                const std::uint32_t v = body.mesh.patch_vertices[k];
                const Vec3d x = to_double(body.positions[v]) - base;
                const Vec3d rest = to_double(body.mesh.positions[v]) - body.mesh.centroid;
                m.sum += x;
                for (int r = 0; r < 3; ++r) m.correlation.row[r] += x[r] * rest;
            }
        }
        moments[i] = m;
    }
};

/// The rotation closest to `a` (in the sense of largest trace of R^T a), by the iteration of Mueller, Bender,
/// Chentanez and Macklin (MIG 2016), starting from `start`.
PIERCE_HD inline Quaternion closest_rotation(const Matrix3& a, Quaternion start) {
    Quaternion q = start;
    const Matrix3 columns = a.transposed();
    for (std::uint32_t i = 0; i < constants::frame_fit_iterations; ++i) {
        const Matrix3 axes = rotation_matrix(q).transposed();
        Vec3d torque;
        double trace = 0;
        for (int k = 0; k < 3; ++k) {
            torque += cross(axes.row[k], columns.row[k]);
            trace += dot(axes.row[k], columns.row[k]);
        }
        const double size = std::fabs(trace);
        if (!(size > 0)) break;
        const Vec3d h = torque * (0.5 / size);
        // One step of rotation by the vector 2h, as the quaternion (h, 1), then back to unit length.
        const Quaternion r{q.x + h.x * q.w + h.y * q.z - h.z * q.y, q.y + h.y * q.w + h.z * q.x - h.x * q.z,
                           q.z + h.z * q.w + h.x * q.y - h.y * q.x, q.w - h.x * q.x - h.y * q.y - h.z * q.z};
        const double l = std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w);
        q = {r.x / l, r.y / l, r.z / l, r.w / l};
    }
    return q;
}

/// The chunks of one deforming body, and the rotation it was last fitted with.
struct ChunkRange {
    std::uint32_t body = 0;
    std::uint32_t first = 0;
    std::uint32_t last = 0;
};

/// Per deforming body: fits a frame. Reads moments and the last rotation; writes the body's fit and that rotation.
struct FitFrame {
    View<BodyView> bodies;
    View<const ChunkRange> ranges;
    View<const Moments> moments;
    View<Quaternion> rotations;  ///< per body

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ChunkRange range = ranges[i];
        BodyView& body = bodies[range.body];
        if (!body.active) return;
        Moments m{{}, {{{}, {}, {}}}};
        for (std::uint32_t c = range.first; c < range.last; ++c) {
            m.sum += moments[c].sum;
            for (int r = 0; r < 3; ++r) m.correlation.row[r] += moments[c].correlation.row[r];
        }
        // The rest positions are relative to their centroid, so the mean of x drops out of the correlation.
        rotations[range.body] = closest_rotation(m.correlation, rotations[range.body]);
        const Vec3d mean = to_double(body.positions[0]) + m.sum * (1.0 / body.positions.size);
        body.fit.rotation = rotation_matrix(rotations[range.body]);
        body.fit.origin = mean - body.fit.rotation * body.mesh.centroid;
    }
};

/// What a chunk adds to its body's bounds.
struct ChunkBounds {
    Box fit_box, world_box;
    double deviation = 0;
};

/// Per chunk: boxes, deviation and patch spheres. Reads positions and fit; writes chunk bounds and spheres.
struct MeasureChunk {
    View<const BodyView> bodies;
    View<const Chunk> chunks;
    View<ChunkBounds> bounds;
    View<const View<PatchSphere>> patches;  ///< per body
    View<const View<PatchOffsets>> patch_offsets;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Chunk chunk = chunks[i];
        const BodyView& body = bodies[chunk.body];
        ChunkBounds b;
        if (body.active) {
            for (std::uint32_t p = chunk.first_patch; p < chunk.last_patch; ++p) {
                measure_patch(body.mesh, body.positions, p, patches[chunk.body][p], patch_offsets[chunk.body][p]);
                for (std::uint32_t k = 0; k < patch_length(body.mesh, p); ++k) {
                    const std::uint32_t v = body.mesh.patch_vertices[p * constants::patch_size + k];
                    const Vec3d x = to_double(body.positions[v]);
                    const Vec3d local = body.fit.to_local(x);
                    b.world_box.extend(x);
                    b.fit_box.extend(local);
                    b.deviation = max_of(length_squared(local - to_double(body.mesh.positions[v])), b.deviation);
                }
            }
            b.deviation = std::sqrt(b.deviation);
        }
        bounds[i] = b;
    }
};

/// Per deforming body: joins its chunks' bounds. Writes the body's boxes, deviation and touch tolerance.
struct JoinBounds {
    View<BodyView> bodies;
    View<const ChunkRange> ranges;
    View<const ChunkBounds> bounds;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const ChunkRange range = ranges[i];
        BodyView& body = bodies[range.body];
        if (!body.active) return;
        ChunkBounds all;
        for (std::uint32_t c = range.first; c < range.last; ++c) {
            all.world_box.extend(bounds[c].world_box);
            all.fit_box.extend(bounds[c].fit_box);
            all.deviation = max_of(bounds[c].deviation, all.deviation);
        }
        body.world_box = all.world_box;
        body.fit_box = all.fit_box;
        body.deviation = all.deviation;
        body.touch = constants::touch_tolerance * all.fit_box.extent();
    }
};

/// Per body: the world box of a fixed or rigid body that moved. Reads its pose and rest box.
struct PlaceBox {
    View<BodyView> bodies;

    PIERCE_HD void operator()(std::uint32_t i) const {
        BodyView& body = bodies[i];
        if (body.motion == Motion::deforming || !body.active) return;
        const Vec3d half = body.fit_box.half_size();
        const Vec3d center = body.space.to_parent(body.fit_box.center());
        Vec3d reach;
        for (int k = 0; k < 3; ++k) {
            const Vec3d r = body.space.rotation.row[k];
            reach[k] = std::fabs(r.x) * half.x + std::fabs(r.y) * half.y + std::fabs(r.z) * half.z;
        }
        body.world_box = {center - reach, center + reach};
    }
};

}  // namespace pierce::stages
