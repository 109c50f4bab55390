#pragma once

#include <span>
#include <vector>

namespace pierce::app {

/// A point of a picture [pixels], y pointing down.
struct Spot {
    double x = 0, y = 0;
};

/// An upright rectangle of a picture, from its upper left to its lower right corner.
struct Area {
    Spot low, high;
};

/// True if two areas share more than their borders.
bool overlap(const Area& a, const Area& b);

/// True if a point of the line from `from` to `to` is inside `area`.
bool crosses(Spot from, Spot to, const Area& area);

/// A marker, and the size of the label that it is to have [pixels].
struct Marker {
    Spot at;
    double radius = 0;
    double width = 0, height = 0;

    /// What it covers.
    Area area() const { return {{at.x - radius, at.y - radius}, {at.x + radius, at.y + radius}}; }
};

/// Where a label stands; a thin line leads to one that is not beside its marker.
struct LabelPlace {
    Area box;
    bool led = false;
    Spot from = {}, to = {};  ///< the ends of the line: at the marker, and at the label
};

/// A place for each marker's label, near the marker. No label overlaps another one, a marker or a
/// `taken` area; all are within `frame`, unless there is no room. Lines avoid labels and markers of
/// others, and each other, where they can.
std::vector<LabelPlace> label_places(std::span<const Marker> markers, const Area& frame,
                                     std::span<const Area> taken = {});

}  // namespace pierce::app
