"""Recordings for ParaView: a `.pvd` file that lists a `.vtu` file or two for each frame.

recording = pierce.Recording.read("pile")
pierce.paraview.write_series("pile.pvd", recording, pierce.paraview.replay(recording))
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ._core import Contacts, Recording
from ._frames import check_writable, per_frame, surface
from ._frames import contacts_of as replay
from ._needs import need

__all__ = ["replay", "write_series"]

_INDEX = np.uint64(0xFFFFFFFF)
_COPIED = ("found", "source", "vertex", "edge_end", "triangle", "age", "distance", "time")
_FLAGS = ("of_sheet", "grazing", "reprojected", "unknown_side")
_VECTORS = ("normal", "face_normal", "point_a", "point_b")


def write_series(
    path: str | Path, recording: Recording, contacts: Iterable[Contacts] | None = None
) -> None:
    """Writes the surfaces of all bodies in each frame, and contacts.

    path: of the `.pvd` file; the others are in a folder of its name beside it.
    contacts: those of each frame, as `replay()` finds them; None: none are written.

    Of a surface's cells, `body` is the place of their body in `recording.body_names`, which are
    in `bodies.csv` in the folder, too.
    A contact is a point half way between its two points, with `normal`, `depth`, `distance`,
    `body_a`, `body_b`, `found` (a `Found`) and all else that a contact has.
    A body whose place is not finite is left out of that frame.
    meshio writes the files; ParaView shows surfaces as part 0 and contacts as part 1.

    Raises InputError for a name that no file may have, for contacts of too few frames, and for a
    recording without bodies.
    """
    meshio = need("meshio", "meshio", "writing for ParaView")
    path = Path(path)
    check_writable(recording, path, ".pvd")
    folder = path.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "bodies.csv", "w", newline="", encoding="utf-8") as names:
        rows = csv.writer(names, lineterminator="\n")
        rows.writerows([("body", "name"), *enumerate(recording.body_names)])
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    listed = ElementTree.SubElement(root, "Collection")
    steps = None if contacts is None else per_frame(recording, contacts)
    for frame in range(recording.frame_count):
        written = {"bodies": _bodies(meshio, recording, frame)}
        if steps is not None:
            written["contacts"] = _points(meshio, next(steps))
        for part, (kind, mesh) in enumerate(written.items()):
            file = folder / f"{kind}_{frame:06d}.vtu"
            mesh.write(file, binary=True)
            ElementTree.SubElement(
                listed,
                "DataSet",
                timestep=repr(frame * recording.dt),
                part=str(part),
                name=kind,
                file=f"{folder.name}/{file.name}",
            )
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _bodies(meshio: Any, recording: Recording, frame: int) -> Any:
    points, triangles, bodies, count = [np.empty((0, 3), np.float32)], [], [], 0
    for body in range(len(recording.body_names)):
        found = surface(recording, body, frame)
        if found is None:
            continue
        points.append(found[0])
        triangles.append(found[1].astype(np.int64) + count)
        bodies.append(np.full(len(found[1]), body, np.int32))
        count += len(found[0])
    if not bodies:
        return meshio.Mesh(np.zeros((1, 3), np.float32), [])
    return meshio.Mesh(
        np.concatenate(points),
        [("triangle", np.concatenate(triangles))],
        cell_data={"body": [np.concatenate(bodies)]},
    )


def _points(meshio: Any, contacts: Contacts) -> Any:
    records = contacts.records
    data: dict[str, Any] = {name: np.ascontiguousarray(records[name]) for name in _VECTORS}
    data |= {name: np.ascontiguousarray(records[name]) for name in _COPIED}
    data |= {name: records[name].astype(np.uint8) for name in _FLAGS}
    data |= {f"body_{side}": (records[side] & _INDEX).astype(np.uint32) for side in "ab"}
    data["depth"] = np.asarray(contacts.depth)
    points = (records["point_a"] + records["point_b"]) / 2
    cells = [("vertex", np.arange(len(points))[:, None])]
    return meshio.Mesh(points, cells, point_data=data)
