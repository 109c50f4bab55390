"""The bodies of a world."""

from __future__ import annotations

from ._core import BodyId, World, all_worlds


def bodies_of(world: World) -> list[BodyId]:
    """Handles of all bodies: first those of all worlds, then world by world."""
    numbers = [all_worlds, *world.worlds()]
    return [body for number in numbers for body in world.bodies_of(number)]
