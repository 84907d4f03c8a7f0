# SPDX-License-Identifier: Apache-2.0
"""The simulator (sim_host), found and started: for `servoctl ui --demo`, scripts and notebooks."""

from __future__ import annotations

import contextlib
import math
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from .errors import InputError
from .objects.schema import starts

ENVIRONMENT = "SIM_HOST"


def find_simulator() -> Path:
    """In the environment, the build of the surrounding checkout, or PATH; raises InputError that says how to get it."""
    named = os.environ.get(ENVIRONMENT)
    places = [Path(named)] if named else []
    places += [folder / "build/host/bin/sim_host" for start in starts() for folder in (start, *start.parents)]
    on_path = shutil.which("sim_host")
    places += [Path(on_path)] if on_path else []
    for place in places:
        if os.access(place, os.X_OK) and place.is_file():
            return place
    raise InputError(
        f"the simulator is not built: run './tools/demo' in the checkout, or name the program sim_host of a release in {ENVIRONMENT}."
    )


@contextlib.contextmanager
def simulator(speed: float = 1.0) -> Iterator[str]:
    """A simulated servo for the time of the `with` block, on a free port of this computer: its bus, for `connect`.

    `speed`: how many times faster than real time. Identification, moves and recordings work at 10; steps, Bode plots, tuning and
    tracking need 1, because this computer sends their set-points or frames. Raises InputError when the simulator is not found or
    does not start.
    """
    if not 0.0 < speed < math.inf:
        raise InputError(f"the simulator cannot run {speed:g} times as fast as real time: expected a number above 0, such as 1 or 10.")
    program = find_simulator()
    process = subprocess.Popen(
        [program, "serve", "--until-stdin-ends", "--bus", "slcan-tcp:0", "--speed", f"{speed:g}"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        start_new_session=True,  # Ctrl-C is for the program that uses it, which first brings the axes to rest
    )  # fmt: skip
    assert process.stdin is not None and process.stdout is not None
    try:
        address, ready = (process.stdout.readline().strip() for _ in range(2))
        if ready != "ready":
            raise InputError(f"{program} serve did not start: it printed '{address}'.")
        yield address
    finally:
        process.stdin.close()
        try:
            process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()
