# SPDX-License-Identifier: Apache-2.0
"""get, set, undo and explain: single parameters."""

from __future__ import annotations

import re
from typing import Any

import click

from ..errors import InputError, Refused
from ..gains.tuning import APPLY, OVERRIDE, REVERT, UNDO, Change, Tuning, command_set, set_state, staged_axes, undo_last
from ..link.device import Device
from ..objects.access_lock import unlocked
from ..objects.fault_table import find_faults
from ..objects.parameter import AXES, TYPES, Parameter, Value
from ..objects.schema import Schema, parse_index
from ..session import NameType, Session, axis_choice, axis_option, common, override_option, unlock_option
from ..units import number
from .faults import explain_code, show_code

NOT_IN_FORCE = "staged, not active yet"


def parameter_at(device: Device, text: str, axis: str | None, kind: str | None = None) -> Parameter:
    """The parameter of a name or index; an index works also with a schema that does not fit."""
    at = parse_index(text)
    if at is None:
        return device.schema.find(text, axis)
    known = device.any_schema.by_index(*at) if device.schema_fits else None
    if kind is None and known is not None:
        return known
    if kind is None and not device.schema_fits:
        raise InputError(f"{text} needs --type, one of {', '.join(TYPES)}: {device.mismatch}")
    if kind is None:
        raise InputError(
            f"no object {text} in {device.any_schema.origin}; give its --type to read it anyway."
        )
    return Parameter(name=text, title=text, index=at[0], sub=at[1], type=kind, access="rw")


def as_json(parameter: Parameter, value: Value | None) -> dict[str, Any]:
    """One parameter with its value, for --json."""
    return {
        "name": parameter.name,
        "index": parameter.where,
        "value": value,
        "unit": parameter.unit,
        "type": parameter.type,
    }


@click.command(short_help="Show values from the device.")
@click.argument("names", nargs=-1, type=NameType(), metavar="[NAME|GROUP|0xINDEX:SUB]...")
@axis_option
@click.option(
    "--type", "kind", type=click.Choice(TYPES),
    help="Type of an object given by index that is not in parameters.json."
)
@common
def get(session: Session, names: tuple[str, ...], axis: str | None, kind: str | None) -> None:
    """Show values from the device; without a name, all gains."""
    with session.connect() as device:
        if names and all(parse_index(name) for name in names):
            chosen = [parameter_at(device, name, axis, kind) for name in names]
        elif names:
            chosen = [p for p in device.schema.select(names, axis) if p.readable]
        else:
            chosen = [p for p in device.schema.tunable if axis is None or p.name.startswith(axis + ".")]
        rows: list[tuple[Parameter, Value | None]] = []
        with session.out.progress() as bar:
            task = bar.add_task("reading", total=len(chosen))
            for parameter in chosen:
                rows.append((parameter, read_or_none(device, parameter, single=len(chosen) == 1)))
                bar.advance(task)
        pending = staged_axes(device) if any(p.staged for p in chosen) else set()
    session.out.json([as_json(p, v) | {"in_force": not (p.staged and p.axis in pending)} for p, v in rows])
    if len(rows) == 1:
        parameter, value = rows[0]
        session.out.say(f"{parameter.name} = {number(value)} {parameter.unit}".rstrip())
    else:
        table = [(p.where, p.name, number(v), p.unit, number(p.default)) for p, v in rows]
        session.out.table(["index", "name", ("value", "right"), "unit", ("default", "right")], table)
    for number_of_axis in sorted(pending & {p.axis for p in chosen if p.staged and p.axis is not None}):
        session.out.note(f"{AXES[number_of_axis]}: these are the staged values; they differ from the active values.")


def read_or_none(device: Device, parameter: Parameter, single: bool) -> Value | None:
    """In a list, an object that cannot be read now shows as a dash; alone, it is an error."""
    try:
        return device.read(parameter)
    except Refused:
        if single:
            raise
        return None


