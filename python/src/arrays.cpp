#include "arrays.hpp"

#include <array>
#include <cmath>
#include <cstring>

#include "casters.hpp"

namespace pierce::python {
namespace {

std::string type_name(nb::dlpack::dtype type) {
    static constexpr std::array<const char*, 7> kinds = {"int",      "uint",    "float", "handle",
                                                         "bfloat16", "complex", "bool"};
    const std::string kind = type.code < kinds.size() ? kinds[type.code] : "unknown";
    return type.code == static_cast<std::uint8_t>(nb::dlpack::dtype_code::Bool)
               ? kind
               : kind + std::to_string(type.bits);
}

std::string shape_of(const Array& array) {
    std::string text = "(";
    for (std::size_t k = 0; k < array.ndim(); ++k)
        text += (k > 0 ? ", " : "") + std::to_string(array.shape(k));
    return text + (array.ndim() == 1 ? ",)" : ")");
}

bool is_in_c_order(const Array& array) {
    if (array.size() == 0) return true;
    std::int64_t stride = 1;
    for (std::size_t k = array.ndim(); k-- > 0;) {
        if (array.shape(k) > 1 && array.stride(k) != stride) return false;
        stride *= static_cast<std::int64_t>(array.shape(k));
    }
    return true;
}

/// True if a 4 x 4 matrix, row by row, turns and shifts and does nothing else, to the rounding of
/// float32, in which callers may have made it.
bool is_rigid(const double* m) {
    constexpr double rounding = 1e-5;
    const Vec3d row[3] = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}};
    bool rigid = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1;
    for (int r = 0; r < 3; ++r) {
        rigid = rigid && std::fabs(length(row[r]) - 1) < rounding;
        rigid = rigid && length(cross(row[r], row[(r + 1) % 3]) - row[(r + 2) % 3]) < rounding;
    }
    return rigid;
}

bool is_on_host(const Array& array) {
    return array.device_type() == nb::device::cpu::value ||
           array.device_type() == nb::device::cuda_host::value;
}

bool is_on_cuda(const Array& array) {
    return array.device_type() == nb::device::cuda::value ||
           array.device_type() == nb::device::cuda_managed::value;
}

/// What a CUDA array says of itself (version 3 of the protocol).
Array cuda_array_of(nb::handle given, const char* what) {
    const auto about = nb::cast<nb::dict>(given.attr("__cuda_array_interface__"));
    const auto type = nb::cast<std::string>(about["typestr"]);
    const auto data = nb::cast<nb::tuple>(about["data"]);
    const auto lengths = nb::cast<nb::tuple>(about["shape"]);
    const auto wrong = [&](const char* field) {
        return nb::value_error(
            (std::string(what) + ": __cuda_array_interface__ has a wrong '" + field + "'").c_str());
    };
    if (nb::len(data) != 2) throw wrong("data");
    if (about.contains("mask") && !about["mask"].is_none()) throw wrong("mask");
    const auto bytes = static_cast<std::int64_t>(type.size() == 3 ? type[2] - '0' : 0);
    const bool is_float = type == "<f4" || type == "<f8";
    if (!is_float && type != "<u8")
        throw nb::type_error((std::string(what) + ": CUDA arrays of '" + type +
                              "' are not read; float32, float64 and uint64 are")
                                 .c_str());
    std::vector<std::size_t> shape;
    std::vector<std::int64_t> strides(nb::len(lengths), 1);
    for (nb::handle length : lengths) shape.push_back(nb::cast<std::size_t>(length));
    for (std::size_t k = shape.size(); k-- > 1;)
        strides[k - 1] = strides[k] * static_cast<std::int64_t>(shape[k]);
    if (about.contains("strides") && !about["strides"].is_none()) {
        const auto given_strides = nb::cast<nb::tuple>(about["strides"]);
        if (nb::len(given_strides) != shape.size()) throw wrong("strides");
        for (std::size_t k = 0; k < shape.size(); ++k) {
            const auto in_bytes = nb::cast<std::int64_t>(given_strides[k]);
            if (in_bytes % bytes != 0) throw wrong("strides");
            strides[k] = in_bytes / bytes;
        }
    }
    // NOLINTNEXTLINE(performance-no-int-to-ptr): the protocol has addresses as numbers
    const auto* place = reinterpret_cast<const void*>(nb::cast<std::uintptr_t>(data[0]));
    const nb::dlpack::dtype number{
        static_cast<std::uint8_t>(is_float ? nb::dlpack::dtype_code::Float
                                           : nb::dlpack::dtype_code::UInt),
        static_cast<std::uint8_t>(8 * bytes), 1};
    return Array(place, shape.size(), shape.data(), given, strides.data(), number,
                 nb::device::cuda::value, 0);
}

/// True if an array was given. Buffers that leave their strides out, such as arrays of ctypes, are
/// read by NumPy: nanobind would read the strides.
bool is_array(nb::handle given, Array& array) {
    if (PyObject_CheckBuffer(given.ptr()) == 0) return nb::try_cast(given, array);
    Py_buffer view;
    if (PyObject_GetBuffer(given.ptr(), &view, PyBUF_FULL_RO) != 0) {
        PyErr_Clear();
        return nb::try_cast(given, array);
    }
    const bool has_strides = view.strides != nullptr || view.ndim == 0;
    PyBuffer_Release(&view);
    if (has_strides) return nb::try_cast(given, array);
    try {
        return nb::try_cast(nb::module_::import_("numpy").attr("asarray")(given), array);
    } catch (const nb::python_error&) {
        return false;
    }
}

}  // namespace

