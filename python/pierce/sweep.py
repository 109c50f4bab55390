"""Runs of a sweep as tasks of a batch system: calls the command `pierce sweep`.

The command is `pierce`, or what the environment variable PIERCE_COMMAND names. The sweep's folder
has to be there for all machines.
"""

from __future__ import annotations

import os
import subprocess
from typing import Any

from ._needs import need


def _command(*arguments: str) -> str:
    command = [os.environ.get("PIERCE_COMMAND", "pierce"), "sweep", *arguments]
    # What it says is the answer.
    environment = {name: value for name, value in os.environ.items() if name != "PIERCE_QUIET"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


def missing(file: str | os.PathLike[str]) -> list[int]:
    """Numbers of the runs that are not done. Raises RuntimeError for a file that is no sweep."""
    listed = _command(os.fspath(file), "--list").splitlines()
    return [int(line.split(":")[0]) for line in listed]


def run(file: str | os.PathLike[str], number: int) -> int:
    """Runs one of a sweep, and returns its number. Raises RuntimeError if it fails."""
    _command(os.fspath(file), "--only", str(number))
    return number


def gather(file: str | os.PathLike[str]) -> str:
    """Runs what is missing, and returns what the command says, the place of the table last."""
    return _command(os.fspath(file))


def run_with_ray(file: str | os.PathLike[str], **options: Any) -> str:
    """Runs what is missing as tasks of Ray, and gathers the table.

    options: of the tasks, such as num_cpus; ray.init() is the caller's.
    """
    ray = need("ray", "ray", "a sweep as tasks of Ray")
    task = ray.remote(**options)(run) if options else ray.remote(run)
    ray.get([task.remote(os.path.abspath(file), number) for number in missing(file)])
    return gather(file)
