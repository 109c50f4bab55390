// Readers of mesh files: what people's programs write, and what none should.
#include "scenes/files/mesh_readers.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "pierce/error.hpp"

namespace pierce::scenes {
namespace {

using namespace std::string_literals;
using namespace std::string_view_literals;
using testing::HasSubstr;
using testing::ThrowsMessage;

using Reader = MeshData (*)(std::string_view);

MeshData tetrahedron() {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
            {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{2, 0, 3}}}};
}

void expect_tetrahedron(Reader reader, const std::string& content) {
    const MeshData mesh = reader(content), expected = tetrahedron();
    EXPECT_EQ(mesh.positions, expected.positions) << content;
    EXPECT_EQ(mesh.triangles, expected.triangles) << content;
}

void expect_refused(Reader reader, const std::string& content, const std::string& why) {
    EXPECT_THAT([&] { reader(content); }, ThrowsMessage<InputError>(HasSubstr(why))) << content;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    for (std::size_t at = text.find(what); at != std::string::npos;
         at = text.find(what, at + by.size()))
        text.replace(at, what.size(), by);
    return text;
}

const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

TEST(ObjReaderTest, ReadsWhatPeopleHave) {
    expect_tetrahedron(read_obj, obj);
    expect_tetrahedron(read_obj, "\xef\xbb\xbf" + obj);
    for (const char* end :
         {"\r\n", "\r", " \n", "\t\n", "\n\n", "\n# f 1 2 3\n", " # f 1 2\n", "#f 1 2\n",
          "\n# goes on? \\\n", "\nl 1 2\n", "\nvt 0.5\n", "\nvn 0 0 1\ng a b\ns 1\nusemtl f\n"})
        expect_tetrahedron(read_obj, replaced(obj, "\n", end));
    expect_tetrahedron(read_obj, replaced(obj, " ", "   "));
    expect_tetrahedron(read_obj, replaced(obj, " ", "\t"));
    expect_tetrahedron(read_obj, replaced(obj, " ", " \\\n "));
    expect_tetrahedron(read_obj, replaced(obj, " ", "\\\r\n "));
    expect_tetrahedron(read_obj, replaced(obj, " 1", " +1"));
    expect_tetrahedron(read_obj, replaced(obj, "v 1 0 0", "v 1.0e0 -0 .0 1 0.5 0.5 0.5"));
    for (const char* more : {"/1", "//2", "/1/2", "/"})
        expect_tetrahedron(
            read_obj, replaced(replaced(obj, "2 4", "2"s + more + " 4"), "f 2", "f 2"s + more));
    expect_tetrahedron(read_obj, obj.substr(0, obj.size() - 1));
    expect_tetrahedron(read_obj, replaced(obj, "f 1 3 2", "f -4 -2 -3"));
    expect_tetrahedron(read_obj, obj + "f 1 2\nf 1\nf\n");
    // Faces may come before their vertices.
    expect_tetrahedron(read_obj, obj.substr(32) + obj.substr(0, 32));
}

TEST(ObjReaderTest, CutsPolygonsIntoFans) {
    EXPECT_EQ(read_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 .5 0\nf 1 2 3 4 5\n").triangles,
              (std::vector<Triangle>{{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 4}}}));
}

TEST(ObjReaderTest, SaysWhichLineCannotBeRead) {
    expect_refused(read_obj, replaced(obj, "v 0 1 0", "v 0 1"), "line 3 is no vertex");
    expect_refused(read_obj, replaced(obj, "v 0 1 0", "v 0 x 0"), "line 3");
    expect_refused(read_obj, replaced(obj, "v 0 1 0", "v 0 1.2.3 0"), "line 3");
    expect_refused(read_obj, replaced(obj, "f 2 3 4", "f 2 3 four"), "line 7");
    expect_refused(read_obj, replaced(obj, "f 2 3 4", "f 2 3 0"), "line 7 names a vertex");
    expect_refused(read_obj, replaced(obj, "f 2 3 4", "f 2 3 -5"), "line 7 names a vertex");
    expect_refused(read_obj, replaced(obj, "f 2 3 4", "f 2 3 99999999999"), "line 7");
    expect_refused(read_obj, replaced(obj, "f 2 3 4", "f 2 3 99999999999999999999"), "line 7");
    expect_refused(read_obj, replaced(obj, "f 2 3 4", "f 2 3 4.5"), "line 7");
}

TEST(ObjReaderTest, HandsOnWhatAMeshRefuses) {
    const MeshData mesh = read_obj("v nan 1e60 -inf\nv 1e-400 -1e400 +1\nf 1 2 8\n");
    EXPECT_TRUE(std::isnan(mesh.positions[0].x));
    EXPECT_EQ(mesh.positions[0].y, std::numeric_limits<float>::infinity());
    EXPECT_EQ(mesh.positions[0].z, -std::numeric_limits<float>::infinity());
    EXPECT_EQ(mesh.positions[1], (Vec3f{0, -std::numeric_limits<float>::infinity(), 1}));
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{{0, 1, 7}}}));
}