Array array_of(nb::handle given, const char* what) {
    Array array;
    if (is_array(given, array)) return array;
    if (nb::hasattr(given, "__cuda_array_interface__")) return cuda_array_of(given, what);
    throw nb::type_error((std::string(what) +
                          ": expected an array, with DLPack, the buffer protocol or "
                          "__cuda_array_interface__ and numbers in this machine's byte order, "
                          "got " +
                          nb::cast<std::string>(nb::str(given.type().attr("__name__"))) +
                          "; numpy.asarray(x, numpy.float32) makes one of numbers")
                             .c_str());
}

Rows rows_of(const Array& array, std::size_t columns, const char* what, bool allows_doubles) {
    const bool floats = array.dtype() == nb::dtype<float>(),
               doubles = array.dtype() == nb::dtype<double>();
    const bool has_shape = array.ndim() == 2 && array.shape(1) == columns;
    const std::string name(what);
    const std::string got = "got " + type_name(array.dtype()) + " of shape " + shape_of(array);
    if (!floats && !(doubles && allows_doubles))
        throw nb::type_error((name + ": expected float32" + (allows_doubles ? " or float64" : "") +
                              " of shape (n, " + std::to_string(columns) + "), " + got +
                              "; numpy.ascontiguousarray(x, numpy.float32) converts it")
                                 .c_str());
    if (!has_shape)
        throw nb::value_error(
            (name + ": expected shape (n, " + std::to_string(columns) + "), " + got).c_str());
    if (!is_in_c_order(array))
        throw nb::value_error((name +
                               ": expected rows that follow each other in memory (C order), " +
                               got + " with gaps; numpy.ascontiguousarray(x) copies it")
                                  .c_str());
    if (!is_on_host(array) && !is_on_cuda(array))
        throw nb::value_error(
            (name + ": expected an array of the host or of a CUDA device").c_str());
    return {.data = array.data(),
            .count = array.shape(0),
            .on_device = is_on_cuda(array),
            .doubles = doubles};
}

std::vector<BodyId> bodies_of(nb::handle given) {
    if (nb::isinstance<BodyId>(given)) return {nb::cast<BodyId>(given)};
    std::vector<BodyId> bodies;
    Array array;
    if (!nb::isinstance<nb::list>(given) && !nb::isinstance<nb::tuple>(given) &&
        is_array(given, array)) {
        if (array.dtype() != nb::dtype<std::uint64_t>() || array.ndim() != 1 ||
            !is_in_c_order(array) || !is_on_host(array))
            throw nb::type_error(
                ("bodies: expected uint64 of shape (n,) on the host, as ids() makes it, got " +
                 type_name(array.dtype()) + " of shape " + shape_of(array))
                    .c_str());
        bodies.resize(array.shape(0));
        // A handle as a number has its index in the lower half.
        static_assert(sizeof(BodyId) == sizeof(std::uint64_t));
        if (!bodies.empty())
            std::memcpy(bodies.data(), array.data(), bodies.size() * sizeof(BodyId));
        return bodies;
    }
    for (nb::handle item : given) {
        BodyId body;
        if (!nb::try_cast(item, body))
            throw nb::type_error(("bodies: expected BodyId, got " +
                                  nb::cast<std::string>(nb::str(item.type().attr("__name__"))))
                                     .c_str());
        bodies.push_back(body);
    }
    return bodies;
}

Pose pose_of(nb::handle given) {
    if (nb::isinstance<Pose>(given)) return nb::cast<Pose>(given);
    const nb::object numpy = nb::module_::import_("numpy");
    const nb::object as_array = numpy.attr("ascontiguousarray")(given, numpy.attr("float64"));
    const Array array = array_of(as_array, "pose");
    const auto* v = static_cast<const double*>(array.data());
    if (array.ndim() == 1 && array.shape(0) == 7)
        return {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
    if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4)
        throw nb::value_error(("pose: expected seven numbers (position, quaternion x y z w) or a "
                               "4 x 4 matrix, got shape " +
                               shape_of(array))
                                  .c_str());
    if (!is_rigid(v))
        throw nb::value_error(
            "pose: expected a 4 x 4 matrix of a rotation and a position, got one that scales, "
            "shears or mirrors");
    // The quaternion of a rotation matrix (Shepperd 1978), scaled by four times its largest part.
    const double m00 = v[0], m11 = v[5], m22 = v[10];
    Quaternion q{v[9] - v[6], v[2] - v[8], v[4] - v[1], 1 + m00 + m11 + m22};
    if (m00 > m11 && m00 > m22 && m00 > m00 + m11 + m22)
        q = {1 + m00 - m11 - m22, v[1] + v[4], v[2] + v[8], v[9] - v[6]};
    else if (m11 > m22 && m11 > m00 + m11 + m22)
        q = {v[1] + v[4], 1 - m00 + m11 - m22, v[6] + v[9], v[2] - v[8]};
    else if (m22 > m00 + m11 + m22)
        q = {v[2] + v[8], v[6] + v[9], 1 - m00 - m11 + m22, v[4] - v[1]};
    return {{v[3], v[7], v[11]}, q};
}

std::vector<Vec3f> positions_of(nb::handle given, const char* what) {
    const nb::object numpy = nb::module_::import_("numpy");
    const nb::object as_array = numpy.attr("ascontiguousarray")(given, numpy.attr("float32"));
    const auto rows = rows_of(array_of(as_array, what), 3, what, false).vectors();
    return {rows.begin(), rows.end()};
}

}  // namespace pierce::python
