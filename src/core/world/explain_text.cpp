#include <cmath>
#include <cstdio>
#include <string>

#include "pierce/explain.hpp"

namespace pierce {
namespace {

std::string number(double value, int digits = 6) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

/// How a contact of two solids was found.
const char* how_found(Found found) {
    switch (found) {
        case Found::full:
            return ", found by a full ray";
        case Found::walk:
            return ", found by a walk from the last step's triangle";
        case Found::prediction:
            return ", found by a walk to a predicted triangle";
        case Found::separation:
            return ", measured along the direction in which the two separate soonest, as its body "
                   "is inside the other one as a whole, or the pair has no other contact with a "
                   "depth";
        case Found::self:
        case Found::near:
        case Found::crossing:
        case Found::remembered:
        case Found::tangled:
            break;
    }
    return "";  // what was found is said elsewhere
}

/// The sentence about the vertex of a sheet's contact.
std::string of_sheet(const Contact& c) {
    const std::string where = " triangle " + std::to_string(c.triangle);
    switch (c.found) {
        case Found::crossing:
            return "In contact: the vertex meets" + where + " in this step, at " + number(c.time) +
                   " of it, and ends " + number(std::fabs(c.distance)) +
                   (c.distance < 0 ? " behind it." : " in front of it.");
        case Found::remembered:
            return "In contact: the vertex went through" + where +
                   ", or one beside it, in an earlier step, and is " +
                   number(std::fabs(c.distance)) + " behind it.";
        default:
            return "In contact: the vertex is " + number(std::fabs(c.distance)) +
                   (c.distance < 0 ? " behind" : " in front of") + where +
                   ", closer than the thickness.";
    }
}

/// What contacts of solids say, and those of sheets.
std::string contact_text(const Explanation& e) {
    if (!e.contact) return "In contact: the vertex is inside and " + number(e.t) + " deep.";
    const Contact& c = *e.contact;
    if (c.of_sheet) return of_sheet(c);
    std::string s = c.distance > 0 ? "In contact: the vertex is outside, and " +
                                         number(c.distance) + " away, closer than the margin,"
                                   : "In contact: the vertex is inside and " +
                                         number(c.penetration_depth()) + " deep";
    s += " at triangle " + std::to_string(c.triangle) + how_found(c.found);
    if (c.reprojected && c.distance <= 0) s += ", then moved to the closest point";
    return s + ".";
}

std::string reason_text(const Explanation& e) {
    switch (e.reason) {
        case Reason::contact:
            return contact_text(e);
        case Reason::excluded:
            return "No contact: one of the bodies was left out of the step: it is not finite, or "
                   "its world is not active.";
        case Reason::filtered:
            return "No contact: the two bodies do not meet, by their filters, by the pair filter "
                   "or because the pair is excluded.";
        case Reason::both_fixed:
            return "No contact: two fixed bodies are no pair.";
        case Reason::boxes_apart:
            return e.distance > 0
                       ? "No contact: the bodies' boxes are " + number(e.distance) + " apart."
                       : "No contact: the bodies' boxes, each in its body's own directions, "
                         "do not overlap.";
        case Reason::open_target:
            return "No contact: the other body's mesh is open and has no inside.";
        case Reason::outside_box:
            return "No contact: the vertex is " + number(e.distance) +
                   " outside of the other body's box.";
        case Reason::outside_solid:
            return "No contact: the vertex is at least " + number(e.distance) +
                   " outside of the other body, by its clearance grid.";
        case Reason::no_direction:
            return "No contact: the triangles around the vertex cancel, so it has no inward "
                   "direction and no ray.";
        case Reason::entry_first:
            return "No contact: its ray first enters the other body, at " + number(e.t) +
                   " through triangle " + std::to_string(e.triangle) +
                   ", so the vertex is outside.";
        case Reason::nothing_ahead:
            return "No contact: its ray meets the other body nowhere, so the vertex is outside.";
        case Reason::not_inside_own:
            return "No contact by rule R2: the vertex is inside the other body, but its ray does "
                   "not start inside its own.";
        case Reason::own_exit_first:
            return "No contact by rule R3: the vertex is inside the other body, but its ray leaves "
                   "its own body at " +
                   number(e.own_exit) + ", before the other one at " + number(e.t) + ".";
        case Reason::beyond_range:
            return "No contact: the vertex is inside the other body, whose surface is " +
                   number(e.t) + " ahead, but an open body's rays end at " + number(e.own_exit) +
                   ".";
        case Reason::not_looked_for:
            return "No contact: the sheet is not looked for in itself by continuous tests.";
        case Reason::apart:
            return "No contact: the two have not met in this step, and the other surface is " +
                   number(e.distance) + " away, at triangle " + std::to_string(e.triangle) +
                   ", no less than the thickness.";
        case Reason::close_at_rest:
            return "No contact: the sheet's own surface is " + number(e.distance) +
                   " away, at triangle " + std::to_string(e.triangle) +
                   ", but no less than half of what it is at rest.";
        case Reason::beside:
            return "No contact: the other surface is " + number(e.distance) +
                   " away, at triangle " + std::to_string(e.triangle) +
                   ", but the vertex is over none of its triangles: an edge or a corner is close.";
        case Reason::no_triangle_names_it:
            return "No contact: the vertex is a corner of no triangle, so it is no part of its "
                   "body.";
        case Reason::not_looked_at:
            return "No contact in this step: the vertex is inside, but is not looked at before the "
                   "pair's next full pass.";
        case Reason::unexplained:
            return "No contact in this step, although the vertex is inside: the two disagree, "
                   "which is a defect of Pierce. Please report it with a saved world.";
    }
    return "";
}

}  // namespace

std::string Explanation::text() const {
    std::string s = reason_text(*this);
    if (certificate.kind != Certificate::none) {
        constexpr const char* who[] = {
            "", "the vertices of its patch are proved to stay outside",
            "the vertices of its patch that were not near are proved to stay outside",
            "it is proved to stay outside"};
        // What is left hangs on how often a body that stands still was looked at, by rounding.
        constexpr int few = 3;
        s += std::string(" No ray is needed until the bodies have moved by another ") +
             number(certificate.left, few) + ": " + who[certificate.kind] + ".";
    }
    return s;
}

}  // namespace pierce
