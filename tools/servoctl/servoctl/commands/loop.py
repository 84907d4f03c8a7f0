# SPDX-License-Identifier: Apache-2.0
"""Measuring the speed loop of the live axis with a progress bar, and its files, for `bode` and `tune`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .. import loop_test
from ..device import Device
from ..limits import Limits
from ..loop_test import LoopStimulus, MeasuredLoop
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
    from ..plots import plot_bode, write_csv

    closed, loop = measured.closed, measured.loop
    write_csv(
        path.with_suffix(".csv"),
        {
            "frequency_hz": closed.frequency_hz,
            "closed_db": 20 * np.log10(np.abs(closed.value)),
            "closed_deg": np.degrees(np.unwrap(np.angle(closed.value))),
            "open_db": 20 * np.log10(np.abs(loop)),
            "open_deg": np.degrees(np.unwrap(np.angle(loop))),
            "coherence": closed.coherence,
            "open_loop_trusted": measured.sharp.astype(float),
        },
    )
    plot_bode(
        path.with_suffix(".png"),
        title,
        closed.frequency_hz,
        closed.value,
        loop,
        closed.coherence,
        measured.sharp,
        measured.margins,
        measured.bandwidth_hz,
    )
    return [str(path.with_suffix(".png")), str(path.with_suffix(".csv"))]
