# SPDX-License-Identifier: Apache-2.0
"""A step of the rate on the live axis: what will move, and the steps in what was recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MotionError
from ..units import TICK_S, degrees, radians
from .limits import Limits, Plan, span
from .rate_run import RatesRun
from .step_response import StepNumbers, analyse_step

Real = NDArray[np.float64]

SETPOINT_TICKS = 4
MOST = Limits(radians(5.0), radians(30.0), 60.0)
"""Of a motion, unless the user allows more."""
BEFORE_STEP_S = 0.15
LONGEST_HOLD_S = 30.0
SHORTEST_HOLD_S = 0.1


@dataclass(frozen=True)
class StepPlan:
    """The motion, its rates (rad/s, one per tick), and the number of steps away from zero."""

    plan: Plan
    rates: Real
    steps: int


def plan_step(axis: str, amplitude: float, base: float = 0.0, hold: float = 1.0, one_way: bool = False) -> StepPlan:
    """From a rate to one that is higher by `amplitude` (rad/s), each for `hold` s; then the same backward, so that the
    axis ends where it began, or not if `one_way`."""
    if amplitude == 0.0 or not SHORTEST_HOLD_S <= hold <= LONGEST_HOLD_S:
        raise InputError("--amplitude must not be 0, and --hold must be 0.1 to 30 s.")
    signs = [1.0] if one_way else [1.0, -1.0]
    levels = [level + 0.0 for sign in signs for level in (sign * base, sign * (base + amplitude))] + [0.0]
    times = [hold if base else BEFORE_STEP_S + 0.1, hold] * len(signs) + [0.3]
    rates = np.concatenate([np.full(int(t / TICK_S), level) for level, t in zip(levels, times, strict=True)])
    forward, backward = span(rates, TICK_S)
    text = " → ".join(f"{degrees(level) + 0.0:.3g}" for level in levels) + f" °/s, {hold:g} s each"
    plan = Plan(axis, text, float(np.max(np.abs(rates))), forward, backward, float(sum(times)))
    return StepPlan(plan, rates, len(signs))


StepRecord = tuple[
    str,
    Real,
    Real,
    Real,
    StepNumbers,
]


def angle_behind_rad(step: StepRecord, seconds: float) -> float:
    """How far the axis has fallen behind its set-point in this time after the step, in the direction of the step."""
    _, time_s, demand, answer, numbers = step
    after = (time_s >= 0.0) & (time_s < seconds)
    return float(np.sign(numbers.to_rad_s - numbers.from_rad_s) * np.sum((demand - answer)[after]) * TICK_S)


def delays(run: RatesRun) -> str:
    """What may have disturbed a run."""
    return f"the latest set-point was {run.late} ms late by the node's clock, {run.lost} samples were lost"


def disturbed_text(records: Sequence[StepRecord], planned: StepPlan, run: RatesRun) -> str:
    """How many steps were not recorded undisturbed, and why; "" when all were."""
    if len(records) >= planned.steps:
        return ""
    return f"only {len(records)} of {planned.steps} steps were recorded undisturbed ({delays(run)}); repeat the measurement."


def cut_steps(run: RatesRun, hold: float) -> list[StepRecord]:
    """As `find_steps`; raises MotionError when there is none."""
    records = find_steps(run, hold)
    if not records:
        raise MotionError(
            f"the axis' demand (606B) did not follow the commanded steps: {delays(run)}. Repeat with less load on the bus"
            " and on this computer."
        )
    return records


def find_steps(run: RatesRun, hold: float) -> list[StepRecord]:
    """The parts of the record around each step away from zero that was held for the required time."""
    demand, answer = run.demand, run.answer
    change = np.abs(np.diff(demand))
    edges = [0, *(np.flatnonzero(change > 1e-5) + 1), len(demand)]
    plateaus = [(a, b) for a, b in zip(edges[:-1], edges[1:], strict=True) if b - a > 20]
    records: list[StepRecord] = []
    for (a, b), (c, d) in zip(plateaus[:-1], plateaus[1:], strict=True):
        if abs(demand[c]) <= abs(demand[a]) or d - c < 0.8 * hold / TICK_S or c - b > 4:
            continue
        start = max(a, c - int(BEFORE_STEP_S / TICK_S / 2))
        part = slice(start, d)
        numbers = analyse_step(demand[part], answer[part], TICK_S)
        time_s = (np.arange(start, d) - c) * TICK_S
        name = "forward" if demand[c] > demand[a] else "backward"
        records.append((name, time_s, demand[part], answer[part], numbers))
    return records
