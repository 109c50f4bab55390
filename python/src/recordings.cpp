#include "recordings.hpp"

#include <nanobind/ndarray.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "arrays.hpp"
#include "mesh.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/inside.hpp"
#include "records.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/measure/validation.hpp"
#include "scenes/named/scene.hpp"
#include "scenes/recording/recording.hpp"
#include "scenes/simulate/simulation.hpp"
#include "settings.hpp"
#include "without_gil.hpp"
#include "world.hpp"

namespace pierce::python {
namespace {

using scenes::RecordedBody;
using scenes::Recording;

/// Bodies of a recording, put where they are frame by frame in a world of their own.
struct Replay {
    std::shared_ptr<Recording> recording;
    std::shared_ptr<scenes::Detector> detector;
    nb::object world;  ///< of a PyWorld; the same one always, since it keeps its filter
};

void make_replay(Replay* self, std::shared_ptr<Recording> recording, const std::string& backend,
                 int threads, nb::handle settings, const nb::kwargs& fields) {
    std::unique_ptr<Backend> made = backend_named(backend, threads);
    const bool on_device = made->runs_on_device();
    const Settings all = settings_from(settings, fields);
    std::shared_ptr<scenes::Detector> detector = [&] {
        const WithoutGil without_gil;
        return scenes::make_detector(scenes::scene_of(*recording), std::move(made), all);
    }();
    const std::shared_ptr<World> world(detector, detector->world());
    new (self) Replay{std::move(recording), std::move(detector),
                      nb::cast(std::make_shared<PyWorld>(world, on_device))};
}

nb::object step(Replay& replay, std::uint32_t frame) {
    if (frame >= replay.recording->frame_count)
        throw nb::index_error(("frame " + std::to_string(frame) + " of " +
                               std::to_string(replay.recording->frame_count))
                                  .c_str());
    {
        const Use world(world_in(replay.world));
        const WithoutGil without_gil;
        scenes::put_frame(*replay.detector, *replay.recording, frame);
    }
    return detect(nb::handle_t<PyWorld>(replay.world));
}

const RecordedBody& body_of(const Recording& recording, std::uint32_t body) {
    if (body >= recording.bodies.size())
        throw nb::index_error(
            ("body " + std::to_string(body) + " of " + std::to_string(recording.bodies.size()))
                .c_str());
    return recording.bodies[body];
}

/// The motion of a body: (frames, 7), or (frames, vertices, 3) if it deforms.
nb::object motion_of(nb::handle_t<Recording> self, std::uint32_t body) {
    const Recording& recording = nb::cast<const Recording&>(self);
    const RecordedBody& of = body_of(recording, body);
    if (!of.mesh_changes.empty())
        throw nb::value_error((of.name + ": its mesh changes, so its frames differ in size; "
                                         "positions() has those of one frame")
                                  .c_str());
    const bool deforms = of.motion == Motion::deforming;
    const std::size_t numbers = deforms ? 3 * recording.meshes[of.mesh].data.positions.size() : 7;
    const std::size_t frames = of.values.size() / numbers;
    const std::size_t shape[3] = {frames, deforms ? numbers / 3 : numbers, 3};
    return nb::cast(
        nb::ndarray<nb::numpy, const float>(of.values.data(), deforms ? 3 : 2, shape, self));
}

nb::object positions_in(nb::handle_t<Recording> self, std::uint32_t body, std::uint32_t frame) {
    const Recording& recording = nb::cast<const Recording&>(self);
    if (body_of(recording, body).motion != Motion::deforming || frame >= recording.frame_count)
        throw nb::index_error("positions: expected a deforming body and a frame of the recording");
    const std::span<const Vec3f> positions = recording.positions(body, frame);
    const std::size_t shape[2] = {positions.size(), 3};
    return nb::cast(nb::ndarray<nb::numpy, const float>(&positions.data()->x, 2, shape, self));
}

/// A recording from meshes, as (name, mesh), and bodies, as (name, place of the mesh, Motion,
/// motion as motion_of() has it, and maybe Collision and Filter).
void make_recording(Recording* self, double dt, nb::list meshes, nb::list bodies,
                    const std::vector<scenes::BodyPair>& excluded) {
    scenes::check_time_step(dt, "dt");
    Recording made;
    made.dt = dt;
    for (nb::handle mesh : meshes) {
        scenes::SceneMesh& kept = made.meshes.emplace_back();
        kept.name = nb::cast<std::string>(mesh[0]);
        kept.data = mesh_data_of(mesh[1]);
        if (kept.data.positions.empty() || kept.data.triangles.empty())
            throw InputError("mesh '" + kept.name + "' has no triangles");
        if (nb::isinstance<Mesh>(mesh[1]))
            kept.inside = rule_that_made(nb::cast<const Mesh&>(mesh[1]).inside());
    }
    if (nb::len(bodies) == 0) throw InputError("a recording has no bodies");
    const nb::object numpy = nb::module_::import_("numpy");
    for (nb::handle given : bodies) {
        RecordedBody body;
        body.name = nb::cast<std::string>(given[0]);
        body.mesh = nb::cast<std::uint32_t>(given[1]);
        if (body.mesh >= made.meshes.size())
            throw nb::index_error(
                (body.name + ": there is no mesh " + std::to_string(body.mesh)).c_str());
        body.motion = choice<Motion>(given[2], "motion");
        const nb::object numbers = numpy.attr("ascontiguousarray")(given[3], numpy.attr("float32"));
        const auto values = nb::cast<nb::ndarray<const float, nb::c_contig>>(numbers);
        const bool deforms = body.motion == Motion::deforming;
        const std::size_t vertices = made.meshes[body.mesh].data.positions.size();
        if (deforms ? values.ndim() != 3 || values.shape(1) != vertices || values.shape(2) != 3
                    : values.ndim() != 2 || values.shape(1) != 7)
            throw nb::value_error(
                (body.name + ": expected a motion of shape " +
                 (deforms ? "(frames, " + std::to_string(vertices) + ", 3)" : "(frames, 7)"))
                    .c_str());
        body.values.assign(values.data(), values.data() + values.size());
        const auto frames = static_cast<std::uint32_t>(values.shape(0));
        if (frames == 0) throw InputError(body.name + ": there are no frames");
        if (nb::len(given) > 4) body.collision = nb::cast<Collision>(given[4]);
        if (nb::len(given) > 5) body.filter = nb::cast<Filter>(given[5]);
        made.frame_count = std::max(made.frame_count, frames);
        made.bodies.push_back(std::move(body));
    }
    for (std::uint32_t b = 0; b < made.bodies.size(); ++b) {
        const RecordedBody& body = made.bodies[b];
        const std::size_t numbers = body.motion == Motion::deforming
                                        ? 3 * made.meshes[body.mesh].data.positions.size()
                                        : 7;
        const std::size_t frames = body.values.size() / numbers;
        if (frames != made.frame_count && !(frames == 1 && body.motion == Motion::fixed))
            throw nb::value_error((body.name + ": expected " + std::to_string(made.frame_count) +
                                   " frames, got " + std::to_string(frames))
                                      .c_str());
    }
    for (const auto& [a, b] : excluded) {
        if (a >= made.bodies.size() || b >= made.bodies.size() || a == b)
            throw InputError("bodies " + std::to_string(a) + " and " + std::to_string(b) +
                             " are no pair");
        made.excluded.insert(std::minmax(a, b));
    }
    new (self) Recording(std::move(made));
}

std::shared_ptr<Recording> simulate(const std::string& scene, std::uint32_t count, bool soft,
                                    std::uint32_t seed, double seconds, double dt,
                                    const std::string& method, int threads, nb::handle settings,
                                    const nb::kwargs& fields) {
    scenes::RaySettings rays;
    rays.threads = threads;
    rays.world = settings_from(settings, fields);
    scenes::check_time_step(dt, "dt");
    const WithoutGil without_gil;
    const scenes::SceneSetup setup = scenes::make_scene(
        scene, {.count = count, .soft = soft, .seed = seed});
    scenes::Simulation simulation(setup, scenes::method_named(method), rays);
    auto recording = std::make_shared<Recording>(scenes::start_recording(setup, dt));
    if (!(seconds > 0)) throw InputError("seconds must be positive");
    const double steps = std::max(1.0, seconds / dt + 0.5);
    if (!(steps < constants::max_elements)) throw InputError("seconds are too many time steps");
    const auto count_of_steps = static_cast<std::uint32_t>(steps);
    for (std::uint32_t k = 0; k < count_of_steps; ++k) {
        simulation.step(dt, *recording);
    }
    return recording;
}

scenes::Validation validate(const Recording& recording, const std::vector<std::string>& backends,
                            std::uint32_t every, int threads, nb::handle settings,
                            const nb::kwargs& fields) {
    const Settings all = settings_from(settings, fields);
    std::vector<scenes::Candidate> candidates;
    for (const std::string& name : backends)
        candidates.push_back({name, backend_named(name, threads)});
    const WithoutGil without_gil;
    return scenes::validate(recording, std::move(candidates), all, every);
}

void bind_recording(nb::module_& module) {
    nb::class_<Recording>(module, "Recording",
                          "The motion of bodies over time, which any method can be shown.")
        .def("__init__", make_recording, nb::arg("dt"), nb::arg("meshes"), nb::arg("bodies"),
             nb::arg("excluded") = std::vector<scenes::BodyPair>(),
             "`meshes`: (name, mesh) each; `bodies`: (name, place of the mesh, Motion, motion) "
             "each, and a Collision and a Filter if they are not the default. A motion is "
             "(frames, 7) poses, or (frames, vertices, 3) positions. `excluded`: pairs of places "
             "of bodies that do not meet. Raises InputError.")
        .def_prop_ro(
            "excluded",
            [](const Recording& recording) {
                return std::vector(recording.excluded.begin(), recording.excluded.end());
            },
            "Pairs of bodies that do not meet, each one's lower one first.")
        .def(
            "filter",
            [](const Recording& r, std::uint32_t body) { return body_of(r, body).filter; },
            nb::arg("body"), "A copy of a body's Filter.")
        .def_static(
            "read",
            [](const std::filesystem::path& folder) {
                const WithoutGil without_gil;
                return std::make_shared<Recording>(scenes::read_recording(folder));
            },
            nb::arg("folder"), "Reads a recording. Raises InputError for anything else.")
        .def(
            "write",
            [](const Recording& recording, const std::filesystem::path& folder) {
                const WithoutGil without_gil;
                scenes::write_recording(recording, folder);
            },
            nb::arg("folder"), "Writes it into a folder.")
        .def_ro("dt", &Recording::dt, "[s] from frame to frame")
        .def_ro("frame_count", &Recording::frame_count, "")
        .def_prop_ro(
            "body_names",
            [](const Recording& recording) {
                std::vector<std::string> names;
                for (const RecordedBody& body : recording.bodies) names.push_back(body.name);
                return names;
            },
            "In the order of bodies.")
        .def(
            "motion_kind",
            [](const Recording& r, std::uint32_t body) { return body_of(r, body).motion; },
            nb::arg("body"), "How a body moves.")
        .def("motion", motion_of, nb::arg("body"),
             nb::sig("def motion(self, body: int) -> numpy.typing.NDArray[numpy.float32]"),
             "float32 (frames, 7), or (frames, vertices, 3) if it deforms, without a copy; a body "
             "with one frame stays there.")
        .def("positions", positions_in, nb::arg("body"), nb::arg("frame"),
             nb::sig("def positions(self, body: int, frame: int) -> "
                     "numpy.typing.NDArray[numpy.float32]"),
             "Where a deforming body's vertices are, float32 (n, 3), without a copy.")
        .def(
            "mesh",
            [](const Recording& recording, std::uint32_t body, std::uint32_t frame) {
                body_of(recording, body);
                return arrays_of(recording.meshes[recording.mesh_of(body, frame)].data);
            },
            nb::arg("body"), nb::arg("frame") = 0,
            nb::sig("def mesh(self, body: int, frame: int = 0) -> "
                    "tuple[numpy.typing.NDArray[numpy.float32], "
                    "numpy.typing.NDArray[numpy.uint32]]"),
            "A copy of a body's (vertices, triangles).")
        .def("__repr__", [](const Recording& r) {
            return "<Recording of " + std::to_string(r.bodies.size()) + " bodies, " +
                   std::to_string(r.frame_count) + " frames of " + std::to_string(r.dt) + " s>";
        });
    nb::class_<Replay>(module, "Replay", nb::type_slots(HoldsWorld<Replay>::slots),
                       "A world whose bodies go where a recording has them.")
        .def("__init__", make_replay, nb::arg("recording"), nb::arg("backend") = "auto",
             nb::arg("threads") = 0, nb::arg("settings") = nb::none(), nb::arg("fields"),
             nb::sig("def __init__(self, recording: Recording, backend: str = 'auto', threads: int "
                     "= 0, settings: Settings | None = None, **fields: object) -> None"),
             "Arguments are those of World.")
        .def_prop_ro(
            "world", [](const Replay& r) { return r.world; }, nb::sig("def world(self) -> World"),
            "Its bodies are in the order of the recording.")
        .def("step", step, nb::arg("frame"), nb::sig("def step(self, frame: int) -> Contacts"),
             "Puts all bodies there; returns the contacts.")
        .def("__len__", [](const Replay& r) { return r.recording->frame_count; });
}

}  // namespace

void bind_recordings(nb::module_& module) {
    bind_recording(module);
    module.def(
        "scenes",
        [] {
            nb::dict all;
            for (const scenes::SceneInfo& info : scenes::scene_list())
                all[info.name.c_str()] = info.description;
            return all;
        },
        nb::sig("def scenes() -> dict[str, str]"), "The named scenes and what they are.");
    module.def(
        "simulate", simulate, nb::arg("scene"), nb::arg("count") = 100, nb::arg("soft") = false,
        nb::arg("seed") = 1, nb::arg("seconds") = 1.0, nb::arg("dt") = 1.0 / 60,
        nb::arg("method") = "rays", nb::arg("threads") = 0, nb::arg("settings") = nb::none(),
        nb::arg("fields"),
        nb::sig("def simulate(scene: str, count: int = 100, soft: bool = False, seed: int = 1, "
                "seconds: float = 1.0, dt: float = 1/60, method: str = 'rays', threads: int "
                "= 0, settings: Settings | None = None, **fields: object) -> Recording"),
        "Lets Bullet move a named scene with a method's contacts, and records it.");
    Record<scenes::Validation::Result>(module, "ValidationResult", "What a backend found.")
        .ro("name", &scenes::Validation::Result::name, "of the backend")
        .ro("description", &scenes::Validation::Result::description, "of the backend")
        .ro("contacts", &scenes::Validation::Result::contacts, "over all frames")
        .ro("wrong_frames", &scenes::Validation::Result::wrong_frames, "")
        .ro("wrong_contacts", &scenes::Validation::Result::wrong_contacts, "")
        .ro("near_ties", &scenes::Validation::Result::near_ties, "of the wrong ones")
        .ro("ms", &scenes::Validation::Result::ms, "[ms] per frame");
    Record<scenes::Validation>(module, "Validation", "Backends against each other.")
        .ro("results", &scenes::Validation::results, "one per backend")
        .ro("frames", &scenes::Validation::frames, "")
        .ro("differing_frames", &scenes::Validation::differing_frames,
            "frames in which not all lists are the same");
    module.def("validate", validate, nb::arg("recording"), nb::arg("backends"),
               nb::arg("every") = 1, nb::arg("threads") = 0, nb::arg("settings") = nb::none(),
               nb::arg("fields"),
               nb::sig("def validate(recording: Recording, backends: "
                       "collections.abc.Sequence[str], every: int = 1, threads: int = 0, settings: "
                       "Settings | None = None, **fields: object) -> Validation"),
               "Gives every so many frames to all backends, and decides by brute force which is "
               "right where they differ.");
}

}  // namespace pierce::python
