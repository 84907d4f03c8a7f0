# SPDX-License-Identifier: Apache-2.0
"""The speed loop of the live axis, measured with a multisine: for `bode`, `tune` and the page."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MotionError
from ..link.device import Device
from ..motion.limits import Limits, Plan, span
from ..motion.rate_run import Progress, send_rates, silent
from ..objects.parameter import AXES
from ..units import TICK_S, degrees, radians
from .frequency_response import (
    GOOD_COHERENCE,
    Complex,
    Margins,
    Multisine,
    Real,
    Response,
    bandwidth_hz,
    design_multisine,
    estimate,
    margins,
    open_loop_is_sharp,
)
from .loop_model import SpeedLoopGains, controller, open_loop, read_gains
from .tuning import Tuning

if TYPE_CHECKING:
    from pandas import DataFrame

SETPOINT_TICKS = 2
SETPOINT_PERIOD_S = SETPOINT_TICKS * TICK_S
WARM_UP_S = 1.0
MIN_LINES = 3
LOWEST_HZ, HIGHEST_HZ, LINES, PERIODS = 1.0, 200.0, 50, 5
BIAS_DEG_S, AMPLITUDE_DEG_S = 1.0, 0.6
MOST = Limits(radians(5.0), radians(45.0), 180.0)
"""Of a motion, unless the user allows more."""


@dataclass(frozen=True)
class LoopStimulus:
    """The motion of the axis: a multisine around a mean rate."""

    sine: Multisine
    bias_rad_s: float
    amplitude_rad_s: float
    periods: int

    def rates(self) -> Real:
        """Set-points, rad/s, one per tick."""
        time_s = np.arange(0.0, WARM_UP_S + self.periods * self.sine.period_s + 0.1, TICK_S)
        ramp = np.minimum(1.0, time_s / WARM_UP_S)
        rates: Real = ramp * (self.bias_rad_s + self.amplitude_rad_s * self.sine.at(time_s))
        return rates

    def plan(self, axis: str) -> Plan:
        """For people, and for the checks."""
        rates = self.rates()
        forward, backward = span(rates, TICK_S)
        frequencies = self.sine.frequency_hz
        text = (
            f"{degrees(self.bias_rad_s):.3g} °/s with {len(frequencies)} sines of {frequencies[0]:.3g} to"
            f" {frequencies[-1]:.3g} Hz, peak {degrees(self.amplitude_rad_s):.3g} °/s,"
            f" {self.periods} × {self.sine.period_s:g} s"
        )
        return Plan(axis, text, float(np.max(np.abs(rates))), forward, backward, len(rates) * TICK_S)


def loop_stimulus(
    low: float = LOWEST_HZ, high: float = HIGHEST_HZ, bias: float = radians(BIAS_DEG_S), amplitude: float = radians(AMPLITUDE_DEG_S),
    lines: int = LINES, periods: int = PERIODS,
) -> LoopStimulus:  # fmt: skip
    """`lines` sines from `low` to `high` (Hz) with this peak (rad/s) around a mean rate `bias` (rad/s), which keeps the axis
    sliding; `periods` of 4 / `low` s. Raises InputError."""
    if not 0.05 <= low < high or high > 0.4 / SETPOINT_PERIOD_S:
        raise InputError(
            f"invalid frequencies {low:g} to {high:g} Hz: expected 0.05 Hz or more and at most"
            f" {0.4 / SETPOINT_PERIOD_S:.0f} Hz (--high), because set-points are sent every"
            f" {1000.0 * SETPOINT_PERIOD_S:g} ms."
        )
    if amplitude <= 0 or (bias != 0 and amplitude >= abs(bias)):
        raise InputError(
            "--amplitude must be greater than 0 and less than --bias; otherwise the axis would reverse and stick."
        )
    return LoopStimulus(design_multisine(low, high, lines), bias, amplitude, periods)


@dataclass(frozen=True)
class MeasuredLoop:
    """The measured closed loop, the open loop computed from it, and where each can be trusted."""

    closed: Response
    loop: Complex
    good: NDArray[np.bool_]
    sharp: NDArray[np.bool_]
    margins: Margins
    bandwidth_hz: float | None
    gains: SpeedLoopGains
    lost: int

    def columns(self) -> dict[str, Real]:
        """Over frequency, for a file or a frame."""
        closed = self.closed
        return {
            "frequency_hz": closed.frequency_hz,
            "closed_db": 20 * np.log10(np.abs(closed.value)),
            "closed_deg": np.degrees(np.unwrap(np.angle(closed.value))),
            "open_db": 20 * np.log10(np.abs(self.loop)),
            "open_deg": np.degrees(np.unwrap(np.angle(self.loop))),
            "coherence": closed.coherence,
            "open_loop_trusted": self.sharp.astype(np.float64),
        }

    def frame(self) -> DataFrame:
        """`columns` with the frequency as index. Needs pandas."""
        from ..show.frames import loop_frame

        return loop_frame(self)

    def loop_with(self, gains: SpeedLoopGains) -> Complex:
        """The open loop that other gains would have with the measured plant."""
        frequency = self.closed.frequency_hz
        plant = self.loop / controller(self.gains, frequency)[0]
        return np.asarray(plant * controller(gains, frequency)[0], dtype=np.complex128)


def measure_loop(
    device: Device, axis: str, stimulus: LoopStimulus, limits: Limits, hold_other: bool = False,
    progress: Progress = silent,
) -> MeasuredLoop:  # fmt: skip
    """Moves the axis, with the other one held if `hold_other`; raises MotionError when noise hides too much."""
    number = AXES.index(axis)
    Tuning(device, "bode").refuse_foreign_stage({number})  # the node reads back what is staged, not what is in force
    gains = read_gains(device, number)
    run = send_rates(device, number, stimulus.rates(), SETPOINT_TICKS, limits, hold_other, progress=progress)
    demand, answer, lost = run.demand, run.answer, run.lost
    skip = int((WARM_UP_S + 0.05) / TICK_S)
    if (len(demand) - skip) * TICK_S < 2 * stimulus.sine.period_s:
        raise MotionError(f"{lost} samples were lost, which leaves less than two periods: use more --periods.")
    closed = estimate(demand[skip:], answer[skip:], TICK_S, stimulus.sine)
    loop = open_loop(gains, closed.frequency_hz, closed.value)
    good = np.asarray(closed.coherence >= GOOD_COHERENCE)
    if np.count_nonzero(good) < MIN_LINES:
        raise MotionError(
            f"the coherence is below {GOOD_COHERENCE} at nearly all frequencies: the response is mostly noise."
            " Raise --amplitude or --periods."
        )
    sharp = open_loop_is_sharp(closed, loop)
    if np.count_nonzero(sharp) < MIN_LINES:
        raise MotionError("the open loop is hidden by noise: raise --amplitude or --periods.")
    found = margins(closed.frequency_hz[sharp], loop[sharp])
    width = bandwidth_hz(closed.frequency_hz[good], closed.value[good])
    return MeasuredLoop(closed, loop, good, sharp, found, width, gains, lost)
