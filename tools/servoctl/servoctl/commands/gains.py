"""diff, save, restore and store: the gains file and the device."""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import click

from ..device import Device
from ..errors import ExitCode, NotVerified, Refused
from ..gains_file import describe_difference, read_gains, write_gains
from ..journal import Journal
from ..parameter import AXES, Parameter, Value
from ..session import Session, common, only_axis_option, override_option, unlock_option
from ..tuning import Tuning, set_state
from ..tuning import store as store_on_device
from ..units import number
from .parameters import as_json, show_changes, staged_axes

FILE = click.Path(path_type=Path, dir_okay=False)


def read_all(session: Session, device: Device, parameters: list[Parameter]) -> dict[Parameter, Value]:
    """Values from the device, with a progress bar."""
    values: dict[Parameter, Value] = {}
    with session.out.progress() as bar:
        task = bar.add_task("reading", total=len(parameters))
        for parameter in parameters:
            values[parameter] = device.read(parameter)
            bar.advance(task)
    return values


def about(device: Device) -> dict[str, Any]:
    """The table [device] of a gains file."""
    identity = device.identity()
    schema = identity["schema"]
    return {
        "name": identity["name"],
        "node": device.node_id,
        "serial": identity["serial"],
        "firmware": identity["firmware"] or identity["software"],
        "schema": None if schema is None else f"0x{schema:08X}",
    }


def of_axis(parameters: list[Parameter], axis: str | None) -> list[Parameter]:
    """Those of one axis, or all."""
    return [p for p in parameters if axis is None or p.name.startswith(axis + ".")]


@click.command(short_help="Compare the device with a gains file.")
@click.argument("file", type=FILE)
@only_axis_option
@common
def diff(session: Session, file: Path, axis: str | None) -> int:
    """Compare the device with a gains FILE and show the differences. Exit code 1 if there are any."""
    with session.connect() as device:
        wanted = read_gains(file, device.schema).values
        wanted = {p: v for p, v in wanted.items() if axis is None or p.name.startswith(axis + ".")}
        found = read_all(session, device, list(wanted))
        pending = staged_axes(device)
        absent = [p for p in of_axis(device.schema.tunable, axis) if p not in wanted]
    different = [p for p in wanted if found[p] != wanted[p]]
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
    for number_of_axis in sorted(pending):
        session.out.note(
            f"{AXES[number_of_axis]}: the staged values were compared; they differ from the active values."
        )
    return int(ExitCode.DIFFERENT) if different else 0


def _relative(device: Value, file: Value) -> str:
    """The file's value relative to the device's."""
    if isinstance(device, str | bytes | bool) or isinstance(file, str | bytes | bool) or device == 0:
        return ""
    return f"{100.0 * (file - device) / abs(device):+.1f} %"


@click.command(short_help="Save the device's gains to a file.")
@click.argument("file", type=FILE, required=False)
@only_axis_option
@common
def save(session: Session, file: Path | None, axis: str | None) -> None:
    """Save the device's gains to FILE (default: gains-DATE.toml). Comments in an existing file are preserved."""
    path = file or Path(f"gains-{datetime.now(timezone.utc).strftime('%Y%m%dT%H%M%SZ')}.toml")
    with session.connect() as device:
        pending = staged_axes(device)
        if pending:
            names = " and ".join(AXES[a] for a in sorted(pending))
            raise Refused(
                f"{names}: the staged values differ from the active values, so it is unclear which to save. Run"
                " 'servoctl set --apply' or 'servoctl undo --staged' first."
            )
        values = read_all(session, device, of_axis(device.schema.tunable, axis))
        write_gains(path, values, about(device))
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
        wanted = read_gains(file, device.schema).values
        wanted = {p: v for p, v in wanted.items() if axis is None or p.name.startswith(axis + ".")}
        found = read_all(session, device, list(wanted))
        changing = {p: v for p, v in wanted.items() if found[p] != v}
        if dry_run:
            session.out.json([as_json(p, found[p]) | {"file": v} for p, v in changing.items()])
            for parameter, value in changing.items():
                session.out.say(describe_difference(parameter, found[parameter], value))
            session.out.say(f"{len(changing)} of {len(wanted)} gains would change.")
            return
        with session.out.progress() as bar:
            task = bar.add_task("staging", total=len(changing))
            changes = (
                Tuning(device, "restore").write(
                    changing, progress=lambda _p: bar.advance(task), unlock=unlock, override=override
                )
                if changing
                else []
            )
        after = read_all(session, device, list(wanted))
    wrong = [p for p in wanted if after[p] != wanted[p]]
    if wrong:
        raise NotVerified("after restoring, " + describe_difference(wrong[0], after[wrong[0]], wanted[wrong[0]]) + ".")
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
    pending = staged_axes(device)
    if pending:
        names = " and ".join(AXES[a] for a in sorted(pending))
        raise Refused(f"{names}: staged values are not active and would not be stored: apply or revert them first.")
    backup = Journal(device.node_id, device.serial_number()).backup_path()
    values = read_all(session, device, device.schema.tunable)
    write_gains(backup, values, about(device))
    session.out.say(f"backup of {len(values)} gains: {backup}")
    with session.out.console.status("storing") if not session.out.as_json else session.out.errors.status("storing"):
        store_on_device(device)
    return backup
