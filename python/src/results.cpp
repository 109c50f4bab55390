#include "results.hpp"

#include <string>

#include "pierce/body.hpp"
#include "pierce/contact.hpp"
#include "pierce/explain.hpp"
#include "pierce/filter.hpp"
#include "pierce/impact_contact.hpp"
#include "pierce/overlap.hpp"
#include "pierce/parting.hpp"
#include "pierce/plan.hpp"
#include "pierce/settings.hpp"
#include "pierce/step_stats.hpp"
#include "pierce/world.hpp"
#include "records.hpp"

namespace pierce::python {
namespace {

void bind_enumerations(nb::module_& module) {
    nb::enum_<Motion>(module, "Motion", "How a body moves.")
        .value("fixed", Motion::fixed, "never")
        .value("rigid", Motion::rigid, "by its pose")
        .value("deforming", Motion::deforming, "every vertex is given");
    nb::enum_<SelfCollision>(module, "SelfCollision",
                             "How contacts of a body with itself are found.")
        .value("off", SelfCollision::off, "not at all")
        .value("on", SelfCollision::on,
               "of a solid where it is inside itself, of a sheet by "
               "continuous tests")
        .value("rays", SelfCollision::rays, "of a sheet by rays along relative velocities")
        .value("published", SelfCollision::published, "of a sheet as the paper prints it");
    nb::enum_<Coverage>(module, "Coverage", "Which parts of a body are looked for inside others.")
        .value("vertices", Coverage::vertices, "its vertices")
        .value("complete", Coverage::complete, "all its edges, too")
        .value("overlaps", Coverage::overlaps, "edges where no vertex shows a way out");
    nb::enum_<Temporal>(module, "Temporal", "How the last step's results are used.")
        .value("off", Temporal::off, "not at all")
        .value("paper", Temporal::paper, "as in the paper")
        .value("certified", Temporal::certified, "where a proof spares a ray");
    nb::enum_<Found>(module, "Found", nb::is_arithmetic(), "How a contact was found.")
        .value("full", Found::full, "by a ray")
        .value("walk", Found::walk, "from the last step's triangle")
        .value("prediction", Found::prediction, "from a predicted triangle")
        .value("self", Found::self, "of a body inside itself")
        .value("near", Found::near, "apart, and closer than the margin or thickness")
        .value("crossing", Found::crossing, "of a sheet: the two meet during the step")
        .value("remembered", Found::remembered, "of a sheet: they met earlier")
        .value("tangled", Found::tangled, "of a sheet: it is unknown when they met")
        .value("separation", Found::separation, "along the way in which the two part soonest");
    nb::enum_<Side>(module, "Side", nb::is_arithmetic(),
                    "Which of a contact's bodies has the vertex.")
        .value("a", Side::a)
        .value("b", Side::b);
    nb::enum_<Reason>(module, "Reason", "Why a vertex has a contact with another body, or none.")
        .value("contact", Reason::contact)
        .value("excluded", Reason::excluded)
        .value("filtered", Reason::filtered)
        .value("both_fixed", Reason::both_fixed)
        .value("boxes_apart", Reason::boxes_apart)
        .value("open_target", Reason::open_target)
        .value("outside_box", Reason::outside_box)
        .value("outside_solid", Reason::outside_solid)
        .value("no_direction", Reason::no_direction)
        .value("entry_first", Reason::entry_first)
        .value("nothing_ahead", Reason::nothing_ahead)
        .value("not_inside_own", Reason::not_inside_own)
        .value("own_exit_first", Reason::own_exit_first)
        .value("beyond_range", Reason::beyond_range)
        .value("no_triangle_names_it", Reason::no_triangle_names_it)
        .value("unexplained", Reason::unexplained)
        .value("not_looked_at", Reason::not_looked_at)
        .value("not_looked_for", Reason::not_looked_for)
        .value("apart", Reason::apart)
        .value("close_at_rest", Reason::close_at_rest)
        .value("beside", Reason::beside);
    nb::enum_<Certificate::Kind>(module, "CertificateKind", "What was proved to be outside.")
        .value("none", Certificate::none, "nothing")
        .value("patch", Certificate::patch, "the vertex's whole patch")
        .value("patch_rest", Certificate::patch_rest, "those of the patch that were not near")
        .value("vertex", Certificate::vertex, "the vertex itself");
}

void bind_inputs(nb::module_& module) {
    Record<Settings>(module, "Settings", "How a world detects contacts; every field has a default.")
        .rw("open_body_range", &Settings::open_body_range,
            "[mean edge length] how far rays of bodies without an inside reach; how deep sheets "
            "remember what has gone through")
        .rw("coverage", &Settings::coverage, "Coverage, or its name")
        .rw("reproject", &Settings::reproject, "contacts end at the closest point")
        .rw("margin", &Settings::margin, "[length] solids nearer than this are in contact, too")
        .rw("temporal", &Settings::temporal, "Temporal, or its name")
        .rw("may_rest", &Settings::may_rest, "memory rests where it does not pay")
        .rw("predict", &Settings::predict, "of Temporal.paper: look ahead")
        .rw("prediction_distance", &Settings::prediction_distance, "[length]; negative: as needed")
        .rw("full_every", &Settings::full_every, "of Temporal.paper: steps between full passes")
        .rw("walk_threshold", &Settings::walk_threshold, "[mean edge length] of Temporal.paper")
        .with_init();
    module.def(
        "vertex_rays", [] { return vertex_rays; },
        "Settings of the paper's method: rays of vertices alone, contacts at their ends.");
    Record<Collision>(module, "Collision", "What a body is in contact with besides solids.")
        .rw("self", &Collision::self, "SelfCollision, or its name")
        .rw("sheet", &Collision::sheet, "the body is a sheet, without an inside")
        .rw("thickness", &Collision::thickness, "[length] of a sheet")
        .rw("margin", &Collision::margin, "[length] negative: that of the settings")
        .with_init();
    Record<Filter>(module, "Filter", "Which other bodies a body meets.")
        .rw("groups", &Filter::groups, "a bit for each group that the body is in")
        .rw("meets", &Filter::meets, "a bit for each group whose bodies it meets")
        .rw("chain", &Filter::chain, "bodies of one chain do not meet; 0: of none")
        .rw("world", &Filter::world, "bodies of different worlds do not meet; all_worlds: in all")
        .with_init()
        .bound()
        .def("allows", &Filter::allows, nb::arg("other"), "True if the two may be a pair.");
    Record<Pose>(module, "Pose", "Places a rigid body.")
        .get(
            "position", [](const Pose& p) { return p.position; }, "[length] x, y, z")
        .get(
            "rotation",
            [](const Pose& p) {
                return nb::make_tuple(p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w);
            },
            "quaternion x, y, z, w of any length but zero",
            "def rotation(self) -> tuple[float, float, float, float]");
}

void bind_plan_and_stats(nb::module_& module) {
    Record<PlannedPart>(module, "PlannedPart", "What one of the backends that share a world does.")
        .ro("backend", &PlannedPart::backend, "for people")
        .ro("on_device", &PlannedPart::on_device, "it runs on a GPU")
        .ro("share", &PlannedPart::share, "of the work, as was asked for")
        .ro("bodies", &PlannedPart::bodies, "that it owned in the last step")
        .ro("ghosts", &PlannedPart::ghosts, "bodies of other parts that were near")
        .ro("triangles", &PlannedPart::triangles, "of both");
    Record<Plan>(module, "Plan", "What a world's bodies require of a step.")
        .ro("revision", &Plan::revision, "changes with every new plan")
        .ro("fixed_bodies", &Plan::fixed_bodies, "")
        .ro("rigid_bodies", &Plan::rigid_bodies, "")
        .ro("deforming_bodies", &Plan::deforming_bodies, "")
        .ro("open_bodies", &Plan::open_bodies, "without an inside: sources only")
        .ro("worlds", &Plan::worlds, "different ones, without all_worlds")
        .ro("excluded_pairs", &Plan::excluded_pairs, "by exclude()")
        .ro("settings", &Plan::settings, "in effect: what no body needs is off")
        .ro("notes", &Plan::notes, "rules that do not apply to some body, and why")
        .ro("parts", &Plan::parts, "what runs where; empty if one backend does all")
        .get(
            "stages",
            [](const Plan& plan) {
                std::vector<std::string> names;
                for (StageId stage : plan.stages) names.emplace_back(name_of(stage));
                return names;
            },
            "the stages that run, in their order");
    Record<StepStats> stats(module, "StepStats", "How long one step took and what it found.");
    stats
        .get(
            "stages",
            [](const StepStats& s) {
                nb::dict times;
                for (const StageTime& time : s.stages)
                    times[name_of(time.stage)] = time.milliseconds;
                return times;
            },
            "[ms] of the stages that ran, in their order", "def stages(self) -> dict[str, float]")
        .ro("milliseconds", &StepStats::milliseconds, "[ms] the whole step")
        .ro("device_milliseconds", &StepStats::device_milliseconds, "[ms] of it on a GPU")
        .ro("part_milliseconds", &StepStats::part_milliseconds, "[ms] of each part's own step")
        .ro("at_rest", &StepStats::at_rest, "nothing had changed: counts are the last step's")
        .ro("status", &StepStats::status, "0, or 1 if a body was left out")
        .ro("penetration_mean", &StepStats::penetration_mean, "[length] over the contacts")
        .ro("penetration_max", &StepStats::penetration_max, "[length] over the contacts");
    const auto count = [&](const char* name, auto member, const char* doc = "") {
        stats.ro(name, member, doc);
    };
    count("excluded_bodies", &StepStats::excluded_bodies, "whose places could not be used");
    count("pairs", &StepStats::pairs, "bodies whose boxes overlap");
    count("touching_pairs", &StepStats::touching_pairs, "pairs with a contact");
    count("contacts", &StepStats::contacts);
    count("rays", &StepStats::rays, "full rays");
    count("hits", &StepStats::hits, "full rays, walks and looks that meet the other body");
    count("certified", &StepStats::certified, "vertices that needed no ray");
    count("looks", &StepStats::looks, "vertices found inside by a look");
    count("walks", &StepStats::walks);
    count("walk_steps", &StepStats::walk_steps);
    count("lost_walks", &StepStats::lost_walks);
    count("full_passes", &StepStats::full_passes);
    count("predictions", &StepStats::predictions);
    count("predictions_true", &StepStats::predictions_true);
    count("proofs", &StepStats::proofs);
    count("rested", &StepStats::rested, "1 if nothing was remembered as that would not pay");
    count("edges", &StepStats::edges, "near the other body of a pair");
    count("chords", &StepStats::chords, "parts of edges inside the other body");
    count("edge_contacts", &StepStats::edge_contacts);
    count("inside_tests", &StepStats::inside_tests);
    count("separated_pairs", &StepStats::separated_pairs);
    count("reprojected", &StepStats::reprojected, "contacts moved to a closer point");
    count("self_contacts", &StepStats::self_contacts);
    count("triangle_pairs", &StepStats::triangle_pairs);
    count("feature_pairs", &StepStats::feature_pairs);
    count("crossings", &StepStats::crossings);
    count("remembered", &StepStats::remembered);
    count("tangled", &StepStats::tangled);
    count("own_rays", &StepStats::own_rays);
    count("refits", &StepStats::refits);
    count("rebuilds", &StepStats::rebuilds);
    count("triangle_tests", &StepStats::triangle_tests);
}

void bind_answers(nb::module_& module) {
    Record<Certificate>(module, "Certificate", "A proof that a vertex stays outside for a while.")
        .ro("kind", &Certificate::kind, "what was proved to be outside")
        .ro("left", &Certificate::left, "[length] how far the bodies may still move");
    Record<Parting>(module, "Parting", "A way to take two bodies apart without a turn.")
        .ro("direction", &Parting::direction, "unit: where body b goes")
        .ro("depth", &Parting::depth, "[length] how far")
        .get(
            "translation", [](const Parting& p) { return p.translation(); }, "[length] of body b");
    Record<ContactPatch>(module, "ContactPatch", "Places that overlap along one direction.")
        .ro("area", &ContactPatch::area, "[length^2]")
        .ro("depth_volume", &ContactPatch::depth_volume, "[length^3] depth over the area")
        .ro("center", &ContactPatch::center, "the middle of the area")
        .ro("normal", &ContactPatch::normal, "unit, from a to b")
        .ro("depth", &ContactPatch::depth, "[length] of the deepest place looked at")
        .ro("deepest", &ContactPatch::deepest, "where that is");
    Record<Overlap>(module, "Overlap", "What two solids have in common.")
        .ro("volume", &Overlap::volume, "[length^3]")
        .ro("center", &Overlap::center, "the middle of the volume")
        .ro("area_a", &Overlap::area_a, "[length^2] of a's surface inside b")
        .ro("area_b", &Overlap::area_b, "[length^2] of b's surface inside a")
        .ro("push", &Overlap::push, "[length^2] how the volume shrinks when b moves")
        .ro("turn", &Overlap::turn, "[length^3] the same for turns about `center`")
        .ro("patches", &Overlap::patches, "the deepest first");
    Record<ImpactContact>(module, "ImpactContact", "Where and when two solids first meet.")
        .ro("a", &ImpactContact::a, "the body in the lower slot")
        .ro("b", &ImpactContact::b, "the other one")
        .ro("time", &ImpactContact::time, "of the step, 0 to 1")
        .ro("point", &ImpactContact::point, "world space, at that time")
        .ro("normal", &ImpactContact::normal, "unit, from a to b")
        .ro("gap", &ImpactContact::gap, "[length] along the normal as the step begins")
        .ro("start_a", &ImpactContact::start_a, "where what meets is then, on a")
        .ro("start_b", &ImpactContact::start_b, "on b")
        .ro("edges", &ImpactContact::edges, "two edges meet; else a vertex and a face")
        .ro("source", &ImpactContact::source, "the body of the vertex")
        .ro("vertex", &ImpactContact::vertex, "of the source, or the first one of its edge")
        .ro("edge_end", &ImpactContact::edge_end, "the second one of its edge")
        .ro("triangle", &ImpactContact::triangle, "of the other body");
    Record<RayHit>(module, "RayHit", "Where a line of sight first meets a body.")
        .ro("body", &RayHit::body, "")
        .ro("triangle", &RayHit::triangle, "")
        .ro("t", &RayHit::t, "[length] along the direction")
        .ro("normal", &RayHit::normal, "of the triangle, unit");
    Record<ProbeContact>(module, "ProbeContact", "What is pressed against a point of a sensor.")
        .ro("body", &ProbeContact::body, "")
        .ro("triangle", &ProbeContact::triangle, "")
        .ro("distance", &ProbeContact::distance, "[length] negative where the body is pressed in")
        .ro("normal", &ProbeContact::normal, "of the triangle, unit, outward");
    Record<WorldOffsets>(module, "WorldOffsets", "Which contacts are of which world.")
        .ro("worlds", &WorldOffsets::worlds, "their numbers, sorted")
        .ro("solids", &WorldOffsets::solids,
            "where each one's contacts of solids begin, and the end")
        .ro("sheets", &WorldOffsets::sheets, "the same of sheets");
    Record<World::BodyBox>(module, "BodyBox", "A body and the box it stands in.")
        .ro("body", &World::BodyBox::body, "")
        .get(
            "lower", [](const World::BodyBox& b) { return b.box.lower; }, "corner of the box")
        .get(
            "upper", [](const World::BodyBox& b) { return b.box.upper; }, "the other corner");
}

}  // namespace

void bind_results(nb::module_& module) {
    bind_enumerations(module);
    bind_inputs(module);
    bind_plan_and_stats(module);
    bind_answers(module);
}

}  // namespace pierce::python