const std::string
    off = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

TEST(OffReaderTest, ReadsWhatPeopleHave) {
    expect_tetrahedron(read_off, off);
    for (const char* end : {"\r\n", "\r", "\n\n", " # more\n", "\n # more\n", " \t\n"})
        expect_tetrahedron(read_off, replaced(off, "\n", end));
    expect_tetrahedron(read_off, "# made by hand\n" + off);
    expect_tetrahedron(read_off, replaced(off, "OFF\n", "OFF "));
    expect_tetrahedron(read_off, replaced(off, "4 4 6", "4 4"));
    expect_tetrahedron(read_off, replaced(off, "4 4 6", "4\n4 6"));
    expect_tetrahedron(read_off, replaced(off, "\n", " "));
    // Colours of faces: an index, three or four numbers.
    for (const char* color : {" 3", " 255 0 0", " 0.5 0.5 0.5 1"})
        expect_tetrahedron(
            read_off, replaced(replaced(replaced(replaced(off, "0 2 1", "0 2 1"s + color), "0 1 3",
                                                 "0 1 3"s + color),
                                        "1 2 3", "1 2 3"s + color),
                               "2 0 3", "2 0 3"s + color));
    std::string colored = replaced(off, "OFF", "COFF");
    for (const char* vertex : {"0 0 0", "1 0 0", "0 1 0", "0 0 1"})
        colored = replaced(colored, "\n"s + vertex + "\n", "\n"s + vertex + " 255 0 0 255\n");
    expect_tetrahedron(read_off, colored);
    expect_tetrahedron(read_off, replaced(colored, "COFF", "STCNOFF"));
}

TEST(OffReaderTest, SaysWhatCannotBeRead) {
    expect_refused(read_off, "4 4 6\n" + off.substr(10), "OFF");
    expect_refused(read_off, "4" + off, "three dimensions");
    expect_refused(read_off, replaced(off, "OFF\n", "OFF BINARY\n"), "binary");
    expect_refused(read_off, replaced(off, "4 4 6", "four 4 6"), "line 2");
    expect_refused(read_off, replaced(off, "4 4 6", "4 -4 6"), "line 2");
    expect_refused(read_off, replaced(off, "0 1 0\n", "0 1 up\n"), "line 5 is no vertex");
    expect_refused(read_off, replaced(off, "3 1 2 3", "3 1 2 -3"), "line 9 is no face");
    expect_refused(read_off, replaced(off, "3 1 2 3", "3 1 2 99999999999"), "line 9");
    expect_refused(read_off, replaced(off, "3 1 2 3", "4 1 2 3"), "line 9 is cut short");
    expect_refused(read_off, replaced(off, "3 2 0 3\n", ""), "cut short");
    expect_refused(read_off, replaced(off, "4 4 6", "4 18446744073709551615 6"), "cut short");
    expect_refused(read_off, replaced(off, "4 4 6", "4 3 6"), "line 10 is more");
    expect_refused(read_off, "OFF", "line 1");
    const std::string
        in_a_line = "OFF\n4 3 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3\n";
    expect_refused(read_off, in_a_line, "more than the header promises");
    expect_tetrahedron(read_off, replaced(in_a_line, "4 3 6", "4 4 6"));
}

std::string text_stl(const MeshData& mesh) {
    std::ostringstream text;
    text.precision(9);
    text << "solid a body\n";
    for (const Triangle& t : mesh.triangles) {
        text << "  facet normal 0 0 1\n    outer loop\n";
        for (std::uint32_t v : t.vertex)
            text << "      vertex " << mesh.positions[v].x << ' ' << mesh.positions[v].y << ' '
                 << mesh.positions[v].z << '\n';
        text << "    endloop\n  endfacet\n";
    }
    text << "endsolid a body\n";
    return text.str();
}

template <class T>
std::string bytes_of(T value, bool reversed = false) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    if (reversed) std::ranges::reverse(bytes);
    return bytes;
}

std::string binary_stl(const MeshData& mesh) {
    std::string bytes(80, '\0');
    bytes += bytes_of(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const Triangle& t : mesh.triangles) {
        for (float x : {0.f, 0.f, 1.f}) bytes += bytes_of(x);
        for (std::uint32_t v : t.vertex)
            for (int k = 0; k < 3; ++k) bytes += bytes_of(mesh.positions[v][k]);
        bytes += std::string(2, '\x7f');
    }
    return bytes;
}

