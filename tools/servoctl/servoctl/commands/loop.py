# SPDX-License-Identifier: Apache-2.0
"""Measuring the speed loop of the live axis with a progress bar, and its files, for `bode` and `tune`."""

from __future__ import annotations

from pathlib import Path

from ..gains import loop_test
from ..gains.loop_test import LoopStimulus, MeasuredLoop
from ..link.device import Device
from ..motion.limits import Limits
from ..session import Session


def measure_loop(
    session: Session, device: Device, axis: str, stimulus: LoopStimulus, limits: Limits, what: str, hold_other: bool = False
) -> MeasuredLoop:
    """As in the library, with a progress bar."""
    with session.out.progress() as bar:
        task = bar.add_task(what, total=stimulus.plan(axis).duration_s)
        return loop_test.measure_loop(
            device, axis, stimulus, limits, hold_other, lambda passed_s, _rate_rad_s: bar.update(task, completed=passed_s)
        )


def save_loop(measured: MeasuredLoop, title: str, path: Path) -> list[str]:
    """PNG and CSV; their names."""
    from ..plots import bode_figure, save, write_csv

    write_csv(path.with_suffix(".csv"), measured.columns())
    save(bode_figure(title, measured), path.with_suffix(".png"))
    return [str(path.with_suffix(".png")), str(path.with_suffix(".csv"))]
