# SPDX-License-Identifier: Apache-2.0
"""Rates as set-points of the live axis, one after the other in the node's time, with demand and response of every tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..drive import power
from ..errors import MotionError
from ..link.device import Device
from ..link.stream import RateStream
from ..units import TICK_S
from .limits import Guard, Limits
from .live import LiveAxis

Real = NDArray[np.float64]
Progress = Callable[[float, float | None], object]

FASTEST_PACE = 1.5
"""Ratio of the device's time to ours up to which set-points sent from here can follow."""
_PROGRESS = 50
"""Set-points between two calls of `progress`."""


def silent(_passed_s: float, _rate_rad_s: float | None) -> None:
    """Progress that nobody sees."""


def check_pace(device: Device) -> None:
    """Raises MotionError when the node's clock is so fast that set-points from here would come late."""
    for seconds in (0.1, 0.5):  # a simulator that its computer has delayed catches up some ms at once
        pace = device.pace(seconds)
        if pace <= FASTEST_PACE:
            return
    raise MotionError(
        f"the node's clock runs {pace:.1f} times as fast as the computer's, so set-points from here would arrive"
        " late: run the simulator or the emulated board with --speed 1."
    )


@dataclass(frozen=True)
class RatesRun:
    """Demand and response in rad/s, one sample per tick, the number of lost samples, and the largest delay of a
    set-point in ticks."""

    demand: Real
    answer: Real
    lost: int
    late: int


def send_rates(
    device: Device, axis: int, rates: Real, period: int, limits: Limits, hold_other: bool = False,
    interpolation: int | None = None, progress: Progress = silent,
) -> RatesRun:  # fmt: skip
    """Sends rates (rad/s, one per tick) in csv, one every `period` ticks of the node.

    The node follows each within `interpolation` ticks (60C2), `period` by default. `progress` gets the passed time (s) and
    the rate just measured (rad/s), None before the first sample.
    """
    check_pace(device)
    with RateStream(device, axis) as stream, LiveAxis(device, axis, power.CYCLIC_VELOCITY) as live:
        if hold_other:
            live.hold(1 - axis)
        live.set_interpolation(interpolation or period)
        stream.check_heard()
        stream.start()
        guard = Guard(stream, limits)
        for count, tick in enumerate(stream.pace(period, len(rates))):
            stream.send(float(rates[tick]))
            guard.look()
            if count % _PROGRESS == 0:
                progress(tick * TICK_S, stream.latest())
        stream.send(0.0)
        live.check_enabled()
        demand, answer = stream.samples()
        lost, late = stream.lost(), stream.late()
        not_heard = stream.not_heard()
    if len(demand) < 0.9 * len(rates):
        raise MotionError(f"only {len(demand)} of {len(rates)} samples arrived: the bus is too slow or too busy.")
    if np.ptp(rates) > 0.0 and np.ptp(demand) == 0.0:
        raise MotionError(f"the demanded rate (606B) did not change in {len(demand)} samples: {not_heard}")
    return RatesRun(demand, answer, lost, late)