/// With its vertices in the order in which triangles name them, as STL has them.
MeshData in_order_of_triangles(const MeshData& mesh) {
    MeshData ordered;
    for (const Triangle& t : mesh.triangles) {
        Triangle now;
        for (int k = 0; k < 3; ++k) {
            const Vec3f p = mesh.positions[t.vertex[k]];
            const auto known = std::ranges::find(ordered.positions, p);
            now.vertex[k] = static_cast<std::uint32_t>(known - ordered.positions.begin());
            if (known == ordered.positions.end()) ordered.positions.push_back(p);
        }
        ordered.triangles.push_back(now);
    }
    return ordered;
}

void expect_stl(const std::string& content) {
    const MeshData mesh = read_stl(content), expected = in_order_of_triangles(tetrahedron());
    EXPECT_EQ(mesh.positions, expected.positions) << content;
    EXPECT_EQ(mesh.triangles, expected.triangles) << content;
}

TEST(StlReaderTest, ReadsWhatPeopleHave) {
    const std::string text = text_stl(tetrahedron()), binary = binary_stl(tetrahedron());
    expect_stl(text);
    expect_stl("\xef\xbb\xbf" + text);
    expect_stl("\n  " + text);
    for (const char* end : {"\r\n", "\r", "\n\n"}) expect_stl(replaced(text, "\n", end));
    for (const char* name : {"", " facet normal vertex", " endsolid_of_it", " loop", " x\ty"})
        expect_stl(replaced(text, " a body", name));
    expect_stl(replaced(replaced(text, " a body", ""), "\n", " "));
    expect_stl(replaced(replaced(text, "solid a body\n", "solid a body "), "endsolid a body ",
                        "endsolid"));
    std::string upper = text;
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    expect_stl(upper);
    // Two solids, of which the second one is empty.
    expect_stl(text + "solid b\nendsolid b\n");
    expect_stl(binary);
    expect_stl(binary + "trailing");
    for (const std::string_view header :
         {"solid"sv, "solid made by a program\n facet normal 0 0"sv}) {
        std::string named = binary;
        std::ranges::copy(header, named.begin());
        expect_stl(named);
        expect_stl(named + "trailing");
    }
}

TEST(StlReaderTest, LeavesOutTrianglesWithTwoCornersInOnePlace) {
    MeshData mesh = tetrahedron();
    mesh.positions.push_back({-0.f, 0, 0});  // the same place as (0, 0, 0)
    mesh.triangles.insert(mesh.triangles.begin() + 1, {{{0, 4, 1}}});
    mesh.triangles[2] = {{4, 1, 3}};
    expect_stl(text_stl(mesh));
    expect_stl(binary_stl(mesh));
}

TEST(StlReaderTest, HandsOnWhatIsNotFinite) {
    MeshData mesh = tetrahedron();
    mesh.positions[2].y = std::numeric_limits<float>::quiet_NaN();
    for (const MeshData& read : {read_stl(text_stl(mesh)), read_stl(binary_stl(mesh))}) {
        EXPECT_EQ(read.triangles.size(), 4u);
        EXPECT_EQ(read.positions.size(), 4u);
        EXPECT_TRUE(std::isnan(read.positions[1].y));
    }
}

TEST(StlReaderTest, SaysWhatCannotBeRead) {
    const std::string text = text_stl(tetrahedron()), binary = binary_stl(tetrahedron());
    for (std::size_t end = 12; end < text.size() - sizeof "endsolid a body"; end += 13)
        EXPECT_THROW(read_stl(text.substr(0, end)), InputError) << text.substr(0, end);
    expect_refused(read_stl, text.substr(0, text.size() / 2), "cut short");
    expect_refused(read_stl, replaced(text, "vertex 1 0 0", "vertex 1 oops 0"), "is no vertex");
    expect_refused(read_stl, replaced(text, "outer loop", "outer ring"), "line 4");
    expect_refused(read_stl, binary.substr(0, binary.size() - 1), "it holds 3");
    expect_refused(read_stl, binary.substr(0, 50), "cut short");
    std::string less = binary;
    --less[80];
    expect_refused(read_stl, less, "promises 3 triangles, it holds 4");
    expect_refused(read_stl, "", "cut short");
}

