# SPDX-License-Identifier: Apache-2.0
"""diff, save, restore and store: the gains file and the device."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime, timezone
from pathlib import Path
from typing import TypeVar

import click

from ..errors import ExitCode
from ..gains import gain_set
from ..gains.gains_file import describe_difference, read_gains, write_gains
from ..gains.tuning import set_state
from ..link.device import Device
from ..objects.parameter import AXES, Parameter, Value
from ..session import Session, common, only_axis_option, override_option, unlock_option
from ..show.output_files import overwrite_option, unused
from ..units import number
from .parameters import as_json, show_changes

T = TypeVar("T")
FILE = click.Path(path_type=Path, dir_okay=False)


def with_bar(session: Session, what: str, total: int, work: Callable[[gain_set.Progress], T]) -> T:
    """The result of something that reports its progress."""
    with session.out.progress() as bar:
        task = bar.add_task(what, total=total)
        return work(lambda _parameter: bar.advance(task))


def read_all(session: Session, device: Device, parameters: list[Parameter]) -> dict[Parameter, Value]:
    """Values from the device, with a progress bar."""
    return with_bar(session, "reading", len(parameters), lambda progress: gain_set.read_values(device, parameters, progress))


@click.command(short_help="Compare the device with a gains file.")
@click.argument("file", type=FILE)
@only_axis_option
@common
def diff(session: Session, file: Path, axis: str | None) -> int:
    """Compare the device with a gains FILE and show the differences. Exit code 1 if there are any."""
    with session.connect() as device:
        compared = _compare(session, device, file, axis)
    wanted, found, absent, different = compared.wanted, compared.found, compared.absent, list(compared.different)
    session.out.json(
        {
            "different": [as_json(p, found[p]) | {"file": wanted[p]} for p in different],
            "compared": len(wanted),
            "not_in_file": [p.name for p in absent],
        }
    )
    rows = [(p.name, number(found[p]), number(wanted[p]), p.unit, _relative(found[p], wanted[p])) for p in different]
    if rows:
        session.out.table(["name", ("device", "right"), ("file", "right"), "unit", ("change", "right")], rows)
    session.out.say(f"{len(different)} of {len(wanted)} gains differ from {file}.")
    if absent:
        session.out.say(f"{len(absent)} gains of the device are not in the file.")
    for number_of_axis in sorted(compared.staged):
        session.out.note(
            f"{AXES[number_of_axis]}: the staged values were compared; they differ from the active values."
        )
    return int(ExitCode.DIFFERENT) if different else 0


def _compare(session: Session, device: Device, file: Path, axis: str | None) -> gain_set.Comparison:
    values = read_gains(file, device.schema).values
    count = len(gain_set.of_axis(values, axis))
    return with_bar(session, "reading", count, lambda progress: gain_set.compare(device, values, axis, progress))


def _relative(device: Value, file: Value) -> str:
    """The file's value relative to the device's."""
    if isinstance(device, str | bytes | bool) or isinstance(file, str | bytes | bool) or device == 0:
        return ""
    return f"{100.0 * (file - device) / abs(device):+.1f} %"


@click.command(short_help="Save the device's gains to a file.")
@click.argument("file", type=FILE, required=False)
@only_axis_option
@overwrite_option
@common
def save(session: Session, file: Path | None, axis: str | None, overwrite: bool) -> None:
    """Save the device's gains to FILE (default: gains-DATE.toml).

    With --overwrite FILE may exist: it gets the new values, and its comments are preserved.
    """
    path = file or unused(Path(f"gains-{datetime.now(timezone.utc).strftime('%Y%m%dT%H%M%SZ')}.toml"))
    session.check_new([path], overwrite, "FILE")
    with session.connect() as device:
        count = len(gain_set.of_axis(device.schema.tunable, axis))
        values = with_bar(session, "reading", count, lambda progress: gain_set.read_to_save(device, axis, progress))
        write_gains(path, values, gain_set.about(device))
    session.out.json({"file": str(path), "saved": len(values)})
    session.out.say(f"{len(values)} gains saved to {path}.")


@click.command(short_help="Write a gains file to the device.")
@click.argument("file", type=FILE)
@only_axis_option
@click.option("--dry-run", is_flag=True, help="Check the file and show what would change, without writing.")
@unlock_option
@override_option
@common
def restore(session: Session, file: Path, axis: str | None, dry_run: bool, unlock: bool, override: bool) -> None:
    """Write a gains FILE to the device: stages all values, applies them once per axis, reads all back."""
    with session.connect() as device:
        compared = _compare(session, device, file, axis)
        wanted, found, changing = compared.wanted, compared.found, compared.different
        if dry_run:
            session.out.json([as_json(p, found[p]) | {"file": v} for p, v in changing.items()])
            for parameter, value in changing.items():
                session.out.say(describe_difference(parameter, found[parameter], value))
            session.out.say(f"{len(changing)} of {len(wanted)} gains would change.")
            return
        changes = with_bar(
            session, "staging", len(changing),
            lambda progress: gain_set.restore(device, compared, progress, unlock=unlock, override=override),
        )  # fmt: skip
    show_changes(session, changes)
    session.out.say(
        f"{len(changes)} of {len(wanted)} gains changed; all {len(wanted)} were read back and match {file}."
    )


@click.command(short_help="Store the active values in the device's flash.")
@common
def store(session: Session) -> None:
    """Store the active values in the device's flash, so that they survive a power loss. A backup file is written
    first.
    """
    with session.connect() as device:
        backup = store_with_backup(session, device)
        crc = {AXES[a]: s.stored_crc for a in range(len(AXES)) if (s := set_state(device, a)) is not None}
    session.out.json({"backup": str(backup), "stored_crc": crc})
    values = ", ".join(f"{name} {value:08X}" for name, value in crc.items())
    session.out.say(f"stored{f'; CRC {values}' if values else ''}.")


def store_with_backup(session: Session, device: Device) -> Path:
    """Writes a backup of all gains, then stores them on the device; returns the backup's path."""
    with session.out.console.status("storing") if not session.out.as_json else session.out.errors.status("storing"):
        return gain_set.store_with_backup(device, lambda path, count: session.out.say(f"backup of {count} gains: {path}"))
