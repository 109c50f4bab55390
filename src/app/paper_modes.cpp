#include "app/paper_modes.hpp"

#include "app/frame_log.hpp"
#include "app/progress.hpp"

namespace pierce::app {

double Mode::median_ms() const { return spread_of(narrow_ms).median; }
double Mode::moving_median_ms() const { return spread_of(moving_ms).median; }

Mode mode(std::string name, Temporal temporal, bool predict) {
    Mode m;
    m.name = std::move(name);
    m.settings.temporal = temporal;
    m.settings.predict = predict;
    return m;
}

void measure(const scenes::Recording& recording, std::vector<Mode>& modes,
             const std::string& what) {
    for (Mode& m : modes)
        m.detector = scenes::make_detector(scenes::scene_of(recording), scenes::Method::rays,
                                           {"embree", 1, m.settings});
    Progress progress(what, recording.frame_count);
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        for (Mode& m : modes) {
            scenes::put_frame(*m.detector, recording, f);
            const scenes::FrameResult result = m.detector->detect();
            m.comparison.add(modes[0].detector->world()->contacts(),
                             m.detector->world()->contacts());
            if (f < recording.frame_count / 2) {
                m.moving_ms.push_back(result.narrow_ms);
                m.moving_contacts += result.contacts;
                continue;
            }
            m.narrow_ms.push_back(result.narrow_ms);
            m.rays += result.rays;
            m.contacts += result.contacts;
            m.walks += result.walks;
            m.walk_steps += result.walk_steps;
            m.lost += result.lost_walks;
        }
        progress.show(f + 1);
    }
    for (Mode& m : modes) m.detector.reset();
}

}  // namespace pierce::app
