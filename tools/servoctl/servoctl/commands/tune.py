"""tune: gains designed from an identification, kept only if the measured loop has the margins."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from ..access_lock import need_unlock
from ..device import Device
from ..drive import Drive
from ..errors import ExitCode, InputError
from ..gain_design import Design, Verdict, design_gains, judge, parameters_of
from ..gains_file import write_gains
from ..identified import Identified, read_identified
from ..identify_program import IdentifyProgram, find_identify
from ..limits import Limits, Plan, allowed_travel
from ..loop_model import SpeedLoopGains
from ..node_limits import read_limits
from ..parameter import AXES, AXIS_SHIFT, PLANT_OBJECT, Parameter, Value
from ..session import Session, common, unlock_option
from ..trial_gains import TrialGains
from ..tuning import Tuning
from ..units import radians, rounded
from .gains import about, of_axis, read_all, store_with_backup
from .identify import PROGRAM
from .loop import LoopStimulus, MeasuredLoop, loop_stimulus, measure_loop
from .motion import announce, show_files
from .parameters import as_json
from .quantity import FREQUENCY, RATE, Quantity

RATIO = Quantity("", above=0.0)
LIMITS = Limits(radians(5.0), radians(60.0), 180.0, by_options=False)
LOWEST_HZ, LINES = 1.0, 50
REQUIREMENT_KEYS = {
    "bandwidth_hz": "speed_loop_bandwidth_hz",
    "damping": "speed_loop_damping",
    "setpoint_weight": "setpoint_weight",
    "observer_hz": "observer_bandwidth_hz",
    "gain_margin_db": "least_gain_margin_db",
    "phase_margin_deg": "least_phase_margin_deg",
    "torque_noise_nm": "most_torque_noise_nm",
    "tracking_hz": "tracking_bandwidth_hz",
    "position_hz": "position_bandwidth_hz",
}
"""Names of the options in wishes.json."""


@click.command(short_help="Design gains from an identification and test them.")
@click.option("--axis", type=click.Choice(AXES), required=True, help="The axis to tune.")
@click.option(
    "--from", "folder", type=click.Path(path_type=Path, file_okay=False, exists=True), required=True,
    help="Folder written by 'servoctl identify'; the results are written there as well.",
)  # fmt: skip
@click.option("--bandwidth-hz", type=FREQUENCY, help="Bandwidth of the speed loop with its PI controller alone.")
@click.option("--damping", type=RATIO, help="Damping of the speed loop.")
@click.option("--setpoint-weight", type=Quantity("", low=0.0, high=1.0), help="Set-point weight.")
@click.option("--observer-hz", type=FREQUENCY, help="Bandwidth of the disturbance observer.")
@click.option("--gain-margin-db", type=Quantity("dB", above=0.0), help="Minimum gain margin.")
@click.option("--phase-margin-deg", type=Quantity("deg", above=0.0), help="Minimum phase margin.")
@click.option(
    "--torque-noise-nm", type=Quantity("N m", above=0.0), help="Maximum torque from sensor noise, rms at standstill."
)
@click.option("--tracking-hz", type=FREQUENCY, help="Bandwidth of the tracking loop.")
@click.option("--position-hz", type=FREQUENCY, help="Bandwidth of the position loop.")
@click.option(
    "--travel-deg", type=float, nargs=2, metavar="LOW HIGH",
    help=(
        "Joint angles between which the axis may move (default: the node's limits, else those of the"
        " identification)."
    ),
)  # fmt: skip
@click.option("--bias", type=RATE, default="1", show_default=True, help="Mean rate (°/s) while the loop is measured.")
@click.option(
    "--amplitude",
    type=RATE,
    default="0.6",
    show_default=True,
    help=("Peak of the multisine (°/s); must be below the bias."),
)
@click.option("--high", type=FREQUENCY, default="200", show_default=True, help="Highest measured frequency (Hz).")
@click.option(
    "--periods",
    type=click.IntRange(2, 100),
    default=5,
    show_default=True,
    help=("Number of periods measured, 4 s each."),
)
@PROGRAM
@unlock_option
@click.option("--store", is_flag=True, help="Store the gains on the device if they are kept.")
@click.option("--dry-run", is_flag=True, help="Show the design, without changing gains or moving.")
@click.option("--yes", "-y", is_flag=True, help="Move without asking; required when standard input is not a terminal.")
@common
def tune(
    session: Session, axis: str, folder: Path, travel_deg: tuple[float, float] | None, bias: float, amplitude: float,
    high: float, periods: int,
    program: Path | None, unlock: bool, store: bool, dry_run: bool, yes: bool, **options: float | None,
) -> int:  # fmt: skip
    """Design gains from an identification, test them on the live axis, and keep them if the margins are met.

    The design chooses every value that no option requires. All gains are applied together, then the open loop is
    measured as in 'servoctl bode'. With --unlock, the identified plant (2056) is written too: the device checks gains
    against it. The old gains are restored on any error, on Ctrl-C, or if the gain or phase margin
    is below the required value (default: the predicted value) by more than the tolerance. 'servoctl undo' restores the
    old gains later. Exit code 1 means that the gains were not kept.
    """
    if bias == 0.0:
        raise InputError("--bias must not be 0: the loop is measured while the axis slides.")
    requirements = {REQUIREMENT_KEYS[name]: value for name, value in options.items() if value is not None}
    identified = read_identified(folder / "result.json")
    stimulus = loop_stimulus(LOWEST_HZ, high, bias, amplitude, LINES, periods)
    identifier = IdentifyProgram(find_identify(program))
    with session.connect() as device, ExitStack() as stack:
        identified.check_machine(device, AXES.index(axis))
        check_reach(Drive(device, AXES.index(axis)), stimulus.plan(axis), identified, travel_deg)
        Tuning(device, "tune").refuse_foreign_stage({AXES.index(axis)})
        present = read_all(session, device, parameters_of(device.schema, AXES.index(axis)))
        work = Path(stack.enter_context(tempfile.TemporaryDirectory())) if dry_run else folder
        with session.out.errors.status("designing"):
            try:
                design = design_gains(
                    identifier, work, identified.path, device.schema, AXES.index(axis), requirements, present
                )
            except InputError as error:
                raise InputError(in_words_of_options(str(error), work)) from error
        changed = {p: value for p, value in design.gains.items() if present[p] != value}
        show_design(session, design, present, changed)
        plant = [p for p in changed if p.index == PLANT_OBJECT + AXIS_SHIFT * AXES.index(axis)]
        if plant and not unlock:
            changed = {p: value for p, value in changed.items() if p not in plant}
            session.out.note(
                f"the identified plant ({plant[0].index:04X}) is locked and stays as it is: the device"
                " checks the gains against its old plant. With --unlock, this command writes the plant too."
            )
        if not changed:
            session.out.json({"axis": axis, "kept": True, "changed": []})
            session.out.say("The device already has these gains; nothing to do.")
            return int(ExitCode.OK)
        locked = [] if unlock else [p for p in changed if p.guarded]
        if not dry_run:
            need_unlock(locked)
        if not announce(session, stimulus.plan(axis), LIMITS, device, dry_run, yes):
            for parameter in locked:
                session.out.note(f"{parameter.name} is locked: without --dry-run this command needs --unlock.")
            return int(ExitCode.OK)
        measured, verdicts = try_out(session, device, axis, design, changed, requirements, stimulus, unlock)
        kept = all(verdict.kept for verdict in verdicts)
        active = folder / f"{axis}-active.toml"
        write_gains(active, read_all(session, device, of_axis(device.schema.tunable, axis)), about(device))
        if store and kept:
            store_with_backup(session, device)
    page = write_page_of(folder, axis, design, present, changed, measured, verdicts)
    return show_result(session, axis, changed, present, measured, verdicts, [str(page), str(active)])


def in_words_of_options(message: str, work: Path) -> str:
    """The program's message about wishes.json, in terms of the options that it was made from."""
    message = message.replace(f"{work / 'wishes.json'}: ", "")
    for option, key in REQUIREMENT_KEYS.items():
        message = message.replace(f'"{key}"', f"--{option.replace('_', '-')}")
    return message


