# SPDX-License-Identifier: Apache-2.0
"""Gains designed from an identification, tried on the live axis, and kept only if the measured loop has the margins: for
`tune` and the page. Files in the folder of the identification: wishes.json, parameters.json and design.json of the design,
tune.html and AXIS-active.toml of the test."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..drive.drive import Drive
from ..drive.node_limits import read_limits
from ..errors import InputError
from ..identify.identified import Identified
from ..identify.identify_program import IdentifyProgram
from ..link.device import Device
from ..motion.limits import Limits, Plan, allowed_travel
from ..objects.parameter import AXES, AXIS_SHIFT, PLANT_OBJECT, Parameter, Value
from ..units import degrees, radians
from .gain_design import DESIGN_FILES, Design, Verdict, design_gains, judge, parameters_of
from .gain_set import about, of_axis, read_values
from .gains_file import write_gains
from .loop_model import SpeedLoopGains
from .loop_test import LoopStimulus, MeasuredLoop, measure_loop
from .trial_gains import TrialGains
from .tuning import Tuning

if TYPE_CHECKING:
    from pandas import DataFrame

COMMAND = "tune"
"""In the journal."""
LIMITS = Limits(radians(5.0), radians(60.0), 180.0, by_options=False)
PAGE = "tune.html"
REQUIREMENT_KEYS = {
    "bandwidth_hz": "speed_loop_bandwidth_hz",
    "damping": "speed_loop_damping",
    "setpoint_weight": "setpoint_weight",
    "setpoint_model_hz": "setpoint_model_hz",
    "observer_hz": "observer_bandwidth_hz",
    "least_error": "least_rate_error",
    "disturbance_nm": "disturbance_rms_nm",
    "disturbance_hz": "disturbance_corner_hz",
    "gain_margin_db": "least_gain_margin_db",
    "phase_margin_deg": "least_phase_margin_deg",
    "torque_noise_nm": "most_torque_noise_nm",
    "tracking_hz": "tracking_bandwidth_hz",
    "position_hz": "position_bandwidth_hz",
}
"""Names of the options in wishes.json."""


def check_slides(stimulus: LoopStimulus) -> None:
    """Raises InputError when the axis would not slide while its loop is measured."""
    if stimulus.bias_rad_s == 0.0:
        raise InputError("--bias must not be 0: the loop is measured while the axis slides.")


def check_reach(drive: Drive, plan: Plan, identified: Identified, travel_deg: tuple[float, float] | None) -> None:
    """Raises InputError when the travel of the measurement is not allowed by the user, the node or the
    identification."""
    if travel_deg is None and not read_limits(drive).has_travel:
        travel_deg = identified.travel_deg
    allowed = allowed_travel(drive, travel_deg)
    allowed.check_travel(plan.axis, drive.position(), plan.backward_rad, plan.forward_rad)


@dataclass(frozen=True)
class Proposal:
    """A design beside the present gains. `plant` are guarded values of it that are left out without unlock."""

    axis: int
    requirements: Mapping[str, float]
    design: Design
    present: dict[Parameter, Value]
    changed: dict[Parameter, Value]
    plant: list[Parameter]

    @property
    def locked(self) -> list[Parameter]:
        """Guarded values that it changes."""
        return [p for p in self.changed if p.guarded]

    def frame(self) -> DataFrame:
        """A row per changed gain: before, after, unit. Needs pandas."""
        from ..show.frames import proposal_frame

        return proposal_frame(self)


def propose(
    program: IdentifyProgram, device: Device, identified: Identified, axis: int, work: Path,
    requirements: Mapping[str, float], unlock: bool, in_words: Callable[[str], str] = lambda name: f'"{name}"',
    read: Callable[[Device, list[Parameter]], dict[Parameter, Value]] = read_values,
) -> Proposal:  # fmt: skip
    """Designs, with the files in `work`; nothing changes. `requirements` have the names of wishes.json, `in_words` names one
    for people."""
    Tuning(device, COMMAND).refuse_foreign_stage({axis})
    present = read(device, parameters_of(device.schema, axis))
    try:
        design = design_gains(program, work, identified.path, device.schema, axis, requirements, present)
    except InputError as error:
        message = str(error).replace(f"{work / 'wishes.json'}: ", "")
        for name in REQUIREMENT_KEYS.values():
            message = message.replace(f'"{name}"', in_words(name))
        raise InputError(message) from error
    changed = {p: value for p, value in design.gains.items() if present[p] != value}
    plant = [] if unlock else [p for p in changed if p.index == PLANT_OBJECT + AXIS_SHIFT * axis]
    return Proposal(axis, requirements, design, present, {p: v for p, v in changed.items() if p not in plant}, plant)


def predicted_text(design: Design) -> str:
    """The numbers of "predicted" in one line."""
    units = {"_db": "dB", "_deg": "°", "_hz": "Hz", "_nm": "N m"}
    parts = []
    flat = [(name, value) for name, value in design.predicted.items() if not isinstance(value, dict)]
    for group, rows in design.predicted.items():
        if isinstance(rows, dict):
            flat += [(f"{group} {name}", value) for name, value in rows.items()]
    for name, value in flat:
        ending = next((e for e in units if name.endswith(e)), "")
        if name.endswith("_rad_s"):
            parts.append(f"{name.removesuffix('_rad_s').replace('_', ' ')} {degrees(value):.3g} °/s")
        elif isinstance(value, int | float):
            parts.append(f"{name.removesuffix(ending).replace('_', ' ')} {value:.3g} {units.get(ending, '')}".rstrip())
    return ", ".join(parts)


@dataclass(frozen=True)
class Tried:
    """The loop with the new gains, and whether they were kept."""

    measured: MeasuredLoop
    verdicts: list[Verdict]

    @property
    def kept(self) -> bool:
        """Every margin is met."""
        return all(verdict.kept for verdict in self.verdicts)

    @property
    def reasons(self) -> str:
        """Why not."""
        return "; ".join(verdict.text for verdict in self.verdicts if not verdict.kept)


def try_out(
    device: Device, proposal: Proposal, stimulus: LoopStimulus, unlock: bool,
    measure: Callable[..., MeasuredLoop] = measure_loop,
) -> Tried:  # fmt: skip
    """Moves the axis with the new gains in effect; they stay only if every verdict is good."""
    with TrialGains(device, COMMAND, proposal.changed, unlock) as trial:
        measured = measure(device, AXES[proposal.axis], stimulus, LIMITS, hold_other=True)
        gain_db = 20 * np.log10(np.abs(measured.loop[measured.sharp]))
        tried = Tried(measured, judge(proposal.design, proposal.requirements, measured.margins, float(gain_db[-1])))
        if tried.kept:
            trial.keep()
    return tried


def result_files(folder: Path, axis: int) -> list[Path]:
    """All that a tuning writes into the folder of its identification."""
    return [folder / name for name in (*DESIGN_FILES, PAGE, active_name(axis))]


def active_name(axis: int) -> str:
    """Of the gains file with the gains in effect afterwards."""
    return f"{AXES[axis]}-active.toml"


def keep_design(work: Path, folder: Path) -> None:
    """Copies the files of the design; raises InputError."""
    try:
        for name in DESIGN_FILES:
            shutil.copyfile(work / name, folder / name)
    except OSError as error:
        raise InputError(f"{error.filename}: cannot be written: {error.strerror}.") from error


def write_files(folder: Path, device: Device, proposal: Proposal, tried: Tried) -> list[Path]:
    """The report, and the gains that are active now."""
    name = AXES[proposal.axis]
    active = folder / active_name(proposal.axis)
    write_gains(active, read_values(device, of_axis(device.schema.tunable, name)), about(device))
    return [_write_page(folder, name, proposal, tried), active]


def _write_page(folder: Path, axis: str, proposal: Proposal, tried: Tried) -> Path:
    """The pictures take a second to import."""
    from ..show.tune_report import LoopComparison, write_tune_report

    measured, design = tried.measured, proposal.design
    sharp = measured.sharp
    comparison = LoopComparison(
        measured.closed.frequency_hz[sharp], measured.loop[sharp],
        measured.loop_with(loop_gains(proposal.present, measured.gains))[sharp], design.frequency_hz, design.loop,
    )  # fmt: skip
    path = folder / PAGE
    notes = ["Predicted: " + predicted_text(design), *design.notes]
    write_tune_report(path, axis, proposal.present, proposal.changed, comparison, tried.verdicts, notes)
    return path


def loop_gains(present: dict[Parameter, Value], measured: SpeedLoopGains) -> SpeedLoopGains:
    """The controller's gains as they were before, from the parameters that were read then."""
    places = {
        "proportional": (0x2000, 1), "integral": (0x2000, 2), "setpoint_weight": (0x2000, 3),
        "feedforward_inertia": (0x2000, 5),
        "observer_inertia": (0x2020, 2), "observer_viscous": (0x2020, 3), "observer_bandwidth": (0x2020, 4),
        "notch_hz": (0x2040, 1), "notch_width_hz": (0x2040, 2), "notch_depth": (0x2040, 3), "lowpass_hz": (0x2040, 4),
        "lowpass_damping": (0x2040, 5), "observer_on": (0x2020, 1),
    }  # fmt: skip
    by_place = {(p.index & ~AXIS_SHIFT, p.sub): value for p, value in present.items()}
    values: dict[str, Any] = {name: by_place[place] for name, place in places.items()}
    return replace(measured, **values | {"observer_on": values["observer_on"] == 1})
