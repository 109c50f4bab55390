"""pierce.tables: a row for each contact, with the numbers of the records."""

import csv
import sys

import numpy as np
import pierce
import pytest
from pierce import tables


def steps(world, soft, positions):
    """Three steps: contacts, none, and contacts again."""
    for away in (0, 9, -0.3):
        world.set_positions(soft, positions + np.float32([0, 0, away]))
        yield world.detect()


def check(rows, contacts):
    """Rows are dictionaries of values that have been read back."""
    expected = [(k, each, i) for k, each in enumerate(contacts) for i in range(len(each))]
    assert len(rows) == len(expected) > 50
    for row, (frame, each, i) in zip(rows, expected):
        record = each.records[i]
        assert row["frame"] == frame
        assert (row["a"], row["b"]) == (record["a"], record["b"])
        assert row["body_a"] == pierce.BodyId(int(record["a"])).index
        assert row["source"] == pierce.Side(int(record["source"])).name
        assert row["found"] == pierce.Found(int(record["found"])).name
        for name in ("vertex", "edge_end", "triangle", "age", "distance", "along", "time"):
            assert row[name] == record[name], name
        for name, ends in (("point_a", "xyz"), ("normal", "xyz"), ("barycentric", "012")):
            assert [row[f"{name}_{end}"] for end in ends] == record[name].tolist()
        assert row["of_sheet"] == record["of_sheet"]
        assert row["depth"] == max(0, -record["distance"])


def parsed(text):
    if text in ("True", "False"):
        return text == "True"
    try:
        return float(text) if "." in text or "e" in text else int(text)
    except ValueError:
        return text


def test_csv(two_tori, tmp_path):
    world, _, soft, positions = two_tori
    kept = list(steps(world, soft, positions))
    tables.write_contacts(tmp_path / "contacts.csv", kept)
    with open(tmp_path / "contacts.csv", newline="") as file:
        rows = [{k: parsed(v) for k, v in row.items()} for row in csv.DictReader(file)]
    check(rows, kept)


def test_parquet(two_tori, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    world, _, soft, positions = two_tori
    kept = list(steps(world, soft, positions))
    with tables.ContactTable(tmp_path / "contacts.parquet") as table:
        for frame, contacts in enumerate(kept):
            table.add(frame, contacts)
    table.close()
    read = parquet.read_table(tmp_path / "contacts.parquet")
    check(read.to_pylist(), kept)
    assert str(read.schema.field("distance").type) == "double"
    assert str(read.schema.field("vertex").type) == "uint32"


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_no_contacts(kind, two_tori, tmp_path):
    if kind == "parquet":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    world, _, soft, positions = two_tori
    none = list(steps(world, soft, positions))[1]
    path = tmp_path / f"none.{kind}"
    tables.write_contacts(path, [none, none])
    assert len(none) == 0 and path.stat().st_size > 100
    if kind == "csv":
        assert len(path.read_text().splitlines()) == 1


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_nothing_is_added_to_a_closed_table(kind, two_tori, tmp_path):
    if kind == "parquet":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    contacts = two_tori[0].detect()
    path = tmp_path / f"contacts.{kind}"
    for steps in (1, 0):
        with tables.ContactTable(path) as table:
            for step in range(steps):
                table.add(step, contacts)
        size = path.stat().st_size
        with pytest.raises(ValueError, match=rf"contacts\.{kind}' is closed"):
            table.add(1, contacts)
        assert path.stat().st_size == size


def test_what_is_refused(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"ends in \.csv or \.parquet"):
        tables.ContactTable(tmp_path / "contacts.xls")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ImportError, match="pip install pyarrow"):
        tables.ContactTable(tmp_path / "contacts.parquet")


def test_a_table_is_whole_or_not_there(two_tori, tmp_path):
    world, _, soft, positions = two_tori
    (tmp_path / "contacts.csv").write_text("old")

    def stops():
        yield from steps(world, soft, positions)
        raise OSError("no more")

    with pytest.raises(OSError, match="no more"):
        tables.write_contacts(tmp_path / "contacts.csv", stops())
    assert (tmp_path / "contacts.csv").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["contacts.csv"]
