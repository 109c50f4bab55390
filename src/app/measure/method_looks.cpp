#include "app/measure/method_looks.hpp"

#include "pierce/error.hpp"

namespace pierce::app {
namespace {

// Told apart with any kind of colour vision: M. Okabe and K. Ito, Color Universal Design, 2002; and
// a grey. Two colours stand for one of our methods and for one of the others.
constexpr const char *black = "#000000", *orange = "#e69f00", *sky_blue = "#56b4e9",
                     *green = "#009e73", *yellow = "#f0e442", *blue = "#0072b2",
                     *vermilion = "#d55e00", *purple = "#cc79a7", *grey = "#999999";

constexpr MethodLook looks[] = {
    {"full", black, true},         {"walk", orange, true},        {"walk-predict", yellow, true},
    {"certified", sky_blue, true}, {"overlaps", vermilion, true}, {"complete", green, true},
    {"reprojected", purple, true}, {"gjk-hull", blue, false},     {"gjk-epa", sky_blue, false},
    {"gimpact", orange, false},    {"fcl", grey, false}};

}  // namespace

std::span<const MethodLook> method_looks() { return looks; }

const MethodLook& look_of_method(const std::string& name) {
    for (const MethodLook& look : looks)
        if (look.name == name) return look;
    throw InputError("method '" + name + "' has no colour");
}

}  // namespace pierce::app
