"""Files with cells, by meshio, and their triangles: surfaces, or the faces around volumes."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._needs import need

Indices = NDArray[np.int64]

# Faces of a volume cell, each with its corners as seen from outside, in VTK's order.
_FACES = {
    "tetra": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    "hexahedron": [
        [0, 3, 2, 1],
        [4, 5, 6, 7],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ],
}
_SURFACES = ("triangle", "quad", "polygon")
_NO_SURFACE = ("vertex", "line", "polyline")


def read_cells(path: Path) -> Any:
    """The meshio mesh of a file. Raises ValueError if no reader is for files of this kind."""
    kind = path.suffix.lower()
    meshio = need("meshio", "meshio", f"reading '{kind}'")
    # meshio.read() would end the program where it fails, and of ".msh" it tries Ansys first, whose
    # reader reads other files for ever.
    names = meshio.extension_to_filetypes.get(kind, [])
    reader = getattr(meshio, names[-1], None) if names else None
    if reader is None:
        raise ValueError(f"nothing reads files of the kind '{kind}'")
    return reader.read(str(path))


def triangles_of(cells: Iterable[Any]) -> tuple[Indices, bool]:
    """Triangles (m, 3) of blocks of cells, in their order, and whether they bound a volume.

    Polygons are cut into fans.
    If there are volumes, the triangles are those of the faces that only one volume cell has, and
    other cells do not count.
    Raises ValueError for kinds of cells that have curved sides or are unknown.
    """
    blocks = [block for block in cells if block.type not in _NO_SURFACE and len(block.data)]
    volumes = [block for block in blocks if block.type in _FACES]
    unknown = {block.type for block in blocks} - set(_SURFACES) - set(_FACES)
    if unknown:
        raise ValueError(
            f"cells of type {', '.join(sorted(unknown))} are not supported, only "
            f"{', '.join([*_SURFACES, *_FACES])}"
        )
    if volumes:
        return _outer_faces(volumes), True
    fans = [_fans(np.asarray(block.data, np.int64)) for block in blocks]
    return np.concatenate([np.empty((0, 3), np.int64), *fans]), False


def _fans(polygons: Indices) -> Indices:
    """Triangles of polygons (n, corners), in the polygons' order."""
    corners = range(1, polygons.shape[1] - 1)
    fans = np.stack([polygons[:, [0, k, k + 1]] for k in corners], 1)
    return fans.reshape(-1, 3)


def _outer_faces(volumes: Iterable[Any]) -> Indices:
    kinds: dict[int, list[Indices]] = {3: [], 4: []}
    for block in volumes:
        for corners in _FACES[block.type]:
            kinds[len(corners)].append(np.asarray(block.data, np.int64)[:, corners])
    outer = [np.empty((0, 3), np.int64)]
    for faces in filter(None, kinds.values()):
        every = np.concatenate(faces)
        _, first, count = np.unique(
            np.sort(every, 1), axis=0, return_index=True, return_counts=True
        )
        outer.append(_fans(every[np.sort(first[count == 1])]))
    return np.concatenate(outer)
