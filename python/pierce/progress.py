"""A bar on the terminal while a loop runs."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator, Sized
from typing import TextIO, TypeVar

Item = TypeVar("Item")

_WIDTH = 30
_REDRAW = 0.1  # [s]


def track(
    items: Iterable[Item], what: str = "", total: int | None = None, out: TextIO | None = None
) -> Iterator[Item]:
    """Yields the items, and draws how many are done and how much time is left.

    total: number of items; None: their len(), if they have one.
    out: where the bar is; None: standard error.
        Nothing is drawn if that is no terminal, or if a program has none.
    """
    out = out or sys.stderr
    if total is None and isinstance(items, Sized):
        total = len(items)
    if out is None or not out.isatty():
        yield from items
        return
    begin = drawn = time.monotonic()
    try:
        for done, item in enumerate(items):
            now = time.monotonic()
            if done > 0 and now - drawn >= _REDRAW:
                out.write("\r\033[K" + _bar(what, done, total, now - begin))
                out.flush()
                drawn = now
            yield item
    finally:  # also where the loop ends early
        out.write("\r\033[K")
        out.flush()


def _bar(what: str, done: int, total: int | None, seconds: float) -> str:
    if not total:
        return f"{what} {done}"
    filled = min(_WIDTH * done // total, _WIDTH)
    minutes, rest = divmod(round(seconds / done * max(total - done, 0)), 60)
    bar = "#" * filled + "." * (_WIDTH - filled)
    return f"{what} [{bar}] {done}/{total}  {minutes}:{rest:02} left"
