"""Series of deforming meshes from files: a file for each frame, or a cache of points.

series = pierce.series.read_series("out/cloth.pvd")
for seconds, positions in series:
    world.set_positions(body, positions)

series.recording(name="cloth").write("cloth")
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ._core import InputError, Motion, Recording
from .files import Part, Triangles, Vertices, read_parts, weld_places

__all__ = ["Series", "read_series"]


@dataclass(frozen=True, eq=False)
class Series:
    """One mesh whose vertices move from frame to frame.

    name: of the first file.
    triangles: uint32 (m, 3), the same in all frames.
    seconds: [s] when each frame is, float64 (frames,); whole numbers if the files do not say.
    Iterating reads frame after frame: (seconds, positions float32 (n, 3)).
    """

    name: str
    triangles: Triangles
    seconds: NDArray[np.float64]
    positions: Callable[[int], Vertices]
    """Reads the positions of a frame, float32 (n, 3)."""

    def __len__(self) -> int:
        return len(self.seconds)

    def __iter__(self) -> Iterator[tuple[float, Vertices]]:
        for frame, seconds in enumerate(self.seconds):
            yield float(seconds), self.positions(frame)

    @property
    def mesh(self) -> tuple[Vertices, Triangles]:
        """The first frame, as `World.add_mesh()` takes it."""
        return self.positions(0), self.triangles

    def recording(self, name: str | None = None, dt: float | None = None) -> Recording:
        """A recording of one deforming body.

        dt: [s] from frame to frame; None: as `seconds` say.
        Raises ValueError if these do not go on in equal steps.
        """
        if dt is None:
            steps = np.diff(self.seconds)
            if not len(steps) or steps.min() <= 0 or np.ptp(steps) > 1e-3 * steps.max():
                raise ValueError("the frames are not at equal steps of time: give dt")
            dt = float(steps.mean())
        motion = np.stack([positions for _, positions in self])
        title = name or self.name
        return Recording(dt, [(title, self.mesh)], [(title, 0, Motion.deforming, motion)])


def read_series(source: str | Path | Sequence[str | Path], weld: bool = False) -> Series:
    """Reads a series.

    source: a `.pvd` or `.series` file of ParaView, which lists files and times; a pattern such as
        "cloth_*.vtu", sorted by the numbers in the names, then by name; a list of files; or a
        cache of points, `.pc2` or `.mdd`, beside a mesh of the same name (OBJ, PLY, OFF, STL or
        GLB).
    weld: vertices at the same position in the first frame become one, in all frames.

    Files may be of any kind that `files.read_parts()` reads as one part.
    Raises InputError for what cannot be read, or has other triangles than the first frame.
    """
    if isinstance(source, (str, Path)):
        path = Path(source)
        if path.suffix.lower() in (".pc2", ".mdd"):
            series = _of_cache(path)
        elif path.suffix.lower() in (".pvd", ".series"):
            series = _of_files(*_listed(path))
        else:
            series = _of_files(_matching(path), None)
    else:
        series = _of_files([Path(each) for each in source], None)
    return _welded(series) if weld else series


def _listed(path: Path) -> tuple[list[Path], list[float]]:
    """Files and times of a list of ParaView's."""
    try:
        if path.suffix.lower() == ".pvd":
            entries = [
                (float(entry.get("timestep", place)), entry.attrib["file"])
                for place, entry in enumerate(ElementTree.parse(path).iter("DataSet"))
            ]
        else:
            listed = json.loads(path.read_text())["files"]
            entries = [(float(entry["time"]), entry["name"]) for entry in listed]
        for _, name in entries:
            if not isinstance(name, str):
                raise ValueError(f"a file's name is no text: {name!r}")
        if not all(math.isfinite(time) for time, _ in entries):
            raise ValueError("a time is not finite")
    except (OSError, ValueError, KeyError, TypeError, ElementTree.ParseError) as error:
        raise InputError(f"cannot read '{path}': {error}") from error
    seconds = [time for time, _ in entries]
    if len(set(seconds)) != len(seconds):
        raise InputError(f"'{path}' has several files for a time: a series is of one mesh")
    return [path.parent / name for _, name in entries], seconds


