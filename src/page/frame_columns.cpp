// The columns of a page, as src/page/web/data.js reads them.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <string>

#include "page/frame_store.hpp"

namespace pierce::page {
namespace {

using nlohmann::json;

/// Bytes of exact numbers of contacts and positions that a page holds before numbers are rounded.
constexpr double most_exact_bytes = 12e6;
/// The numbers of a contact, as float64.
constexpr const char* exact_names[] = {
    "distance",  "along",    "point_a_x", "point_a_y", "point_a_z", "point_b_x", "point_b_y",
    "point_b_z", "normal_x", "normal_y",  "normal_z",  "weight_0",  "weight_1",  "weight_2"};
/// The same in 16 bits each, without the distance, which is a float32 then.
constexpr const char* share_names[] = {"along", "time", "u", "v", "normal_u", "normal_v"};
constexpr double exact_contact_bytes = std::size(exact_names) * sizeof(double);
constexpr double steps_of_16_bits = 65535;
constexpr float nowhere = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint32_t no_mesh = 0xffffffffu;

// data.js has the names of Found, too.
static_assert(static_cast<int>(Found::separation) == 8);

constexpr const char* motion_names[] = {"fixed", "rigid", "deforming"};

/// A number from 0 to 1 in 16 bits.
std::uint16_t share(double value) {
    return static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, 1.0) * steps_of_16_bits));
}

/// A unit vector on an octahedron that is unfolded into a square: each coordinate in 16 bits
/// (Meyer et al., On Floating-Point Normal Vectors, 2010).
std::array<std::uint16_t, 2> unfolded(Vec3d n) {
    const double sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
    double x = n.x / sum, y = n.y / sum;
    if (n.z < 0) {
        const double before = x;
        x = std::copysign(1 - std::fabs(y), x);
        y = std::copysign(1 - std::fabs(before), y);
    }
    return {share(x / 2 + 0.5), share(y / 2 + 0.5)};
}

/// What a contact is besides numbers; data.js has the same bits.
std::uint8_t flags_of(const Contact& c) {
    unsigned flags = 0, bit = 1;
    for (bool is : {c.source == Side::b, c.grazing, c.reprojected, c.of_sheet, c.unknown_side}) {
        if (is) flags |= bit;
        bit <<= 1;
    }
    return static_cast<std::uint8_t>(flags);
}

/// An array that grows frame by frame.
template <class Number>
struct Column {
    std::vector<Number> numbers;

    void add(double value) { numbers.push_back(static_cast<Number>(value)); }
    void pack(PackedArrays& arrays, const std::string& name, std::size_t stride = 0) const {
        arrays.add(name, std::span<const Number>(numbers), stride);
    }
};

/// Two significant digits, so that few texts differ.
double shortened(double value) {
    if (value == 0 || !std::isfinite(value)) return value;
    const double unit = std::pow(10, std::floor(std::log10(std::fabs(value))) - 1);
    return std::round(value / unit) * unit;
}

}  // namespace

bool FrameStore::is_rounded() const {
    double bytes = 0;
    for (const Frame& frame : frames_) {
        bytes += exact_contact_bytes * static_cast<double>(frame.contacts.size());
        for (const Place& place : frame.places)
            bytes += sizeof(float) * static_cast<double>(place.numbers.size());
    }
    return bytes > most_exact_bytes;
}

void FrameStore::pack(PackedArrays& arrays, json& description) const {
    const bool rounded = is_rounded();
    description["rounded"] = rounded;
    description["frame_count"] = frames_.size();
    pack_meshes(arrays, description);
    pack_places(arrays, description, rounded);
    pack_contacts(arrays, rounded);
    pack_reasons(arrays, description, rounded);
}

void FrameStore::pack_meshes(PackedArrays& arrays, json& description) const {
    json list = json::array();
    for (std::size_t m = 0; m < meshes_.size(); ++m) {
        const MeshArrays& mesh = meshes_[m];
        const std::string number = std::to_string(m);
        list.push_back({{"name", mesh.name}, {"closed", mesh.closed}});
        arrays.add("mesh_vertices/" + number, std::span<const float>(mesh.vertices));
        arrays.add("mesh_triangles/" + number, std::span<const std::uint32_t>(mesh.triangles), 3);
        arrays.add("mesh_patches/" + number, std::span<const std::uint32_t>(mesh.patches));
    }
    description["meshes"] = list;
}