def parse_assignments(
    device: Device, words: tuple[str, ...], axis: str | None, kind: str | None
) -> dict[Parameter, Value]:
    """NAME=VALUE ... or NAME VALUE; every value is checked before the first is sent."""
    if len(words) == 2 and "=" not in words[0]:
        words = (f"{words[0]}={words[1]}",)
    values: dict[Parameter, Value] = {}
    for word in words:
        name, equals, text = word.partition("=")
        if not equals:
            parameter = parameter_at(device, name, axis, kind)  # which may name the intended parameter
            limits = f", {parameter.limits()} {parameter.unit}".rstrip() if parameter.limits() else ""
            raise InputError(f"'{word}' has no value: expected {word}=VALUE{limits}.")
        parameter = parameter_at(device, name, axis, kind)
        values[parameter] = parameter.wanted(text)
    return values


def show_changes(session: Session, changes: list[Change], staged_only: bool = False) -> None:
    """Old and new value of each write."""
    session.out.json(
        [
            as_json(c.parameter, c.new) | {"old": c.old, "in_force": not (staged_only and c.parameter.staged)}
            for c in changes
        ]
    )
    for change in changes:
        waits = f"  ({NOT_IN_FORCE})" if staged_only and change.parameter.staged else ""
        same = "  (unchanged)" if change.old == change.new else ""
        old = f"  was {number(change.old)}" if change.old is not None and not same else ""
        session.out.say(
            f"{change.parameter.name} = {number(change.new)} {change.parameter.unit}{old}{same}{waits}".replace(
                "  ", "  "
            )
        )


