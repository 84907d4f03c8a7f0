# SPDX-License-Identifier: Apache-2.0
"""tune: gains designed from an identification, kept only if the measured loop has the margins."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from dataclasses import asdict
from functools import partial
from pathlib import Path

import click

from ..drive.drive import Drive
from ..errors import ExitCode
from ..gains import tune_run
from ..gains.loop_test import AMPLITUDE_DEG_S, BIAS_DEG_S, HIGHEST_HZ, LINES, LOWEST_HZ, PERIODS, loop_stimulus
from ..gains.tune_run import LIMITS, REQUIREMENT_KEYS, Proposal, Tried, check_reach, predicted_text, propose
from ..identify.identified import read_identified
from ..identify.identify_program import IdentifyProgram, find_identify
from ..objects.access_lock import need_unlock
from ..objects.parameter import AXES
from ..session import Session, common, unlock_option
from ..show.output_files import overwrite_option
from ..units import rounded
from .gains import read_all, store_with_backup
from .identify import PROGRAM
from .loop import measure_loop
from .motion import announce, show_files
from .parameters import as_json
from .quantity import DEGREES, FREQUENCY, RATE, Quantity, Whole

RATIO = Quantity("", above=0.0)


@click.command(short_help="Design gains from an identification and test them.")
@click.option("--axis", type=click.Choice(AXES), required=True, help="The axis to tune.")
@click.option(
    "--from", "folder", type=click.Path(path_type=Path, file_okay=False, exists=True), required=True,
    help="Folder written by 'servoctl identify'; the results are written there as well.",
)  # fmt: skip
@click.option("--bandwidth-hz", type=FREQUENCY, help="Bandwidth of the speed loop with its PI controller alone.")
@click.option("--damping", type=RATIO, help="Damping of the speed loop.")
@click.option("--setpoint-weight", type=Quantity("", low=0.0, high=1.0), help="Set-point weight.")
@click.option(
    "--setpoint-model-hz", type=Quantity("Hz", low=0.0, high=159.0),
    help="Natural frequency of the set-point model; 0: none (default: 64 for --least-error, else none).",
)  # fmt: skip
@click.option("--observer-hz", type=FREQUENCY, help="Bandwidth of the disturbance observer.")
@click.option(
    "--least-error", is_flag=True, default=None,
    help="PI, observer and fusion crossover together, for the least rate error; otherwise as fast as possible.",
)  # fmt: skip
@click.option("--disturbance-nm", type=Quantity("N m", above=0.0), help="Slow torque from outside, such as wind, rms (default: as identified).")
@click.option("--disturbance-hz", type=FREQUENCY, help="Corner frequency of this torque.")
@click.option("--gain-margin-db", type=Quantity("dB", above=0.0), help="Minimum gain margin.")
@click.option("--phase-margin-deg", type=Quantity("deg", above=0.0), help="Minimum phase margin.")
@click.option(
    "--torque-noise-nm", type=Quantity("N m", above=0.0), help="Maximum torque from sensor noise, rms at standstill."
)
@click.option("--tracking-hz", type=FREQUENCY, help="Bandwidth of the tracking loop.")
@click.option("--position-hz", type=FREQUENCY, help="Bandwidth of the position loop.")
@click.option(
    "--travel-deg", type=(DEGREES, DEGREES), metavar="LOW HIGH",
    help=(
        "Joint angles between which the axis may move (default: the node's limits, else those of the"
        " identification)."
    ),
)  # fmt: skip
@click.option("--bias", type=RATE, default=f"{BIAS_DEG_S:g}", show_default=True, help="Mean rate (°/s) while the loop is measured.")
@click.option(
    "--amplitude",
    type=RATE,
    default=f"{AMPLITUDE_DEG_S:g}",
    show_default=True,
    help=("Peak of the multisine (°/s); must be below the bias."),
)
@click.option("--high", type=FREQUENCY, default=f"{HIGHEST_HZ:g}", show_default=True, help="Highest measured frequency (Hz).")
@click.option(
    "--periods",
    type=Whole(2, 100),
    default=PERIODS,
    show_default=True,
    help=("Number of periods measured, 4 s each."),
)
@PROGRAM
@unlock_option
@click.option("--store", is_flag=True, help="Store the gains on the device if they are kept.")
@click.option("--dry-run", is_flag=True, help="Show the design, without changing gains or moving.")
@click.option("--yes", "-y", is_flag=True, help="Move without asking; required when standard input is not a terminal.")
@overwrite_option
@common
def tune(
    session: Session, axis: str, folder: Path, travel_deg: tuple[float, float] | None, bias: float, amplitude: float,
    high: float, periods: int,
    program: Path | None, unlock: bool, store: bool, overwrite: bool, dry_run: bool, yes: bool, **options: float | None,
) -> int:  # fmt: skip
    """Design gains from an identification, test them on the live axis, and keep them if the margins are met.

    The design chooses every value that no option requires. All gains are applied together, then the open loop is
    measured as in 'servoctl bode'. With --unlock, the identified plant (2056) is written too: the device checks gains
    against it. The old gains are restored on any error, on Ctrl-C, or if the gain or phase margin
    is below the required value (default: the predicted value) by more than the tolerance. 'servoctl undo' restores the
    old gains later. Exit code 1 means that the gains were not kept.
    """
    stimulus = loop_stimulus(LOWEST_HZ, high, bias, amplitude, LINES, periods)
    tune_run.check_slides(stimulus)
    if not dry_run:
        session.check_new(tune_run.result_files(folder, AXES.index(axis)), overwrite, "--from", folder / "result.json")
    requirements = {REQUIREMENT_KEYS[name]: value for name, value in options.items() if value is not None}
    identified = read_identified(folder / "result.json")
    identifier = IdentifyProgram(find_identify(program))
    with session.connect() as device, ExitStack() as stack:
        identified.check_machine(device, AXES.index(axis))
        plan = stimulus.plan(axis)
        check_reach(Drive(device, AXES.index(axis)), plan, identified, travel_deg)
        work = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        with session.out.errors.status("designing"):
            proposal = propose(
                identifier, device, identified, AXES.index(axis), work, requirements, unlock, _option_of,
                lambda device, parameters: read_all(session, device, parameters),
            )  # fmt: skip
        show_design(session, proposal)
        if not proposal.changed:
            session.out.json({"axis": axis, "kept": True, "changed": []})
            session.out.say("The device already has these gains; nothing to do.")
            return int(ExitCode.OK)
        locked = [] if unlock else proposal.locked
        if not dry_run:
            need_unlock(locked)
        if not announce(session, plan, LIMITS, device, dry_run, yes):
            for parameter in locked:
                session.out.note(f"{parameter.name} is locked: without --dry-run this command needs --unlock.")
            return int(ExitCode.OK)
        tried = tune_run.try_out(device, proposal, stimulus, unlock, partial(measure_loop, session, what="tune"))
        tune_run.keep_design(work, folder)
        files = tune_run.write_files(folder, device, proposal, tried)
        if store and tried.kept:
            store_with_backup(session, device)
    return show_result(session, axis, proposal, tried, [str(path) for path in files])


def _option_of(name: str) -> str:
    """A requirement by its name in wishes.json."""
    option = next(option for option, key in REQUIREMENT_KEYS.items() if key == name)
    return f"--{option.replace('_', '-')}"


def show_design(session: Session, proposal: Proposal) -> None:
    """Gains before and after, the predicted margins, the messages of the design, and what is left out."""
    whole = [p for p, value in proposal.design.gains.items() if p in proposal.changed or p in proposal.plant]
    rows = [
        (p.where, p.name.split(".", 1)[1], rounded(proposal.present[p]), rounded(proposal.design.gains[p]), p.unit) for p in whole
    ]
    session.out.table(["index", "name", ("before", "right"), ("after", "right"), "unit"], rows)
    session.out.say("predicted: " + predicted_text(proposal.design))
    for note in proposal.design.notes:
        session.out.say(f"- {note}")
    if proposal.plant:
        session.out.note(
            f"the identified plant ({proposal.plant[0].index:04X}) is locked and stays as it is: the device"
            " checks the gains against its old plant. With --unlock, this command writes the plant too."
        )


def show_result(session: Session, axis: str, proposal: Proposal, tried: Tried, files: list[str]) -> int:
    """Kept or not, with the reason; the exit code."""
    measured = tried.measured
    session.out.json(
        {
            "axis": axis, "kept": tried.kept, "margins": [asdict(verdict) for verdict in tried.verdicts],
            "measured": asdict(measured.margins),
            "bandwidth_hz": measured.bandwidth_hz,
            "changed": [as_json(p, value) | {"old": proposal.present[p]} for p, value in proposal.changed.items()],
            "lost": measured.lost, "files": files,
        }
    )  # fmt: skip
    for verdict in tried.verdicts:
        session.out.say(("met: " if verdict.kept else "not met: ") + verdict.text)
    if tried.kept:
        session.out.say(
            f"{axis} now has the new gains. 'servoctl store' stores them permanently, 'servoctl undo' restores the"
            " old ones."
        )
    else:
        session.out.note(f"{axis} has its old gains again: {tried.reasons}.")
    show_files(session, files, measured.lost)
    return int(ExitCode.OK if tried.kept else ExitCode.DIFFERENT)
