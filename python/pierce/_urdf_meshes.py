"""Files of meshes that a URDF file names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree

from ._core import InputError

_SCHEMES = ("package://", "model://")


def find_mesh(name: str, urdf: Path, packages: Mapping[str, str | Path]) -> Path:
    """The file. Raises InputError if there is none.

    A package that `packages` does not name is a folder around the URDF file, or beside one of
    these, that has its name or a `package.xml` which says so.
    """
    for file in _places(name, urdf, packages):
        if file.is_file():
            return file
    raise InputError(f"cannot find '{name}' of '{urdf}'; `packages` may name folders")


def _places(name: str, urdf: Path, packages: Mapping[str, str | Path]) -> Iterator[Path]:
    folders = urdf.absolute().parents
    for scheme in _SCHEMES:
        if name.startswith(scheme):
            package, _, rest = name.removeprefix(scheme).partition("/")
            if package in packages:
                yield Path(packages[package]) / rest
                return
            for folder in folders:
                if package in (folder.name, _said_by(folder / "package.xml")):
                    yield folder / rest
                yield folder / package / rest
            return
    for folder in (urdf.parent, *folders):
        yield folder / name.removeprefix("file://")


def _said_by(file: Path) -> str | None:
    """The package's name in a `package.xml`; None if there is none."""
    try:
        return (ElementTree.parse(file).findtext("name") or "").strip()
    except (OSError, ElementTree.ParseError):
        return None