class SetCommand(click.Command):
    """'set NAME -5': a text like a negative number is the value of the name before it, not an option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        words: list[str] = []
        for word in args:
            if words and not words[-1].startswith("-") and "=" not in words[-1] and re.match(r"-(\.?\d|inf|nan)", word):
                words[-1] = f"{words[-1]}={word}"
            else:
                words.append(word)
        return super().parse_args(ctx, words)


@click.command("set", cls=SetCommand, short_help="Change values; all take effect in the same tick.")
@click.argument("assignments", nargs=-1, type=NameType(assignment=True), metavar="NAME=VALUE... | NAME VALUE")
@axis_option
@click.option("--stage", is_flag=True, help="Only stage the values; 'set --apply' activates all staged values later.")
@click.option(
    "--apply", "apply_staged", is_flag=True, help="Activate all staged values, those staged earlier and those given now."
)
@unlock_option
@override_option
@click.option(
    "--type", "kind", type=click.Choice(TYPES),
    help="Type of an object given by index that is not in parameters.json."
)
@common
def set_(
    session: Session, assignments: tuple[str, ...], axis: str | None, stage: bool, apply_staged: bool, unlock: bool,
    override: bool, kind: str | None,
) -> None:  # fmt: skip
    """Set parameters: all values are staged, applied in one tick, and read back.

    A value may have a unit: 'set azimuth.position_loop.rate_limit_of_the_outer_loops="5 deg/s"'.
    """
    if stage and apply_staged:
        raise InputError("--stage and --apply exclude each other.")
    if not assignments and not apply_staged:
        raise InputError("nothing to set: expected NAME=VALUE.")
    if stage and override:
        raise InputError("--stage applies nothing: give --override-gain-check with 'servoctl set --apply'.")
    with session.connect() as device:
        values = parse_assignments(device, assignments, axis, kind)
        changes: list[Change] = []
        if values:
            changes = Tuning(device, "set").write(
                values, apply=not stage, on_top=stage or apply_staged, unlock=unlock, override=override
            )
        if apply_staged:
            for number_of_axis in sorted(staged_axes(device)):
                if axis in (None, AXES[number_of_axis]):
                    with unlocked(device, unlock or override, with_torque=True):
                        command_set(device, number_of_axis, OVERRIDE if override else APPLY)
                    session.out.say(f"{AXES[number_of_axis]}: the staged values are now active.")
    show_changes(session, changes, staged_only=stage)


@click.command(short_help="Undo the last change.")
@axis_choice("Axis of --staged or --device.")
@click.option("--staged", is_flag=True, help="Discard staged values that are not active.")
@click.option(
    "--device", "by_device", is_flag=True, help="Use the device's own undo: restore the set before the last apply."
)
@click.option("--list", "listing", is_flag=True, help="Show the last writes in the journal and change nothing.")
@unlock_option
@common
def undo(session: Session, axis: str | None, staged: bool, by_device: bool, listing: bool, unlock: bool) -> None:
    """Undo the last change that this computer's journal recorded.

    If another client has changed one of the values since, nothing is undone.
    """
    if staged and by_device:
        raise InputError("--staged and --device exclude each other.")
    with session.connect() as device:
        if staged or by_device:
            _undo_in_device(session, device, axis, REVERT if staged else UNDO)
            return
        tuning = Tuning(device, "undo")
        if listing:
            _list_journal(session, tuning)
            return
        show_changes(session, undo_last(tuning, unlock))


def _undo_in_device(session: Session, device: Device, axis: str | None, command: int) -> None:
    axes = [AXES.index(axis)] if axis else [a for a in range(len(AXES)) if set_state(device, a) is not None]
    if not axes:
        raise InputError("this device has no staged parameter set (object 0x2070).")
    if command == UNDO and axis is None and len(axes) > 1:
        raise InputError("the device's undo works on one axis: choose it with --axis.")
    tuning = Tuning(device, "undo")
    gains = [p for p in device.schema if p.staged and p.axis in axes and p.type != "DOMAIN" and p.writable]
    before = {p: device.read(p) for p in gains}
    for number_of_axis in axes:
        command_set(device, number_of_axis, command)
    changes = [Change(p, before[p], device.read(p)) for p in gains]
    changes = [c for c in changes if c.old != c.new]
    for change in changes if command == UNDO else []:
        tuning.note(change.parameter, change.old, change.new)
    show_changes(session, changes)
    if not changes:
        session.out.say("nothing was staged." if command == REVERT else "nothing changed.")


def _list_journal(session: Session, tuning: Tuning) -> None:
    entries = tuning.journal.entries()[-30:]
    session.out.json([entry.__dict__ for entry in entries])
    rows = [(e.time, e.command, e.name, number(e.old), number(e.new), e.unit) for e in entries]
    session.out.table(
        ["time", "command", "name", ("old", "right"), ("new", "right"), "unit"], rows, str(tuning.journal.path)
    )


@click.command(short_help="Explain a parameter or a fault code.")
@click.argument("names", nargs=-1, type=NameType(), metavar="[NAME|GROUP|INDEX:SUB|FAULT CODE]...")
@axis_option
@common
def explain(session: Session, names: tuple[str, ...], axis: str | None) -> None:
    """Explain a parameter or a fault code; without a name, list all parameters. Needs no device."""
    table = find_faults([session.parameters])
    codes = [found for name in names if (found := explain_code(name, table)) is not None]
    if names and len(codes) == len(names):
        for found in codes:
            session.out.json(found)
            show_code(session.out, found)
        return
    schema = session.file_schema()
    chosen = (
        schema.select(names, axis) if names else [p for p in schema if axis is None or p.name.startswith(axis + ".")]
    )
    session.out.json([_explained(p) for p in chosen])
    if len(chosen) > 5:
        session.out.table(
            ["index", "name", "unit", "meaning"], [(p.where, p.name, p.unit, p.help) for p in chosen]
        )
        session.out.say("For range, default and details of one parameter: servoctl explain NAME")
        return
    for parameter in chosen:
        _show_explained(session, schema, parameter)


def _explained(p: Parameter) -> dict[str, Any]:
    return as_json(p, None) | {
        "title": p.title, "help": p.help, "low": p.low, "high": p.high, "default": p.default, "access": p.access,
        "stored": p.stored, "staged": p.staged, "guarded": p.guarded,
    }  # fmt: skip


def _show_explained(session: Session, schema: Schema, p: Parameter) -> None:
    out = session.out
    out.say(p.name, style="bold")
    out.say(f"  {p.title}: {p.help}" if p.help else f"  {p.title}")
    head = schema.by_index(p.index, 0)
    if head is not None and head is not p:
        out.say(f"  part of     {head.title}: {head.help}")
    out.say(f"  object      {p.where}, {p.type}, {p.access}")
    if p.limits():
        out.say(f"  range       {p.limits()} {p.unit}".rstrip())
    if p.default is not None:
        out.say(f"  default     {number(p.default)} {p.unit}".rstrip())
    if p.guarded:
        out.say("  guarded: can be written with --unlock only")
    if p.staged:
        out.say(
            "  becomes active when applied ('servoctl set' applies), together with other staged values; stored by"
            " 'servoctl store'"
        )
    elif p.stored:
        out.say("  becomes active at once; stored by 'servoctl store'")