void FrameStore::pack_places(PackedArrays& arrays, json& description, bool rounded) const {
    const std::size_t count = bodies_.size();
    std::vector<std::uint32_t> mesh_of(frames_.size() * count, no_mesh);
    std::vector<std::uint8_t> left_out(frames_.size() * count, 0);
    std::vector<std::vector<float>> places(count);
    for (std::size_t f = 0; f < frames_.size(); ++f) {
        for (std::size_t b = 0; b < count; ++b)
            if (bodies_[b].motion != Motion::deforming) places[b].resize(7 * (f + 1), nowhere);
        for (const Place& place : frames_[f].places) {
            mesh_of[f * count + place.body] = place.mesh;
            left_out[f * count + place.body] = place.left_out;
            std::vector<float>& of_body = places[place.body];
            if (bodies_[place.body].motion == Motion::deforming)
                of_body.insert(of_body.end(), place.numbers.begin(), place.numbers.end());
            else
                std::ranges::copy(place.numbers, of_body.end() - 7);
        }
    }
    arrays.add("body_mesh", std::span<const std::uint32_t>(mesh_of), count);
    arrays.add("body_left_out", std::span<const std::uint8_t>(left_out), count);
    json list = json::array();
    for (std::size_t b = 0; b < count; ++b) {
        const Body& body = bodies_[b];
        json entry{{"name", body.name},
                   {"motion", motion_names[static_cast<int>(body.motion)]},
                   {"sheet", body.sheet}};
        const std::string name = "places/" + std::to_string(b);
        const std::span<const float> numbers(places[b]);
        if (body.motion != Motion::deforming) {
            arrays.add(name, numbers, 7);
        } else {
            std::size_t stride = 0;
            for (const Place& place : frames_.front().places)
                if (place.body == b) stride = place.numbers.size();
            if (rounded) {
                float lower = std::numeric_limits<float>::infinity(), upper = -lower;
                for (float n : numbers)
                    if (std::isfinite(n)) lower = std::min(lower, n), upper = std::max(upper, n);
                const double size = std::max(upper - lower, std::numeric_limits<float>::min());
                Column<std::uint16_t> column;
                for (float n : numbers) column.add(share((n - lower) / size));
                column.pack(arrays, name, stride);
                entry.update({{"lower", lower}, {"size", size}});
            } else {
                arrays.add(name, numbers, stride);
            }
        }
        list.push_back(entry);
    }
    description["bodies"] = list;
}

void FrameStore::pack_contacts(PackedArrays& arrays, bool rounded) const {
    Column<std::uint32_t> begin, a, b, vertex, edge_end, triangle, age;
    Column<std::uint8_t> flags, found;
    Column<double> exact[std::size(exact_names)];
    Column<float> distance;
    Column<std::uint16_t> shares[std::size(share_names)];
    begin.add(0);
    for (const Frame& frame : frames_) {
        for (const Contact& c : frame.contacts) {
            a.add(number(c.a));
            b.add(number(c.b));
            vertex.add(c.vertex);
            edge_end.add(c.is_edge() ? c.edge_end + 1.0 : 0);
            triangle.add(c.triangle);
            age.add(c.age);
            flags.add(flags_of(c));
            found.add(static_cast<double>(c.found));
            if (rounded) {
                distance.add(c.distance);
                const auto [u, v] = unfolded(c.normal);
                const std::uint16_t all[std::size(share_names)] = {share(c.along),
                                                                   share(c.time),
                                                                   share(c.barycentric[0]),
                                                                   share(c.barycentric[1]),
                                                                   u,
                                                                   v};
                for (std::size_t k = 0; k < std::size(all); ++k) shares[k].add(all[k]);
            } else {
                const Vec3d &p = c.point_a, &q = c.point_b, &n = c.normal;
                const double* w = c.barycentric;
                const double all[std::size(exact_names)] = {c.distance, c.along, p.x,  p.y, p.z,
                                                            q.x,        q.y,     q.z,  n.x, n.y,
                                                            n.z,        w[0],    w[1], w[2]};
                for (std::size_t k = 0; k < std::size(all); ++k) exact[k].add(all[k]);
            }
        }
        begin.add(static_cast<double>(a.numbers.size()));
    }
    begin.pack(arrays, "contact_begin", 1);
    a.pack(arrays, "contact_a", 1);
    b.pack(arrays, "contact_b", 1);
    vertex.pack(arrays, "contact_vertex", 1);
    edge_end.pack(arrays, "contact_edge_end");
    triangle.pack(arrays, "contact_triangle");
    age.pack(arrays, "contact_age");
    flags.pack(arrays, "contact_flags");
    found.pack(arrays, "contact_found");
    const auto pack_all = [&](const auto& columns, const auto& names) {
        for (std::size_t k = 0; k < std::size(names); ++k)
            columns[k].pack(arrays, std::string("contact_") + names[k]);
    };
    if (rounded) {
        distance.pack(arrays, "contact_distance");
        pack_all(shares, share_names);
    } else {
        pack_all(exact, exact_names);
    }
}

void FrameStore::pack_reasons(PackedArrays& arrays, json& description, bool rounded) const {
    Column<std::uint32_t> begin, body, vertex, other, text;
    std::unordered_map<std::string, std::size_t> numbers;
    json texts = json::array();
    begin.add(0);
    for (const Frame& frame : frames_) {
        for (const VertexReason& r : frame.reasons) {
            Explanation why = r.explanation;
            if (rounded)
                for (double* value : {&why.distance, &why.t, &why.own_exit, &why.certificate.left})
                    *value = shortened(*value);
            const auto [entry, is_new] = numbers.emplace(why.text(), texts.size());
            if (is_new) texts.push_back(entry->first);
            body.add(number(r.body));
            vertex.add(r.vertex);
            other.add(number(r.other));
            text.add(static_cast<double>(entry->second));
        }
        begin.add(static_cast<double>(body.numbers.size()));
    }
    begin.pack(arrays, "reason_begin", 1);
    body.pack(arrays, "reason_body", 1);
    vertex.pack(arrays, "reason_vertex", 1);
    other.pack(arrays, "reason_other", 1);
    text.pack(arrays, "reason_text");
    description["reason_texts"] = texts;
    description["has_all_reasons"] = has_all_reasons_;
}

}  // namespace pierce::page
