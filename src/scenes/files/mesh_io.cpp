#include "scenes/files/mesh_io.hpp"

#include <fmt/os.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/IO/importer/ImporterT.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Utils/color_cast.hh>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <locale>
#include <sstream>

#include "core/base/whole_file.hpp"
#include "pierce/error.hpp"

namespace pierce::scenes {
namespace {

using Kernel = OpenMesh::PolyMesh_ArrayKernelT<>;

/// Collects what OpenMesh's readers read, unchanged from the file. OpenMesh's own meshes would drop
/// or split what is not manifold, and would renumber. It is the task of our mesh check to tell the
/// user about that.
class Collector : public OpenMesh::IO::ImporterT<Kernel> {
public:
    explicit Collector(Kernel& unused) : ImporterT(unused) {}

    using ImporterT::add_face;
    using ImporterT::add_vertex;

    OpenMesh::VertexHandle add_vertex(const OpenMesh::Vec3f& p) override {
        check(mesh.positions.size());
        mesh.positions.push_back({p[0], p[1], p[2]});
        return OpenMesh::VertexHandle(static_cast<int>(mesh.positions.size()) - 1);
    }

    OpenMesh::VertexHandle add_vertex(const OpenMesh::Vec3d& p) override {
        return add_vertex(OpenMesh::Vec3f(p));
    }

    OpenMesh::VertexHandle add_vertex() override { return add_vertex(OpenMesh::Vec3f(0, 0, 0)); }
    void set_point(OpenMesh::VertexHandle v, const OpenMesh::Vec3f& p) override {
        mesh.positions[static_cast<std::size_t>(v.idx())] = {p[0], p[1], p[2]};
    }

    OpenMesh::FaceHandle add_face(const VHandles& corners) override {
        check(mesh.triangles.size() + corners.size());
        for (std::size_t k = 2; k < corners.size(); ++k)
            mesh.triangles.push_back({{static_cast<std::uint32_t>(corners[0].idx()),
                                       static_cast<std::uint32_t>(corners[k - 1].idx()),
                                       static_cast<std::uint32_t>(corners[k].idx())}});
        return OpenMesh::FaceHandle(faces++);
    }

    void reserve(unsigned int vertices, unsigned int, unsigned int face_count) override {
        declared_vertices = vertices;
        declared_faces = face_count;
    }

    void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle,
                            const std::vector<OpenMesh::Vec2f>&) override {}
    void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle,
                            const std::vector<OpenMesh::Vec3f>&) override {}

    std::size_t n_vertices() const override { return mesh.positions.size(); }
    std::size_t n_faces() const override { return static_cast<std::size_t>(faces); }
    void prepare() override {}
    void finish() override {}

    MeshData mesh;
    std::uintmax_t most = 0;  ///< the most vertices, or triangles, of a file: its size in bytes
    int faces = 0;
    std::size_t declared_vertices = 0, declared_faces = 0;  ///< by the file's header, zero if it
                                                            ///< has none

private:
    /// Readers trust a header's counts, and go on past the end of the file.
    void check(std::size_t count) const {
        if (count >= most) throw std::runtime_error("it promises more than it holds");
    }
};

/// While an object of this type exists, OpenMesh prints no errors.
struct Silence {
    Silence() { omerr().disable(); }
    ~Silence() { omerr().enable(); }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;
};

/// Also reads what streams refuse: nan, inf, and a number that is too large for a float, which
/// becomes infinite.
class AnyNumber : public std::num_get<char> {
protected:
    iter_type do_get(iter_type in, iter_type end, std::ios_base&, std::ios_base::iostate& state,
                     float& value) const override {
        double number = 0;
        in = read(in, end, state, number);
        value = static_cast<float>(number);
        return in;
    }
    iter_type do_get(iter_type in, iter_type end, std::ios_base&, std::ios_base::iostate& state,
                     double& value) const override {
        return read(in, end, state, value);
    }

private:
    static iter_type read(iter_type in, iter_type end, std::ios_base::iostate& state,
                          double& value) {
        std::string text;
        while (in != end && (std::isalnum(static_cast<unsigned char>(*in)) || *in == '.' ||
                             *in == '-' || *in == '+'))
            text += *in++;
        if (in == end) state |= std::ios_base::eofbit;
        const char* first = text.data() + text.starts_with('+');
        const char* last = text.data() + text.size();
        const auto [stopped, error] = std::from_chars(first, last, value);
        if (error != std::errc() || stopped != last) state |= std::ios_base::failbit;
        return in;
    }
};

/// Throws InputError for an OBJ file with a vertex whose numbers cannot be read: OpenMesh would
/// leave the vertex out, and all later vertices would change their ids.
void check_obj_vertices(const std::filesystem::path& file, std::size_t vertices) {
    std::ifstream in(file);
    std::string line, word;
    std::size_t found = 0, number = 0;
    while (std::getline(in, line)) {
        ++number;
        std::istringstream words(line);
        if (!(words >> word) || word != "v") continue;
        double x, y, z;
        if (!(words >> x >> y >> z))
            throw InputError("cannot read '" + file.string() + "': line " + std::to_string(number) +
                             " is no vertex: " + line);
        ++found;
    }
    if (found > vertices)
        throw InputError("cannot read '" + file.string() +
                         "': " + std::to_string(found - vertices) + " vertices are beyond float32");
}

