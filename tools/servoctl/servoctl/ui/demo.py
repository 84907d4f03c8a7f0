# SPDX-License-Identifier: Apache-2.0
"""What `servoctl ui --demo` shows first: the simulator moves."""

from __future__ import annotations

import time
from functools import partial

from ..errors import ServoctlError
from .engine import Engine
from .jobs import Jobs

TRAVEL_DEG, RATE_DEG_S = (10.0, 4.0), (5.0, 2.0)
"""Of the motion that the demonstration begins with, by axis."""
_PATIENCE_S = 20.0


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
