#include <algorithm>
#include <span>

#include "scenes/recording/recording.hpp"

namespace pierce::scenes {
namespace {

/// Every Nth frame of those from `first` on, before `end`.
Recording picked(const Recording& recording, std::uint32_t first, std::uint32_t end,
                 std::uint32_t every) {
    Recording result = recording;
    result.dt = every * recording.dt;
    result.frame_count = (end - first + every - 1) / every;
    for (std::uint32_t b = 0; b < result.bodies.size(); ++b) {
        const RecordedBody& whole = recording.bodies[b];
        RecordedBody& body = result.bodies[b];
        // A body that stays has one frame.
        if (body.motion != Motion::deforming &&
            whole.values.size() == recording.numbers(b, 0).size())
            continue;
        body.values.clear();
        body.mesh_changes.clear();
        body.mesh = recording.mesh_of(b, first);
        for (std::uint32_t f = first, mesh = body.mesh; f < end; f += every) {
            if (recording.mesh_of(b, f) != mesh) {
                mesh = recording.mesh_of(b, f);
                body.mesh_changes.push_back({(f - first) / every, mesh});
            }
            const std::span<const float> numbers = recording.numbers(b, f);
            body.values.insert(body.values.end(), numbers.begin(), numbers.end());
        }
    }
    return result;
}

}  // namespace

Recording excerpt(const Recording& recording, std::uint32_t first, std::uint32_t count) {
    const std::uint32_t begin = std::min(first, recording.frame_count);
    return picked(recording, begin, begin + std::min(count, recording.frame_count - begin), 1);
}

Recording thinned(const Recording& recording, std::uint32_t frames) {
    return picked(recording, 0, recording.frame_count,
                  std::max(1u, recording.frame_count / std::max(frames, 1u)));
}

Recording as_deforming(const Recording& recording) {
    Recording result = recording;
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        if (recording.bodies[b].motion != Motion::rigid) continue;
        RecordedBody& body = result.bodies[b];
        body.motion = Motion::deforming;
        body.values.clear();
        for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
            const Frame frame = frame_of(recording.pose(b, f));
            for (Vec3f rest : recording.meshes[body.mesh].data.positions) {
                const Vec3f p = to_float(frame.to_parent(to_double(rest)));
                body.values.insert(body.values.end(), {p.x, p.y, p.z});
            }
        }
    }
    return result;
}

}  // namespace pierce::scenes
