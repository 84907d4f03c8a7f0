# SPDX-License-Identifier: Apache-2.0
"""Requirements and parameters for `identify design`, its result, and whether a measured loop meets the requirements."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..identify.identify_program import IdentifyProgram
from ..objects.parameter import AXIS_SHIFT, PLANT_OBJECT, Parameter, Value
from ..objects.schema import Schema
from .frequency_response import Complex, Margins, Real

GAIN_TOLERANCE_DB = 1.0
PHASE_TOLERANCE_DEG = 3.0
"""A measured margin that is smaller by no more than this counts as met. In wind they differ by half a decibel and half
a degree from one measurement to the next. The rest is for effects that a design does not model, such as the slope of
the friction."""
DESIGN_FILES = ("wishes.json", "parameters.json", "design.json")
"""Requirements, the gains that were, and the design."""
FIRST, LAST = 0x2000, 0x205F
"""The objects that a design may use."""


@dataclass(frozen=True)
class Design:
    """Values by parameter, predicted margins (None: there is none), loop gain at frequencies, remarks."""

    gains: dict[Parameter, Value]
    gain_margin_db: float | None
    phase_margin_deg: float | None
    predicted: dict[str, Any]
    frequency_hz: Real
    loop: Complex
    notes: list[str]


def parameters_of(schema: Schema, axis: int) -> list[Parameter]:
    """All gains of an axis that `identify design` needs."""
    shift = AXIS_SHIFT * axis
    return [p for p in schema if p.axis == axis and FIRST <= p.index - shift <= LAST and p.writable]


def design_gains(
    program: IdentifyProgram, folder: Path, identified: Path, schema: Schema, axis: int,
    requirements: Mapping[str, float], present: Mapping[Parameter, Value],
) -> Design:  # fmt: skip
    """Runs `identify design`; DESIGN_FILES are in `folder` afterwards."""
    wishes, parameters, path = (folder / name for name in DESIGN_FILES)
    _write(wishes, requirements)
    shift = AXIS_SHIFT * axis
    _write(parameters, {f"0x{p.index - shift:04X}:{p.sub}": value for p, value in present.items()})
    data = program.design(identified, wishes, parameters, path)
    try:
        gains = {}
        for row in data["parameters"]:
            parameter = schema.by_index(int(row["index"], 0) + shift, row["sub"])
            if parameter is None and int(row["index"], 0) == PLANT_OBJECT:
                continue  # firmware from before this object
            if parameter is None or parameter not in present:
                raise InputError(f"{path}: sets {row['index']}:{row['sub']}, which is not a gain of this device.")
            gains[parameter] = parameter.check(row["value"])
        predicted, loop = data["predicted"], data["loop_gain"]
        frequency, real, imag = (np.asarray(loop[key], np.float64) for key in ("frequency_hz", "real", "imag"))
        margins = predicted["gain_margin_db"], predicted["phase_margin_deg"]
        return Design(gains, *margins, predicted, frequency, real + 1j * imag, [str(note) for note in data["notes"]])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: not a design of 'identify design': {error!r}.") from error


def _write(path: Path, data: Mapping[str, Any]) -> None:
    try:
        path.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}.") from error


@dataclass(frozen=True)
class Verdict:
    """One margin: the required value (by option, otherwise the prediction), the measured value, and whether it is
    enough."""

    name: str
    unit: str
    required: float | None
    wished: bool
    predicted: float | None
    measured: float | None
    tolerance: float
    kept: bool

    @property
    def text(self) -> str:
        """A sentence about this figure; says by how much a requirement is missed."""
        of = "required" if self.wished else "predicted"
        if self.measured is None:
            return f"the {self.name} could not be determined from the measured frequencies"
        if self.required is None:
            return f"{self.name} {self.measured:.1f} {self.unit}; the design predicts none"
        short = self.required - self.measured
        text = f"{self.name} {self.measured:.1f} {self.unit}, {of} {self.required:.1f} {self.unit}"
        return (
            text if self.kept else f"{text}: {short:.1f} {self.unit} too low (tolerance {self.tolerance:g} {self.unit})"
        )


def judge(
    design: Design, requirements: Mapping[str, float], measured: Margins, highest_gain_db: float
) -> list[Verdict]:
    """Gain and phase margin; `highest_gain_db` is that of the loop at the highest well-measured frequency.

    Where the phase stays above -180° within the measured frequencies, the gain margin is at least the attenuation of
    the loop there.
    """
    gain_margin = measured.gain_margin_db
    if gain_margin is None and measured.crossover_hz is not None:
        gain_margin = -highest_gain_db
    rows = (
        ("gain margin", "dB", "least_gain_margin_db", design.gain_margin_db, gain_margin, GAIN_TOLERANCE_DB),
        (
            "phase margin",
            "°",
            "least_phase_margin_deg",
            design.phase_margin_deg,
            measured.phase_margin_deg,
            PHASE_TOLERANCE_DEG,
        ),
    )
    verdicts = []
    for name, unit, requirement, predicted, found, tolerance in rows:
        required = requirements.get(requirement, predicted)
        kept = found is not None and (required is None or found >= required - tolerance)
        verdicts.append(Verdict(name, unit, required, requirement in requirements, predicted, found, tolerance, kept))
    return verdicts
