"""Contacts between triangle meshes by ray tracing.

``World`` holds bodies and finds their contacts. Names are those of the C++ library, whose pages
say more. Lengths are in the caller's unit, quaternions are x, y, z, w.

``pierce.trimesh``, ``pierce.newton``, ``pierce.mujoco`` and ``pierce.viewers`` serve those
packages; ``pierce.files``, ``pierce.robots`` and ``pierce.series`` read files, and
``pierce.paraview``, ``pierce.gltf`` and ``pierce.tables`` write them. Each is imported by itself,
and needs its package.
"""

from collections.abc import Iterable as _Iterable

import numpy as _numpy
import numpy.typing as _typing

from ._core import *  # noqa: F403
from ._core import BodyId as _BodyId
from ._core import contact_dtype as contact_dtype
from ._core import version as version
from .progress import track as track
from .recorder import Recorder as Recorder

__version__ = version


def ids(bodies: _Iterable[_BodyId]) -> _typing.NDArray[_numpy.uint64]:
    """Handles as an array of uint64 (n,), which calls for many bodies read fastest."""
    return _numpy.fromiter((int(body) for body in bodies), dtype=_numpy.uint64)