def check_reach(drive: Drive, plan: Plan, identified: Identified, travel_deg: tuple[float, float] | None) -> None:
    """Raises InputError when the travel of the measurement is not allowed by the user, the node or the
    identification."""
    if travel_deg is None and not read_limits(drive).has_travel:
        travel_deg = identified.travel_deg
    allowed = allowed_travel(drive, travel_deg)
    allowed.check_travel(plan.axis, drive.position(), plan.backward_rad, plan.forward_rad)


def show_design(
    session: Session, design: Design, present: dict[Parameter, Value], changed: dict[Parameter, Value]
) -> None:
    """Gains before and after, the predicted margins, and the messages of the design."""
    rows = [
        (p.where, p.name.split(".", 1)[1], rounded(present[p]), rounded(value), p.unit) for p, value in changed.items()
    ]
    session.out.table(["index", "name", ("before", "right"), ("after", "right"), "unit"], rows)
    session.out.say("predicted: " + predicted_text(design))
    for note in design.notes:
        session.out.say(f"- {note}")


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
        if isinstance(value, int | float):
            parts.append(f"{name.removesuffix(ending).replace('_', ' ')} {value:.3g} {units.get(ending, '')}".rstrip())
    return ", ".join(parts)


def try_out(
    session: Session, device: Device, axis: str, design: Design, changed: dict[Parameter, Value],
    requirements: dict[str, float], stimulus: LoopStimulus, unlock: bool,
) -> tuple[MeasuredLoop, list[Verdict]]:  # fmt: skip
    """With the new gains in effect; they stay only if every verdict is good."""
    with TrialGains(device, "tune", changed, unlock) as trial:
        measured = measure_loop(session, device, axis, stimulus, LIMITS, "tune", hold_other=True)
        gain_db = 20 * np.log10(np.abs(measured.loop[measured.sharp]))
        verdicts = judge(design, requirements, measured.margins, float(gain_db[-1]))
        if all(verdict.kept for verdict in verdicts):
            trial.keep()
    return measured, verdicts


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