TEST(PlyReaderTest, ReadsElementsAndPropertiesInAnyOrderAndOfAnyType) {
    const std::string seed_text = "seed 1";
    SCOPED_TRACE(seed_text);
    std::mt19937 engine(1);
    const auto below = [&](std::size_t count) { return engine() % count; };
    const std::array<const char*, 8> names[2] = {
        {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"},
        {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"}};
    const MeshData mesh = tetrahedron();
    for (int round = 0; round < 500; ++round) {
        const std::size_t format = below(3), alias = below(2);
        std::string header = "ply\n", body;
        const std::array formats = {"ascii"s, "binary_little_endian"s, "binary_big_endian"s};
        header += "format " + formats[format] + " 1.0\n";
        if (below(2)) header += "comment made by a test\nobj_info nothing\n";
        const auto put = [&](std::size_t type, double value) {
            const bool big = format == 2;
            if (format == 0)
                body += std::to_string(static_cast<int>(value)) + (below(4) ? " " : "\n");
            else if (type < 2)
                body += bytes_of(static_cast<std::int8_t>(value));
            else if (type < 4)
                body += bytes_of(static_cast<std::int16_t>(value), big);
            else if (type < 6)
                body += bytes_of(static_cast<std::int32_t>(value), big);
            else if (type == 6)
                body += bytes_of(static_cast<float>(value), big);
            else
                body += bytes_of(value, big);
        };
        const auto vertices = [&] {
            std::vector<int> order = {0, 1, 2, 3};  // the last one is no coordinate
            std::ranges::shuffle(order, engine);
            std::array<std::size_t, 4> type{};
            header += "element vertex 4\n";
            for (int k : order) {
                type[static_cast<std::size_t>(k)] = below(8);
                header += "property "s + names[alias][type[static_cast<std::size_t>(k)]] + " " +
                          std::array{"x", "y", "z", "quality"}[static_cast<std::size_t>(k)] + "\n";
            }
            for (const Vec3f& p : mesh.positions)
                for (int k : order)
                    put(type[static_cast<std::size_t>(k)], k < 3 ? static_cast<double>(p[k]) : 7);
        };
        const auto faces = [&] {
            const std::size_t length = below(6), type = below(8), flag = below(8);
            const bool first = below(2) != 0;
            header += "element face 4\n";
            const std::string more = "property "s + names[alias][flag] + " flags\n" +
                                     "property list uchar float texcoord\n";
            if (first) header += more;
            header += "property list "s + names[alias][length] + " " + names[alias][type] +
                      (below(2) ? " vertex_indices\n" : " vertex_index\n");
            if (!first) header += more;
            for (const Triangle& t : mesh.triangles) {
                const auto put_more = [&] {
                    put(flag, 3);
                    put(1, 2);
                    put(6, 1);
                    put(6, 2);
                };
                if (first) put_more();
                put(length, 3);
                for (std::uint32_t v : t.vertex) put(type, v);
                if (!first) put_more();
            }
        };
        const auto edges = [&] {
            header += "element edge 2\nproperty int vertex1\nproperty int vertex2\n";
            for (int k = 0; k < 4; ++k) put(4, k);
        };
        std::vector<int> order = {0, 1, 2};
        std::ranges::shuffle(order, engine);
        for (int k : order) k == 0 ? vertices() : k == 1 ? faces() : edges();
        header += "end_header\n";
        if (format == 0 && below(2)) header = replaced(header, "\n", "\r\n");
        expect_tetrahedron(read_ply, header + body);
    }
}

TEST(PlyReaderTest, SaysWhatCannotBeRead) {
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
        "0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    expect_tetrahedron(read_ply, ply);
    expect_refused(read_ply, "plywood", "begin with ply");
    expect_refused(read_ply, replaced(ply, "ascii", "morse"), "line 2");
    expect_refused(read_ply, replaced(ply, "float z", "quaternion z"), "line 6");
    expect_refused(read_ply, replaced(ply, "property float z\n", ""), "no z");
    expect_refused(read_ply, replaced(ply, "vertex 4", "vertex -4"), "line 3");
    expect_refused(read_ply, replaced(ply, "element vertex 4\n", ""), "line 3");
    expect_refused(read_ply, replaced(ply, "end_header", "the end"), "header");
    expect_refused(read_ply, replaced(ply, "0 1 0", "0 one 0"), "line 12");
    expect_refused(read_ply, replaced(ply, "3 2 0 3\n", "3 2 0"), "cut short");
    expect_refused(read_ply, replaced(ply, "3 2 0 3\n", "3 2 0 -3\n"), "names vertex -3");
    expect_refused(read_ply, replaced(ply, "3 2 0 3\n", "-3 2 0 3\n"), "no length");
    expect_refused(read_ply, replaced(ply, "face 4", "face 18446744073709551615"), "cut short");
    expect_refused(read_ply, replaced(ply, "vertex 4", "vertex 5"), "more");
    expect_refused(read_ply, replaced(ply, "face 4", "face 3"), "line 17 is more");
    const std::string point =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\n"
        "property uchar y\nproperty uchar z\nend_header\n"
        "\1\2\3";
    for (const std::string& end : {""s, "\n"s, "\r\n"s, "\0\0"s})
        EXPECT_EQ(read_ply(point + end).positions, std::vector<Vec3f>({{1, 2, 3}}));
    expect_refused(read_ply, point + "\1", "more than its header promises");
    // Nothing is held for elements that have nothing.
    expect_tetrahedron(
        read_ply, replaced(ply, "element face", "element air 18446744073709551615\nelement face"));
}

}  // namespace
}  // namespace pierce::scenes
