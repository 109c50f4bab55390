"""Programs of the pages run as they stand."""

import re
from pathlib import Path

import numpy as np
import pytest
from conftest import torus

SOURCE = Path(__file__).parents[2]


def programs(*pages):
    """Programs of pages, as parameters of a test."""
    return [
        pytest.param(program, id=f"{page}-{number}")
        for page in pages
        for number, program in enumerate(
            re.findall(r"```python\n(.*?)```", (SOURCE / page).read_text(), re.DOTALL)
        )
    ]


@pytest.mark.parametrize("program", programs("python/README.md", "docs/python.md", "docs/page.md"))
def test_programs_of_pages(program, tmp_path, monkeypatch, capsys):
    vertices, triangles = torus()
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + np.uint32(1)]
    (tmp_path / "torus.obj").write_text("\n".join(lines))
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "page", "exec"), {})
    assert len(capsys.readouterr().out) > 20
