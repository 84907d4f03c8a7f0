# SPDX-License-Identifier: Apache-2.0
"""The report of a tuning: gains before and after, required, predicted and measured margins, and Bode plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ..gains.frequency_response import Complex, branch, margins
from ..gains.gain_design import Verdict
from ..objects.journal import now
from ..objects.parameter import Parameter, Value
from ..plots import CLOSED, DEMAND, MARK, OPEN, Real, new_figure, png_of, styled
from ..units import rounded
from .page import PageTable, Section, write_page


@dataclass(frozen=True)
class LoopComparison:
    """Open loops: measured, `before` (the measured plant with the old gains, computed), predicted by the design."""

    frequency_hz: Real
    measured: Complex
    before: Complex
    predicted_hz: Real
    predicted: Complex


def write_tune_report(
    path: Path, axis: str, present: Mapping[Parameter, Value], changed: Mapping[Parameter, Value],
    loops: LoopComparison, verdicts: Sequence[Verdict], remarks: Sequence[str],
) -> None:  # fmt: skip
    """One HTML file."""
    kept = all(verdict.kept for verdict in verdicts)
    rows = [(p.name, p.where, rounded(present[p]), rounded(value), p.unit) for p, value in changed.items()]
    sections = [
        Section(
            "Gains",
            " ".join(f"{text.rstrip('.')}." for text in remarks),
            PageTable(("gain", "object", "before", "after", "unit"), rows),
        ),
        _margins(verdicts, loops),
        _bode(loops),
    ]
    notes = (
        [] if kept else ["The old gains are active again: " + "; ".join(v.text for v in verdicts if not v.kept) + "."]
    )
    state = "The new gains were kept." if kept else "The new gains were tried; the old gains were restored."
    write_page(path, f"Tuning of {axis}", f"{now()}. {state}", sections, notes)


def _margins(verdicts: Sequence[Verdict], loops: LoopComparison) -> Section:
    before = margins(loops.frequency_hz, loops.before)
    old = {"gain margin": before.gain_margin_db, "phase margin": before.phase_margin_deg}
    rows = [
        (
            f"{v.name}, {v.unit}", _margin(old[v.name]), _margin(v.required if v.wished else None),
            _margin(v.predicted), _margin(v.measured), f"{v.tolerance:g}", "yes" if v.kept else "no",
        )
        for v in verdicts
    ]  # fmt: skip
    columns = ("margin", "before", "required", "predicted", "measured", "tolerance", "met")
    text = (
        "Before: computed from the plant as measured now and the old gains. A margin passes if the measured value"
        " is not below the required one (or the predicted one, if none is required) by more than the tolerance."
    )
    bad = [position for position, verdict in enumerate(verdicts) if not verdict.kept]
    return Section("Margins", text, PageTable(columns, rows, bad))


def _margin(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"


def _bode(loops: LoopComparison) -> Section:
    return Section("Open loop, cut at the motor torque", picture=png_of(loops_figure(loops)))


@styled
def loops_figure(loops: LoopComparison) -> Figure:
    """The open loops over each other."""
    shown = (loops.predicted_hz >= loops.frequency_hz[0]) & (loops.predicted_hz <= loops.frequency_hz[-1])
    curves = (
        ("before: measured plant, old gains", loops.frequency_hz, loops.before, DEMAND, "o-"),
        ("predicted by the design", loops.predicted_hz[shown], loops.predicted[shown], CLOSED, "--"),
        ("measured with the new gains", loops.frequency_hz, loops.measured, OPEN, "o-"),
    )
    figure = new_figure(9, 6.6)
    gain, phase = figure.subplots(2, 1, sharex=True)
    for label, frequency, loop, colour, style in curves:
        if len(frequency) < 2:
            continue
        magnitude = 20 * np.log10(np.abs(loop))
        gain.semilogx(frequency, magnitude, style, ms=3, color=colour, label=label)
        phase.semilogx(frequency, branch(np.degrees(np.unwrap(np.angle(loop))), magnitude), style, ms=3, color=colour)
    gain.axhline(0, color=MARK, lw=0.9)
    phase.axhline(-180, color=MARK, lw=0.9)
    gain.set_ylabel("open loop (dB)")
    phase.set_ylabel("phase (°)")
    phase.set_xlabel("frequency (Hz)")
    gain.legend(fontsize=8.5)
    return figure
