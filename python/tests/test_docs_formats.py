"""Programs of docs/formats.md run as they stand, on files that are made here."""

import numpy as np
import pytest
from conftest import box, torus
from test_docs import programs
from test_files import write_glb, write_text

ARM = """<mujoco><worldbody><geom name="table" type="box" size="1 1 .1" pos="0 0 -.3"/>
  <body name="upper"><joint name="shoulder" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 1 0 0" size=".1"/>
    <body name="lower" pos="1 0 0"><joint name="elbow" axis="0 1 0"/>
      <geom type="capsule" fromto=".2 0 0 1 0 0" size=".1"/></body></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize("program", programs("docs/formats.md"))
def test_programs_of_the_page(program, tmp_path, monkeypatch, capsys):
    for package in ("trimesh", "meshio", "mujoco", "pygltflib", "pyarrow"):
        pytest.importorskip(package, reason=f"{package} is not installed")
    aside = np.eye(4)
    aside[:3, 3] = [0.3, 0, 0.2]
    nodes = [(0, np.eye(4), [1]), (1, aside, [])]
    write_glb(tmp_path / "assembly.glb", [torus(), box()], nodes)
    (tmp_path / "arm.xml").write_text(ARM)
    vertices, triangles = torus()
    for frame in range(12):
        write_text(tmp_path / f"cloth_{frame}.obj", vertices + np.float32(frame / 10), triangles)
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "page", "exec"), {})
    printed = capsys.readouterr().out
    assert len(printed) > 20 and "contacts=0" not in printed
    print(printed)
