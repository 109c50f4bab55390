"""Contacts as tables: a row for each contact, as CSV or Parquet.

with pierce.tables.ContactTable("contacts.parquet") as table:
    for step in range(100):
        ...  # set poses and positions
        table.add(step, world.detect())
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import Contacts, Found, Side, contact_dtype
from ._needs import need

__all__ = ["ContactTable", "columns", "write_contacts"]

_INDEX = np.uint64(0xFFFFFFFF)


def columns(frame: int, contacts: Contacts) -> dict[str, NDArray[Any]]:
    """Contacts as columns of equal length, by name.

    `frame` comes first, then all fields of `contact_dtype`.
    Vectors are three columns, such as `normal_x`, `normal_y` and `normal_z`, and barycentric
    weights are `barycentric_0` to `barycentric_2`.
    `a` and `b` are handles; `body_a` and `body_b` are the bodies' indices.
    `source` is "a" or "b", and `found` the name of a `Found`.
    `depth` is 0 where `distance` is positive.
    """
    records = contacts.records
    table: dict[str, NDArray[Any]] = {"frame": np.full(len(records), frame, np.int64)}
    for name in contact_dtype.names or ():
        values = records[name]
        if name == "source":
            table[name] = _names(values, Side)
        elif name == "found":
            table[name] = _names(values, Found)
        elif values.ndim == 1:
            table[name] = values
        else:
            ends = "012" if name == "barycentric" else "xyz"
            table |= {f"{name}_{end}": values[:, k] for k, end in enumerate(ends)}
        if name in ("a", "b"):
            table[f"body_{name}"] = (values & _INDEX).astype(np.uint32)
    table["depth"] = np.asarray(contacts.depth)
    return table


def _names(values: NDArray[Any], kinds: Any) -> NDArray[Any]:
    names = np.array([kinds(k).name for k in range(len(kinds))])
    return np.asarray(names[values])


def _kind_of(path: Path) -> str:
    kind = path.suffix.lower()
    if kind not in (".csv", ".parquet"):
        raise ValueError(f"'{path}': expected a name that ends in .csv or .parquet")
    return kind


class ContactTable:
    """A file that contacts are added to, step by step, until `close()` or the end of `with`.

    path: its ending says the format: `.csv`, or `.parquet`, which needs pyarrow.
    CSV has enough digits to read the same numbers back; Parquet has a group of rows for each
    step that has contacts.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = Path(path)
        self._parquet: Any = None
        self._csv: Any = None
        kind = _kind_of(self._path)
        if kind == ".csv":
            self._file = open(self._path, "w", newline="", encoding="utf-8")
            self._rows = csv.writer(self._file)
        else:
            self._arrow = need("pyarrow", "pyarrow", "writing Parquet")
            need("pyarrow.parquet", "pyarrow", "writing Parquet")
        self._kind = kind
        self._begun = self._closed = False

    def add(self, frame: int, contacts: Contacts) -> None:
        """Adds the contacts of a step. Raises ValueError after `close()`."""
        if self._closed:
            raise ValueError(f"'{self._path}' is closed: no contacts can be added")
        table = columns(frame, contacts)
        if self._kind == ".csv":
            if not self._begun:
                self._rows.writerow(table)
            self._rows.writerows(zip(*(column.tolist() for column in table.values())))
        else:
            batch = self._arrow.table(table)
            if not self._begun:
                self._parquet = self._arrow.parquet.ParquetWriter(self._path, batch.schema)
            if len(batch):
                self._parquet.write_table(batch)
        self._begun = True

    def close(self) -> None:
        """Ends the file. May be repeated."""
        self._closed = True
        if self._kind == ".csv":
            self._file.close()
        elif self._parquet is not None:
            self._parquet.close()

    def __enter__(self) -> ContactTable:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def write_contacts(path: str | Path, steps: Iterable[Contacts]) -> None:
    """Writes the contacts of steps, whose frames are counted from 0; see `ContactTable`.

    The file is there as a whole or not at all, and what was there before stays until then.
    """
    path = Path(path)
    part = path.with_name(f"{path.stem}.part-{os.getpid()}{_kind_of(path)}")
    try:
        with ContactTable(part) as table:
            for frame, contacts in enumerate(steps):
                table.add(frame, contacts)
        if part.exists():  # Parquet has no file without a step
            part.replace(path)
    finally:
        part.unlink(missing_ok=True)