/// Throws std::runtime_error for a PLY header that would crash OpenMesh's reader, which trusts that
/// properties come after their element.
void check_ply_header(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string line;
    const auto refuse = [&] { throw std::runtime_error("its header is damaged: " + line); };
    bool in_element = false;
    if (!std::getline(in, line) || !line.starts_with("ply")) refuse();
    while (std::getline(in, line)) {
        std::istringstream words(line);
        std::string first, second, third;
        words >> first >> second >> third;
        if (first == "end_header") return;
        if (first == "comment" || first == "obj_info" || first.empty()) continue;
        if (first == "element") {
            std::uint64_t count = 0;
            const auto [end, error] = std::from_chars(third.data(), third.data() + third.size(),
                                                      count);
            if (error != std::errc() || end != third.data() + third.size()) refuse();
            in_element = true;
        } else if (first == "property") {
            if (!in_element || third.empty()) refuse();
        } else if (first != "format") {
            refuse();
        }
    }
    refuse();
}

/// True for a corner of an OBJ face: one to three whole numbers, of which those after the first may
/// be missing, with slashes between them.
bool is_obj_corner(const std::string& word) {
    const char *at = word.data(), *const end = at + word.size();
    for (int number = 0; number < 3; ++number) {
        std::int64_t value = 0;
        const auto [after, error] = std::from_chars(at, end, value);
        if (error == std::errc::result_out_of_range || (number == 0 && error != std::errc()))
            return false;
        at = after;
        if (at == end) return true;
        if (*at++ != '/') return false;
    }
    return false;
}

/// Throws std::runtime_error for an OBJ face that would crash OpenMesh's reader, which trusts that
/// corners are numbers.
void check_obj_faces(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line, word;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        std::istringstream words(line);
        if (!(words >> word) || word != "f") continue;
        while (words >> word && !word.starts_with('#'))
            if (!is_obj_corner(word))
                throw std::runtime_error("line " + std::to_string(number) + " is no face: " + line);
    }
}

}  // namespace

MeshData read_mesh(const std::filesystem::path& file) {
    const std::string name = "'" + file.string() + "'";
    if (!std::ifstream(file) || !std::filesystem::is_regular_file(file))
        throw InputError("cannot open " + name);
    const Silence silence;
    Kernel unused;
    Collector collector(unused);
    collector.most = std::filesystem::file_size(file);
    OpenMesh::IO::Options options;
    bool read = false, ran_out = false;
    std::string kind = file.extension().string();
    std::ranges::transform(kind, kind.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    try {
        if (kind == ".ply") check_ply_header(file);
        if (kind == ".obj") check_obj_faces(file);
        if (kind == ".off" || kind == ".ply") {
            // These readers know how much data there should be, but do not notice the end of the
            // file. The stream notices it.
            std::ifstream in(file, std::ios::binary);
            in.imbue(std::locale(in.getloc(), new AnyNumber));
            // Where there is nothing left to read, the readers would go on for ever, or for as long
            // as a number in the file says.
            in.exceptions(std::ios::failbit | std::ios::badbit);
            read = OpenMesh::IO::IOManager().read(in, kind.substr(1), collector, options);
            ran_out = in.fail();
        } else {
            read = OpenMesh::IO::IOManager().read(file.string(), collector, options);
        }
    } catch (const std::ios_base::failure&) {
        ran_out = true;
        read = collector.declared_vertices > 0;
    } catch (const std::exception& error) {
        throw InputError("cannot read " + name + ": " + error.what());
    }
    if (!read)
        throw InputError("cannot read " + name + ": not an OBJ, PLY, STL or OFF file, or damaged");
    if (kind == ".obj") check_obj_vertices(file, collector.mesh.positions.size());
    const bool cut_short = ran_out ||
                           collector.mesh.positions.size() < collector.declared_vertices ||
                           static_cast<std::size_t>(collector.faces) < collector.declared_faces;
    if (cut_short)
        throw InputError(name + " is cut short: its header promises " +
                         std::to_string(collector.declared_vertices) + " vertices and " +
                         std::to_string(collector.declared_faces) + " faces, it holds " +
                         std::to_string(collector.mesh.positions.size()) + " and " +
                         std::to_string(collector.faces));
    if (collector.mesh.triangles.empty()) throw InputError(name + " holds no triangles");
    return std::move(collector.mesh);
}

void write_obj(const std::filesystem::path& file, const MeshData& mesh) {
    try {
        WholeFile whole(file);
        auto out = fmt::output_file(whole.part().string());
        for (Vec3f p : mesh.positions) out.print("v {} {} {}\n", p.x, p.y, p.z);
        for (const Triangle& t : mesh.triangles)
            out.print("f {} {} {}\n", t.vertex[0] + 1, t.vertex[1] + 1, t.vertex[2] + 1);
        out.close();
        whole.keep();
    } catch (const std::system_error& error) {
        throw InputError("cannot write '" + file.string() + "': " + error.what());
    }
}

}  // namespace pierce::scenes
