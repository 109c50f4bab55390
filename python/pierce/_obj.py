"""OBJ files, with every face and every group.

`read_mesh()` knows no groups.
Other readers leave out faces without three different corners, change the order of faces, or lose
the names of groups.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


class ObjFile:
    """What an OBJ file has: vertices, triangles of its polygons' fans, and their groups.

    names: "object/group", or the one that there is, of all groups with faces.
    group: of each triangle, its place in `names`, int64 (m,).
    Raises ValueError for a line that cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._default = path.stem
        self._group = ["", ""]
        self._places: dict[str, int] = {}
        points: list[list[float]] = []
        corners: list[tuple[int, int, int]] = []
        groups: list[int] = []
        with open(path, encoding="utf-8-sig", errors="replace") as lines:
            for number, line in enumerate(_joined(lines), 1):
                word, *rest = line.split() or [""]
                try:
                    if word == "v":
                        points.append([float(rest[0]), float(rest[1]), float(rest[2])])
                    elif word == "f":
                        fan = _fan(rest, len(points))
                        corners += fan
                        groups += [self._place()] * len(fan)
                except (IndexError, ValueError) as error:
                    raise ValueError(f"line {number} is no {word}: {line.strip()}") from error
                if word == "o":
                    self._group = [" ".join(rest), ""]
                elif word == "g":
                    self._group[1] = " ".join(rest)
        self.names = list(self._places)
        self.vertices: NDArray[np.float32] = np.array(points, np.float32).reshape(-1, 3)
        self.triangles: NDArray[np.uint32] = np.array(corners, np.uint32).reshape(-1, 3)
        self.group: NDArray[np.int64] = np.array(groups, np.int64)

    def _place(self) -> int:
        name = "/".join(filter(None, self._group)) or self._default
        return self._places.setdefault(name, len(self._places))


def _joined(lines: Iterable[str]) -> Iterator[str]:
    """Lines without comments, of which those that end in a backslash are joined to the next."""
    begun = ""
    for whole in lines:
        line = whole.split("#", 1)[0].rstrip()
        if line.endswith("\\"):
            begun += line[:-1] + " "
        else:
            yield begun + line
            begun = ""


def _fan(words: list[str], count: int) -> list[tuple[int, int, int]]:
    """Triangles of a polygon; a negative number counts back from the last vertex.

    Fewer than three corners have none.
    """
    corners = []
    for word in words:
        number = int(word.split("/", 1)[0])
        corner = number - 1 if number > 0 else count + number
        if not 0 <= corner or number == 0:
            raise ValueError(word)
        corners.append(corner)
    return [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]
