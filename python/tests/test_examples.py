"""Every example runs and leaves a picture."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
NEEDED = {"mujoco_chain": ["mujoco"], "newton_pile": ["newton", "warp"]}
TIMEOUT = 300  # [s] the first run of Newton compiles its kernels


@pytest.mark.parametrize("example", sorted(EXAMPLES.glob("[!_]*.py")), ids=lambda path: path.stem)
def test_example(example, tmp_path):
    for package in ["matplotlib", *NEEDED.get(example.stem, [])]:
        if find_spec(package) is None:
            pytest.skip(f"{package} is not installed")
    run = subprocess.run(
        [sys.executable, example, tmp_path / "pictures"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
    )
    assert run.returncode == 0, run.stderr
    pictures = list((tmp_path / "pictures").glob("*.png"))
    assert pictures and all(picture.stat().st_size > 10_000 for picture in pictures)
    assert run.stdout.strip()
