"""Runs of a sweep as tasks of a batch system: calls the command `pierce sweep`.

The command is `pierce`, or what the environment variable PIERCE_COMMAND names. The sweep's folder
has to be there for all machines.
"""

from __future__ import annotations

import os
import signal
import subprocess
from contextlib import suppress
from typing import Any

from ._needs import need

_PATIENCE = 10.0
"""[s] How long a command may take to end when it is asked to."""


def _command(*arguments: str) -> str:
    command = [os.environ.get("PIERCE_COMMAND", "pierce"), "sweep", *arguments]
    # What it says is the answer.
    environment = {name: value for name, value in os.environ.items() if name != "PIERCE_QUIET"}
    # A group of its own, so that what ends the call ends the runs that the command has begun, too.
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        process_group=0,
    ) as child:
        try:
            said, complaint = child.communicate()
        except BaseException:
            _end(child)
            raise
    if child.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {complaint.strip()}")
    return said


def _end(child: subprocess.Popen[str]) -> None:
    """Ends a group of processes, by force if they take too long."""
    with suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGTERM)
    try:
        with suppress(subprocess.TimeoutExpired):
            child.wait(_PATIENCE)
    finally:
        with suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)


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

    If a run fails, the others are run all the same, and then RuntimeError is raised.
    Ctrl-C ends all tasks and their processes.
    """
    ray = need("ray", "ray", "a sweep as tasks of Ray")
    task = ray.remote(**options)(run) if options else ray.remote(run)
    tasks = {number: task.remote(os.path.abspath(file), number) for number in missing(file)}
    failed: dict[int, Exception] = {}
    try:
        for number, each in tasks.items():
            try:
                ray.get(each)
            except Exception as error:
                failed[number] = error
    except BaseException:
        for each in tasks.values():
            ray.cancel(each)
        raise
    if failed:
        first = next(iter(failed.values()))
        raise RuntimeError(f"runs {[*failed]} have failed, the first one: {first}") from first
    return gather(file)
