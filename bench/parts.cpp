// What parts of a scene have to see, for any number of parts, without running a step.
//   pierce_parts RECORDING|lattice:COUNT... [--frames N]
// A lattice is COUNT rigid tori that touch their neighbours and turn. Prints CSV: in how many
// frames parts looked around, how many times space was cut, how uneven the work is (that of the
// busiest part over the mean, ghosts counted in part), ghosts of a part, from how many parts they
// come, and what their positions take [bytes of float32].
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/partition/partition.hpp"
#include "pierce/constants.hpp"
#include "pierce/plan.hpp"
#include "scenes/recording/lattice.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce {
namespace {

/// A recording's bodies as a partition reads them.
class Bodies {
public:
    explicit Bodies(const scenes::Recording& recording)
        : recording_(recording), views_(recording.bodies.size()), ids_(views_.size()) {
        plan_.revision = 1;
        for (const auto& mesh : recording.meshes) {
            boxes_.emplace_back();
            for (const Vec3f p : mesh.data.positions) boxes_.back().extend(to_double(p));
        }
        for (std::uint32_t b = 0; b < views_.size(); ++b) {
            ids_[b] = {b, 1};
            changed_.push_back(b);
            views_[b].motion = recording.bodies[b].motion;
        }
    }

    void put(std::uint32_t frame) {
        for (std::uint32_t b = 0; b < views_.size(); ++b) {
            BodyView& view = views_[b];
            const std::uint32_t mesh = recording_.mesh_of(b, frame);
            const std::vector<Triangle>& triangles = recording_.meshes[mesh].data.triangles;
            view.mesh.triangles = {triangles.data(), static_cast<std::uint32_t>(triangles.size())};
            if (view.motion == Motion::deforming) {
                const std::span<const Vec3f> positions = recording_.positions(b, frame);
                view.positions = {positions.data(), static_cast<std::uint32_t>(positions.size())};
            } else {
                view.mesh.box = boxes_[mesh];
                view.space = view.start_space = frame_of(recording_.pose(b, frame));
            }
        }
    }

    Scene scene() {
        Scene all;
        all.bodies = view_of(views_);
        all.ids = view_of(std::as_const(ids_));
        all.changed = view_of(std::as_const(changed_));
        all.plan = &plan_;
        return all;
    }

    double bytes_of(std::uint32_t body) const {
        const std::uint32_t mesh = recording_.mesh_of(body, 0);
        return static_cast<double>(recording_.meshes[mesh].data.positions.size() * sizeof(Vec3f));
    }
    std::uint32_t count() const { return static_cast<std::uint32_t>(views_.size()); }
    bool moves(std::uint32_t body) const { return views_[body].motion != Motion::fixed; }

private:
    const scenes::Recording& recording_;
    std::vector<BodyView> views_;
    std::vector<BodyId> ids_;
    std::vector<std::uint32_t> changed_;
    std::vector<Box> boxes_;
    Plan plan_;
};

/// A mean over frames and parts, and the largest value.
struct Spread {
    double sum = 0, most = 0;
    std::uint32_t count = 0;

    void add(double value) {
        sum += value;
        most = std::max(most, value);
        ++count;
    }
    double mean() const { return count > 0 ? sum / count : 0; }
};

void run(const std::string& name, const scenes::Recording& recording, std::uint32_t frames) {
    for (const std::uint32_t parts : {2u, 4u, 10u, 30u, 100u, 300u, 1000u}) {
        if (10 * parts > recording.bodies.size()) break;
        Bodies bodies(recording);
        Partition partition(std::vector<double>(parts, 1.0));
        std::uint32_t cuts = 0, looks = 0;
        Spread uneven, ghosts, sources, bytes;
        const std::uint32_t last = std::min(frames, recording.frame_count);
        for (std::uint32_t f = 0; f < last; ++f) {
            bodies.put(f);
            const Scene scene = bodies.scene();
            partition.begin(scene, f == 0);
            for (std::uint32_t p = 0; p < partition.parts(); ++p)
                partition.measure_on_host(scene, p);
            if (partition.is_out_of_date(0)) {
                for (std::uint32_t p = 0; p < parts; ++p) partition.look_around(p);
                cuts += partition.cut(scene);
                ++looks;
            }
            Spread load;
            for (std::uint32_t p = 0; p < parts; ++p) {
                std::uint32_t foreign = 0;
                double work = 0, foreign_bytes = 0;
                std::set<std::uint32_t> from;
                for (std::uint32_t b = 0; b < bodies.count(); ++b) {
                    if (!partition.near(p)[b]) continue;
                    work += partition.owners()[b] == p ? 1 : constants::ghost_work;
                    // What does not move goes over once, not in every step.
                    if (partition.owners()[b] == p || !bodies.moves(b)) continue;
                    ++foreign;
                    from.insert(partition.owners()[b]);
                    foreign_bytes += bodies.bytes_of(b);
                }
                load.add(work);
                ghosts.add(foreign);
                sources.add(static_cast<double>(from.size()));
                bytes.add(foreign_bytes);
            }
            uneven.add(load.most / load.mean());
        }
        std::printf("%s,%zu,%u,%u,%u,%u,%.3f,%.1f,%.0f,%.2f,%.0f,%.0f,%.0f\n", name.c_str(),
                    recording.bodies.size(), last, parts, looks, cuts, uneven.mean(), ghosts.mean(),
                    ghosts.most, sources.mean(), sources.most, bytes.mean(), bytes.most);
        std::fflush(stdout);
    }
}

}  // namespace
}  // namespace pierce

int main(int argc, char** argv) {
    std::uint32_t frames = 16;
    std::vector<std::string> scenes;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--frames" && i + 1 < argc)
            frames = static_cast<std::uint32_t>(std::stoul(argv[++i]));
        else
            scenes.push_back(argument);
    }
    std::puts(
        "scene,bodies,frames,parts,looks,cuts,uneven,ghosts_mean,ghosts_most,sources_mean,sources_"
        "most,"
        "bytes_mean,bytes_most");
    for (const std::string& scene : scenes) {
        using namespace pierce::scenes;
        if (scene.starts_with("lattice:")) {
            const auto count = static_cast<std::uint32_t>(std::stoul(scene.substr(8)));
            pierce::run(scene, lattice(count, frames, LatticeMotion::rigid), frames);
        } else {
            pierce::run(scene.substr(scene.find_last_of('/') + 1), read_recording(scene), frames);
        }
    }
}
