#include "app/reports/paper/modes.hpp"

#include "app/output/frame_log.hpp"
#include "app/output/progress.hpp"

namespace pierce::app {

double PartOfMotion::median_ms() const { return spread_of(ms).median; }

PartOfMotion Mode::whole() const {
    PartOfMotion all = halves[0];
    const PartOfMotion& rest = halves[1];
    all.ms.insert(all.ms.end(), rest.ms.begin(), rest.ms.end());
    all.not_captured += rest.not_captured;
    for (std::uint64_t PartOfMotion::*count :
         {&PartOfMotion::rays, &PartOfMotion::walks, &PartOfMotion::walk_steps, &PartOfMotion::lost,
          &PartOfMotion::contacts})
        all.*count += rest.*count;
    return all;
}

Mode mode(std::string name, Temporal temporal, bool predict) {
    Mode m{.name = std::move(name), .settings = vertex_rays};
    m.settings.temporal = temporal;
    m.settings.predict = predict;
    return m;
}

namespace {

void note(PartOfMotion& half, const scenes::FrameResult& result, bool on_gpu) {
    if (!on_gpu)
        half.ms.push_back(result.narrow_ms);
    else if (result.device_milliseconds > 0)
        half.ms.push_back(result.device_milliseconds);
    else
        ++half.not_captured;
    half.rays += result.rays;
    half.contacts += result.contacts;
    half.walks += result.walks;
    half.walk_steps += result.walk_steps;
    half.lost += result.lost_walks;
}

}  // namespace

void measure(const scenes::Recording& recording, std::vector<Mode>& modes, const std::string& what,
             bool compares) {
    for (Mode& m : modes)
        m.detector = scenes::make_detector(
            scenes::scene_of(recording), scenes::Method::rays,
            {.backend = m.backend, .threads = 1, .world = m.settings});
    Progress progress(what, recording.frame_count);
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        for (Mode& m : modes) {
            scenes::put_frame(*m.detector, recording, f);
            const scenes::FrameResult result = m.detector->detect();
            if (compares)
                m.comparison.add(modes[0].detector->world()->contacts(),
                                 m.detector->world()->contacts());
            note(m.halves[f < recording.frame_count / 2 ? 0 : 1], result, m.backend == "cuda");
        }
        progress.show(f + 1);
    }
    for (Mode& m : modes) m.detector.reset();
}

}  // namespace pierce::app