_NUMBER = re.compile(r"(?<![\d.])\d+\.\d+(?![\d.])|\d+")
"""A decimal number, or a whole one; of 1.2.3, three whole ones."""


def _matching(pattern: Path) -> list[Path]:
    found = list(pattern.parent.glob(pattern.name))
    if not found:
        raise InputError(f"no file matches '{pattern}'")
    return sorted(found, key=_order)


def _order(path: Path) -> tuple[list[float], str]:
    """By the numbers of the name, and where these are alike by the name."""
    return [float(number) for number in _NUMBER.findall(path.stem)], path.name


def _of_files(paths: list[Path], seconds: list[float] | None) -> Series:
    if not paths:
        raise InputError("a series needs a file")
    first = _read(paths[0])
    times = np.arange(len(paths)) if seconds is None else seconds

    def positions(frame: int) -> Vertices:
        part = _read(paths[frame]) if frame else first
        if part.vertices.shape != first.vertices.shape or not np.array_equal(
            part.triangles, first.triangles
        ):
            raise InputError(
                f"'{paths[frame]}' has other triangles than '{paths[0]}': "
                "the mesh of a series may not change"
            )
        return part.vertices

    return Series(paths[0].stem, first.triangles, np.array(times, np.float64), positions)


def _read(path: Path) -> Part:
    parts = read_parts(path)
    if len(parts) > 1:
        raise InputError(f"'{path}' has {len(parts)} meshes: a series is of one")
    return parts[0]


def _of_cache(path: Path) -> Series:
    """A cache of points beside the file of its mesh."""
    beside = [path.with_suffix(kind) for kind in (".obj", ".ply", ".off", ".stl", ".glb")]
    meshes = [file for file in beside if file.is_file()]
    if not meshes:
        raise InputError(f"beside '{path}' there is no mesh: {[file.name for file in beside]}")
    part = _read(meshes[0])
    try:
        seconds, points = (_read_pc2 if path.suffix.lower() == ".pc2" else _read_mdd)(path)
    except (OSError, ValueError, IndexError) as error:
        raise InputError(f"cannot read '{path}': {error}") from error
    if not np.isfinite(seconds).all():
        raise InputError(f"cannot read '{path}': a time is not finite")
    if points.shape[1] != len(part.vertices):
        raise InputError(
            f"'{path}' has {points.shape[1]} points, and '{meshes[0]}' has "
            f"{len(part.vertices)} vertices"
        )
    return Series(
        path.stem, part.triangles, seconds, lambda frame: points[frame].astype(np.float32)
    )


def _read_pc2(path: Path) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Times in frames, and points of a cache as Blender and 3ds Max write it."""
    numbers = [("version", "<i4"), ("points", "<i4"), ("start", "<f4"), ("rate", "<f4")]
    header = np.dtype([("sign", "S12"), *numbers, ("frames", "<i4")])
    data = path.read_bytes()
    head = np.frombuffer(data, header, 1)[0]
    if head["sign"] != b"POINTCACHE2":
        raise ValueError("it is no point cache")
    frames, count = int(head["frames"]), int(head["points"])
    _check_counts(frames, count)
    points = np.frombuffer(data, "<f4", frames * count * 3, header.itemsize)
    times = float(head["start"]) + float(head["rate"]) * np.arange(frames)
    return np.asarray(times, np.float64), points.reshape(frames, count, 3)


def _check_counts(frames: int, points: int) -> None:
    if frames < 1 or points < 1:
        raise ValueError(f"it says that it has {frames} frames of {points} points")


def _read_mdd(path: Path) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Seconds, and points of a cache as LightWave and Blender write it."""
    data = path.read_bytes()
    frames, count = map(int, np.frombuffer(data, ">i4", 2))
    _check_counts(frames, count)
    times = np.frombuffer(data, ">f4", frames, 8).astype(np.float64)
    points = np.frombuffer(data, ">f4", frames * count * 3, 8 + 4 * frames)
    return times, points.reshape(frames, count, 3)


def _welded(series: Series) -> Series:
    kept, joined = weld_places(series.positions(0))
    triangles = joined[series.triangles].astype(np.uint32)
    return Series(
        series.name, triangles, series.seconds, lambda frame: series.positions(frame)[kept]
    )
