"""What a URDF file says of links, joints and shapes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from ._core import InputError

Floats = NDArray[np.float64]

MOVING = ("revolute", "continuous", "prismatic")
STIFF = ("floating", "planar")
"""Joints that could move, but stay at rest."""

_SHAPES = {
    "collision": ("collision",),
    "visual": ("visual",),
    "all": ("collision", "visual"),
}
_SIZES = {"box": {"size": 3}, "sphere": {"radius": 1}, "cylinder": {"radius": 1, "length": 1}}


@dataclass(frozen=True, eq=False)
class UrdfShape:
    """A collision or a visual.

    name: in the file, or the link's and a number.
    origin: in the link's frame, a matrix (4, 4).
    kind: "mesh", "box", "sphere", "cylinder", or whatever else the file has.
    size: [length] of the simple shapes; of a mesh its scale.
    file: of a mesh, as it is written.
    """

    name: str
    origin: Floats
    kind: str
    size: tuple[float, ...] = ()
    file: str = ""


@dataclass(frozen=True, eq=False)
class UrdfJoint:
    """A joint.

    origin: of the child's frame in the parent's at rest, a matrix (4, 4).
    axis: of a joint that moves, of length 1.
    mimic: joint, multiplier and offset of the value that it follows.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Floats
    axis: Floats
    mimic: tuple[str, float, float] | None


@dataclass(frozen=True, eq=False)
class UrdfFile:
    """Shapes of links by name, and joints, in the file's order."""

    name: str
    links: dict[str, list[UrdfShape]]
    joints: list[UrdfJoint]


def read_urdf_file(path: Path, shapes: str) -> UrdfFile:
    """Reads a file, and those of its shapes that `read_robot()` is asked for.

    Raises InputError for what is malformed.
    """
    try:
        return _file(_read_xml(path), path.stem, _SHAPES[shapes])
    except (expat.ExpatError, ValueError, OSError) as error:
        raise InputError(f"cannot read '{path}': {error}") from error


def _read_xml(path: Path) -> Element:
    """The root of a file whose prefixes need not be declared, as in many robots' files."""
    parser, builder = expat.ParserCreate(), ElementTree.TreeBuilder()
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    with path.open("rb") as file:
        parser.ParseFile(file)
    return builder.close()


def _file(root: Element, stem: str, tags: tuple[str, ...]) -> UrdfFile:
    if root.tag != "robot":
        raise ValueError(f"expected <robot>, got <{root.tag}>")
    links: dict[str, list[UrdfShape]] = {}
    for element in root.findall("link"):
        name = _text(element, "name")
        if name in links:
            raise ValueError(f"there are two links '{name}'")
        links[name] = _shapes(element, name, tags)
    joints: dict[str, UrdfJoint] = {}
    for element in root.findall("joint"):
        name = _text(element, "name")
        if name in joints:
            raise ValueError(f"there are two joints '{name}'")
        with _within(f"joint '{name}'"):
            joints[name] = _joint(element, name)
    return UrdfFile(root.get("name") or stem, links, list(joints.values()))


def _shapes(link: Element, name: str, tags: tuple[str, ...]) -> list[UrdfShape]:
    shapes: list[UrdfShape] = []
    for tag in tags:
        for element in link.findall(tag):
            title = element.get("name") or f"{name}/{len(shapes)}"
            with _within(f"link '{name}', {tag} '{title}'"):
                shapes.append(_shape(element, title))
    return shapes


def _shape(element: Element, name: str) -> UrdfShape:
    geometry = element.find("geometry")
    if geometry is None or not len(geometry):
        raise ValueError("it has no geometry")
    origin, given = _origin(element), geometry[0]
    if given.tag == "mesh":
        return UrdfShape(name, origin, "mesh", _scale(given), _text(given, "filename"))
    size: tuple[float, ...] = ()
    for attribute, count in _SIZES.get(given.tag, {}).items():
        size += _numbers(given, attribute, count)
    if any(number <= 0 for number in size):
        raise ValueError(f"the size of a <{given.tag}> is not positive")
    return UrdfShape(name, origin, given.tag, size)


def _scale(mesh: Element) -> tuple[float, ...]:
    one = len(mesh.get("scale", "").split()) == 1
    scale = _numbers(mesh, "scale", 1) * 3 if one else _numbers(mesh, "scale", 3, (1.0, 1.0, 1.0))
    if 0 in scale:
        raise ValueError("the scale of a <mesh> is 0")
    return scale


def _joint(element: Element, name: str) -> UrdfJoint:
    kind = _text(element, "type")
    if kind not in (*MOVING, *STIFF, "fixed"):
        raise ValueError(f"there is no type '{kind}'")
    axis = np.array(_numbers(_child(element, "axis"), "xyz", 3, (1.0, 0.0, 0.0)))
    if kind in MOVING:
        if not axis.any():
            raise ValueError("the axis has no direction")
        axis /= np.abs(axis).max()
        axis /= np.linalg.norm(axis)
    given = element.find("mimic")
    mimic = None
    if given is not None:
        multiplier, offset = (
            _numbers(given, word, 1, (rest,))[0]
            for word, rest in (("multiplier", 1.0), ("offset", 0.0))
        )
        mimic = _text(given, "joint"), multiplier, offset
    return UrdfJoint(
        name=name,
        kind=kind,
        parent=_text(_child(element, "parent"), "link"),
        child=_text(_child(element, "child"), "link"),
        origin=_origin(element),
        axis=axis,
        mimic=mimic,
    )


def _origin(element: Element) -> Floats:
    """Roll, pitch and yaw are turns around the fixed axes x, y and z, one after the other."""
    given = _child(element, "origin")
    matrix = np.eye(4)
    for axis, angle in enumerate(_numbers(given, "rpy", 3, (0.0, 0.0, 0.0))):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(4)
        turn[i, i] = turn[j, j] = math.cos(angle)
        turn[j, i] = math.sin(angle)
        turn[i, j] = -turn[j, i]
        matrix = turn @ matrix
    matrix[:3, 3] = _numbers(given, "xyz", 3, (0.0, 0.0, 0.0))
    return matrix


def _child(element: Element, tag: str) -> Element:
    """The child; one without attributes if there is none."""
    found = element.find(tag)
    return Element(tag) if found is None else found


def _text(element: Element, attribute: str) -> str:
    text = element.get(attribute)
    if not text:
        raise ValueError(f"a <{element.tag}> has no {attribute}")
    return text


def _numbers(
    element: Element, attribute: str, count: int, default: tuple[float, ...] | None = None
) -> tuple[float, ...]:
    if default is not None and element.get(attribute) is None:
        return default
    text = _text(element, attribute)
    try:
        numbers = tuple(map(float, text.split()))
    except ValueError:
        numbers = ()
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        what = "a number" if count == 1 else f"{count} numbers"
        raise ValueError(f"{attribute} of <{element.tag}>: expected {what}, got '{text}'")
    return numbers


@contextmanager
def _within(where: str) -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error
