# SPDX-License-Identifier: Apache-2.0
"""The simulator for `servoctl ui --demo`, started and ended with the page, and the motion that it shows first."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from ..errors import InputError, ServoctlError
from ..schema import starts
from .engine import Engine
from .jobs import Jobs

ENVIRONMENT = "SIM_HOST"
TRAVEL_DEG, RATE_DEG_S = (10.0, 4.0), (5.0, 2.0)
"""Of the motion that the demonstration begins with, by axis."""
_PATIENCE_S = 20.0


def find_simulator() -> Path:
    """Raises InputError when it is not built."""
    named = os.environ.get(ENVIRONMENT)
    places = [Path(named)] if named else []
    places += [folder / "build/host/bin/sim_host" for start in starts() for folder in (start, *start.parents)]
    on_path = shutil.which("sim_host")
    places += [Path(on_path)] if on_path else []
    for place in places:
        if os.access(place, os.X_OK) and place.is_file():
            return place
    raise InputError(
        f"--demo needs the simulator, which is not built: run './tools/demo' in the checkout, or name the program of a release in"
        f" {ENVIRONMENT}."
    )


@contextlib.contextmanager
def simulator() -> Iterator[str]:
    """A simulated servo on a free port of this computer: its bus."""
    program = find_simulator()
    process = subprocess.Popen(
        [program, "serve", "--until-stdin-ends", "--bus", "slcan-tcp:0"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        start_new_session=True,  # Ctrl-C is for the page, which first brings the axes to rest
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


def show_motion(engine: Engine) -> None:
    """Both axes of the simulator move back and forth until somebody commands otherwise."""
    end = time.monotonic() + _PATIENCE_S
    while not engine.state()["link"]["up"]:
        if time.monotonic() > end:
            return
        time.sleep(0.1)
    order = engine.order()
    try:
        for axis, (travel, rate) in enumerate(zip(TRAVEL_DEG, RATE_DEG_S, strict=True)):
            engine.submit(partial(Jobs.enable, axis=axis), order).result(_PATIENCE_S)
            engine.submit(partial(Jobs.swing, axis=axis, travel_deg=travel, rate_deg_s=rate), order).result(_PATIENCE_S)
        engine.say("demonstration: the simulator moves both axes back and forth; take command to do it yourself")
    except (ServoctlError, TimeoutError) as error:
        engine.say(f"demonstration: {error}", "bad")
