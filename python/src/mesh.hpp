#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <memory>
#include <string>

#include "pierce/mesh.hpp"

namespace pierce::python {

namespace nb = nanobind;

/// Vertices and triangles of a mesh as Python has it: an object with `vertices` and `faces`
/// (trimesh), with `points` and `cells_dict` (meshio), or a pair of arrays.
MeshData mesh_data_of(nb::handle given);

/// Copies of a mesh's vertices, float32 (n, 3), and triangles, uint32 (m, 3).
nb::tuple arrays_of(const MeshData& mesh);

/// How a mesh is made, from the arguments of a call. `progress`: called with what is made and its
/// share, or None; its place is given to `callback`.
MeshOptions mesh_options(nb::handle inside, const std::string& cache, std::uint32_t threads,
                         nb::handle progress, std::shared_ptr<nb::object>* callback = nullptr);

void bind_meshes(nb::module_& module);

}  // namespace pierce::python