def write_page_of(
    folder: Path, axis: str, design: Design, present: dict[Parameter, Value], changed: dict[Parameter, Value],
    measured: MeasuredLoop, verdicts: list[Verdict],
) -> Path:  # fmt: skip
    """tune.html."""
    from ..tune_report import LoopComparison, write_tune_report

    sharp = measured.sharp
    comparison = LoopComparison(
        measured.closed.frequency_hz[sharp],
        measured.loop[sharp],
        measured.loop_with(loop_gains(present, measured.gains))[sharp],
        design.frequency_hz,
        design.loop,
    )
    path = folder / "tune.html"
    write_tune_report(
        path, axis, present, changed, comparison, verdicts, ["Predicted: " + predicted_text(design), *design.notes]
    )
    return path


def show_result(
    session: Session, axis: str, changed: dict[Parameter, Value], present: dict[Parameter, Value],
    measured: MeasuredLoop, verdicts: list[Verdict], files: list[str],
) -> int:  # fmt: skip
    """Kept or not, with the reason; the exit code."""
    kept = all(verdict.kept for verdict in verdicts)
    session.out.json(
        {
            "axis": axis, "kept": kept, "margins": [asdict(verdict) for verdict in verdicts],
            "measured": asdict(measured.margins),
            "bandwidth_hz": measured.bandwidth_hz,
            "changed": [as_json(p, value) | {"old": present[p]} for p, value in changed.items()],
            "lost": measured.lost, "files": files,
        }
    )  # fmt: skip
    for verdict in verdicts:
        session.out.say(("met: " if verdict.kept else "not met: ") + verdict.text)
    if kept:
        session.out.say(
            f"{axis} now has the new gains. 'servoctl store' stores them permanently, 'servoctl undo' restores the"
            " old ones."
        )
    else:
        session.out.note(f"{axis} has its old gains again: " + "; ".join(v.text for v in verdicts if not v.kept) + ".")
    show_files(session, files, measured.lost)
    return int(ExitCode.OK if kept else ExitCode.DIFFERENT)
