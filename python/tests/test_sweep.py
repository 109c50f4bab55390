"""Sweeps: every combination once, again only what is missing, and one table."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

COMMAND = os.environ.get("PIERCE_COMMAND")
pytestmark = pytest.mark.skipif(COMMAND is None, reason="the command is not built")

import pierce.sweep  # noqa: E402


def pierce_sweep(*arguments):
    return subprocess.run([COMMAND, "sweep", *map(str, arguments)], capture_output=True, text=True)


def sweep_in(folder, **parts):
    content = {
        "format": "pierce-sweep",
        "version": 1,
        "command": ["run", "tori", "--seconds", "0.2", "--threads", "1"],
        "parameters": {"--count": [2, 3], "--coverage": ["vertices", "complete"]},
    }
    file = folder / "sweep.json"
    file.write_text(json.dumps({**content, **parts}))
    return file


def table_of(folder):
    with open(folder / "sweep" / "table.csv", newline="") as file:
        return list(csv.DictReader(file))


def test_every_combination_is_run_once(tmp_path):
    file = sweep_in(tmp_path)
    assert pierce.sweep.missing(file) == [0, 1, 2, 3]
    assert pierce.sweep.run(file, 2) == 2
    assert pierce.sweep.missing(file) == [0, 1, 3]
    before = (tmp_path / "sweep/000002/result.json").stat().st_mtime_ns
    done = pierce_sweep(file, "--jobs", 2)
    assert done.returncode == 0 and "4 of 4 runs are done" in done.stdout, done.stderr
    assert (tmp_path / "sweep/000002/result.json").stat().st_mtime_ns == before
    rows = table_of(tmp_path)
    assert [(row["run"], row["count"], row["coverage"]) for row in rows] == [
        ("0", "2", "vertices"),
        ("1", "2", "complete"),
        ("2", "3", "vertices"),
        ("3", "3", "complete"),
    ]
    for row in rows:
        result = json.loads((tmp_path / f"sweep/00000{row['run']}/result.json").read_text())
        assert result["settings"]["count"] == int(row["count"])
        assert result["settings"]["coverage"] == row["coverage"]
        assert float(row["contacts.max"]) == result["summary"]["contacts"]["max"]


def test_errors_stand_beside_times(tmp_path):
    file = sweep_in(
        tmp_path,
        parameters={"--count": [4], "--soft": [False]},
        compare=["--methods", "full,overlaps", "--every", "4"],
    )
    done = pierce_sweep(file)
    assert done.returncode == 0, done.stderr
    rows = table_of(tmp_path)
    assert [row["method"] for row in rows] == ["full", "overlaps"]
    assert all(float(row["ms.median"]) > 0 and row["missed_depth_share"] != "" for row in rows)
    assert all(row["soft"] == "false" for row in rows)


def test_a_run_that_fails_is_said_and_tried_again(tmp_path):
    file = sweep_in(tmp_path, parameters={"--backend": ["embree", "none"]})
    done = pierce_sweep(file)
    assert done.returncode == 1
    assert "run 1 has failed" in done.stderr and "1 of 2 runs are done" in done.stdout
    assert "none" in (tmp_path / "sweep/000001/log.txt").read_text()
    assert pierce.sweep.missing(file) == [1]
    with pytest.raises(RuntimeError, match="run 1 has failed"):
        pierce.sweep.run(file, 1)


def test_a_run_is_done_when_it_has_ended_well_with_what_the_file_says(tmp_path, monkeypatch):
    command = ["run", "tori", "--threads", "1"]
    file = sweep_in(
        tmp_path, command=command, parameters={"--count": [2, 3], "--seconds": ["0.1", "0.2"]}
    )
    assert pierce_sweep(file).returncode == 0 and pierce.sweep.missing(file) == []
    changed = {"--count": [2, 5, 3], "--seconds": ["0.1"]}
    sweep_in(tmp_path, command=command, parameters=changed)
    assert pierce.sweep.missing(file) == [1]
    monkeypatch.setenv("PIERCE_QUIET", "1")
    assert pierce.sweep.missing(file) == [1]
    monkeypatch.delenv("PIERCE_QUIET")
    assert pierce_sweep(file).returncode == 0
    for row in table_of(tmp_path):
        result = json.loads((tmp_path / f"sweep/00000{row['run']}/result.json").read_text())
        assert result["settings"]["count"] == int(row["count"])
        assert result["settings"]["seconds"] == float(row["seconds"])
    # What a stopped run has written is there, and the run is not done.
    (tmp_path / "sweep/000001/done.json").unlink()
    assert pierce.sweep.missing(file) == [1]
    compare = ["--methods", "full"]
    sweep_in(tmp_path, command=command, parameters=changed, compare=compare)
    assert pierce.sweep.missing(file) == [0, 1, 2]
    assert pierce_sweep(file).returncode == 0 and pierce.sweep.missing(file) == []


def test_a_script_for_slurm_runs_what_is_missing(tmp_path):
    file = sweep_in(tmp_path, parameters={"--count": [2, 3, 4]})
    pierce.sweep.run(file, 1)
    script = pierce_sweep(file, "--slurm").stdout
    assert "#SBATCH --array=0,2" in script
    for number in (0, 2):
        environment = {**os.environ, "SLURM_ARRAY_TASK_ID": str(number)}
        subprocess.run(["bash", "-c", script], env=environment, check=True)
    assert pierce.sweep.missing(file) == []


def test_tasks_of_ray(tmp_path, monkeypatch):
    file = sweep_in(tmp_path, parameters={"--count": [2, 3]})
    calls = []

    def remote(function):
        def later(*arguments):
            calls.append(arguments)
            return function(*arguments)

        return SimpleNamespace(remote=later)

    like_ray = SimpleNamespace(remote=remote, get=lambda result: result)
    monkeypatch.setitem(sys.modules, "ray", like_ray)
    assert "2 of 2 runs are done" in pierce.sweep.run_with_ray(file)
    assert calls == [(str(file), 0), (str(file), 1)]


def test_tasks_that_fail_hold_no_others_up(monkeypatch):
    done, ended = [], []

    def get(number):
        if number in (1, 2):
            raise OSError(f"no disk for {number}")
        if number == 4:
            raise KeyboardInterrupt
        done.append(number)

    like_ray = SimpleNamespace(
        remote=lambda _: SimpleNamespace(remote=lambda _, number: number),
        get=get,
        cancel=ended.append,
    )
    monkeypatch.setitem(sys.modules, "ray", like_ray)
    monkeypatch.setattr(pierce.sweep, "missing", lambda _: [0, 1, 2, 3])
    monkeypatch.setattr(pierce.sweep, "gather", lambda _: "gathered")
    with pytest.raises(RuntimeError, match=r"runs \[1, 2\] have failed, the first .* disk for 1"):
        pierce.sweep.run_with_ray("sweep.json")
    assert done == [0, 3] and ended == []
    monkeypatch.setattr(pierce.sweep, "missing", lambda _: [0, 4, 5])
    with pytest.raises(KeyboardInterrupt):
        pierce.sweep.run_with_ray("sweep.json")
    assert ended == [0, 4, 5]


@pytest.mark.parametrize("stubborn", [False, True])
def test_an_interrupt_leaves_no_process(stubborn, tmp_path):
    # A command that has begun a run, as `pierce sweep` does, and maybe takes no signals.
    ignored = "trap '' TERM; " if stubborn else ""
    command = tmp_path / "pierce"
    command.write_text(
        f'#!/bin/bash\n{ignored}sleep 600 & echo "$$ $!" > {tmp_path}/part; '
        f"mv {tmp_path}/part {tmp_path}/numbers; wait; wait\n"
    )
    command.chmod(0o755)
    program = "import pierce.sweep as s; s._PATIENCE = 0.5; s.gather('sweep.json')"
    environment = {**os.environ, "PIERCE_COMMAND": str(command)}
    caller = subprocess.Popen(
        [sys.executable, "-c", program],
        env=environment,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until((tmp_path / "numbers").exists)
    numbers = [int(number) for number in (tmp_path / "numbers").read_text().split()]
    os.kill(caller.pid, signal.SIGINT)
    assert "KeyboardInterrupt" in caller.communicate(timeout=60)[1]
    wait_until(lambda: not any(map(runs, numbers)))


def wait_until(come):
    for _ in range(600):
        if come():
            return
        time.sleep(0.05)
    raise AssertionError("it did not come in 30 s")


def runs(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_the_pages_example_is_a_sweep(tmp_path):
    page = (Path(__file__).parents[2] / "docs/sweeps.md").read_text()
    file = tmp_path / "sweep.json"
    file.write_text(re.search(r"```json\n(.*?)```", page, re.DOTALL).group(1))
    assert pierce.sweep.missing(file) == list(range(12))
    listed = pierce_sweep(file, "--list").stdout.splitlines()
    assert listed[3] == "3: pierce run tori --seconds 2 --threads 1 --count 10 --seed 2 --soft"
    program = re.search(r"```python\n(.*?)```", page, re.DOTALL).group(1)
    compile(program, "docs/sweeps.md", "exec")


@pytest.mark.parametrize(
    "parts, what",
    [
        ({"version": 2}, "version"),
        ({"command": ["demo"]}, "run, replay, compare or validate"),
        ({"command": "run"}, "list of strings"),
        ({"parameters": {}}, "parameters"),
        ({"parameters": {"count": [1]}}, "no option"),
        ({"parameters": {"--json": ["x"]}}, "own"),
        ({"parameters": {"--count": 3}}, "list"),
        ({"parameters": {"--count": [[1]]}}, "list"),
        ({"command": ["replay", "x"], "compare": []}, "compare"),
        ({"other": 1}, "there is no 'other'"),
    ],
)
def test_other_files_are_refused(tmp_path, parts, what):
    done = pierce_sweep(sweep_in(tmp_path, **parts))
    assert done.returncode == 2 and what in done.stderr
    assert not (tmp_path / "sweep").exists()
