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

}  // namespace

std::string Explanation::text() const {
    std::string s;
    switch (reason) {
        case Reason::contact:
            if (contact && contact->of_sheet) return of_sheet(*contact);
            if (contact && contact->distance > 0)
                s = "In contact: the vertex is outside, and " + number(contact->distance) +
                    " away, closer than the margin,";
            else
                s = "In contact: the vertex is inside and " +
                    number(contact ? contact->penetration_depth() : t) + " deep";
            if (contact) {
                s += " at triangle " + std::to_string(contact->triangle);
                s += how_found(contact->found);
                if (contact->reprojected && contact->distance <= 0)
                    s += ", then moved to the closest point";
            }
            s += ".";
            break;
        case Reason::excluded:
            s = "No contact: one of the bodies was left out of the step: it is not finite, or its "
                "world is not active.";
            break;
        case Reason::filtered:
            s = "No contact: the two bodies do not meet, by their filters, by the pair filter or "
                "because the pair is excluded.";
            break;
        case Reason::both_fixed:
            s = "No contact: two fixed bodies are no pair.";
            break;
        case Reason::boxes_apart:
            s = distance > 0 ? "No contact: the bodies' boxes are " + number(distance) + " apart."
                             : "No contact: the bodies' boxes, each in its body's own directions, "
                               "do not overlap.";
            break;
        case Reason::open_target:
            s = "No contact: the other body's mesh is open and has no inside.";
            break;
        case Reason::outside_box:
            s = "No contact: the vertex is " + number(distance) +
                " outside of the other body's box.";
            break;
        case Reason::outside_solid:
            s = "No contact: the vertex is at least " + number(distance) +
                " outside of the other body, by its clearance grid.";
            break;
        case Reason::no_direction:
            s = "No contact: the triangles around the vertex cancel, so it has no inward direction "
                "and no ray.";
            break;
        case Reason::entry_first:
            s = "No contact: its ray first enters the other body, at " + number(t) +
                " through triangle " + std::to_string(triangle) + ", so the vertex is outside.";
            break;
        case Reason::nothing_ahead:
            s = "No contact: its ray meets the other body nowhere, so the vertex is outside.";
            break;
        case Reason::not_inside_own:
            s = "No contact by rule R2: the vertex is inside the other body, but its ray does not "
                "start inside its own.";
            break;
        case Reason::own_exit_first:
            s = "No contact by rule R3: the vertex is inside the other body, but its ray leaves "
                "its own body at " +
                number(own_exit) + ", before the other one at " + number(t) + ".";
            break;
        case Reason::beyond_range:
            s = "No contact: the vertex is inside the other body, whose surface is " + number(t) +
                " ahead, but an open body's rays end at " + number(own_exit) + ".";
            break;
        case Reason::not_looked_for:
            s = "No contact: the sheet is not looked for in itself by continuous tests.";
            break;
        case Reason::apart:
            s = "No contact: the two have not met in this step, and the other surface is " +
                number(distance) + " away, at triangle " + std::to_string(triangle) +
                ", no less than the thickness.";
            break;
        case Reason::close_at_rest:
            s = "No contact: the sheet's own surface is " + number(distance) +
                " away, at triangle " + std::to_string(triangle) +
                ", but no less than half of what it is at rest.";
            break;
        case Reason::beside:
            s = "No contact: the other surface is " + number(distance) + " away, at triangle " +
                std::to_string(triangle) +
                ", but the vertex is over none of its triangles: an edge or a corner is close.";
            break;
        case Reason::no_triangle_names_it:
            s = "No contact: the vertex is a corner of no triangle, so it is no part of its body.";
            break;
        case Reason::not_looked_at:
            s = "No contact in this step: the vertex is inside, but is not looked at before the "
                "pair's next full pass.";
            break;
        case Reason::unexplained:
            s = "No contact in this step, although the vertex is inside: the two disagree, which "
                "is a defect of Pierce. Please report it with a saved world.";
            break;
    }
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
