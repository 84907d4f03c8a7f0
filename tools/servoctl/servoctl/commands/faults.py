# SPDX-License-Identifier: Apache-2.0
"""faults: active faults, past faults, and their remedies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..objects.fault_log import FaultLog, LogEntry, as_json, clear_log, read_log, snapshot_files, write_snapshots
from ..objects.fault_state import read_faults, words_data
from ..objects.fault_table import REACTIONS, FaultTable, find_faults, register_names
from ..session import Session, common
from ..show.output import Output
from ..show.output_files import overwrite_option
from ..units import Shown


def explain_code(text: str, table: FaultTable) -> dict[str, Any] | None:
    """Meanings of an error code typed as 0x8611 or 8611h; None when it is no such code."""
    plain = text.lower().removeprefix("0x").removesuffix("h")
    if len(plain) != 4 or any(c not in "0123456789abcdef" for c in plain):
        return None
    code = int(plain, 16)
    found = table.words(code)
    if not found:
        return None
    return {"code": f"{code:04X}", "meaning": table.meaning(code), "faults": [words_data(words) for words in found]}


def show_code(out: Output, found: dict[str, Any]) -> None:
    """Result of `explain_code` as text."""
    for words in found["faults"]:
        number = f", fault {words['number']}" if "number" in words else ""
        out.say(f"{found['code']}{number}: {words['name']}", style="bold")
        show_words(out, words, ("detection", "when", "reaction", "cause", "check", "cure", "clear"))


TITLES = {"when": "monitored", "clear": "cleared by"}


def show_words(out: Output, words: dict[str, Any], keys: tuple[str, ...]) -> None:
    """One line for each existing key."""
    for key in keys:
        if key in words:
            text = REACTIONS.get(words[key], words[key]) if key == "reaction" else words[key]
            out.say(f"  {TITLES.get(key, key):12}{text}")


@click.command(short_help="Show present and past faults, with cause and remedy.")
@click.option("--clear", is_flag=True, help="Clear the history (1003) and the fault log (3020); active faults stay.")
@click.option(
    "--csv", "folder", type=click.Path(path_type=Path, file_okay=False), metavar="FOLDER",
    help="Write the signals recorded before each logged fault into files.",
)  # fmt: skip
@click.option(
    "--snapshots", is_flag=True, help="Show the recorded signals of all logged faults, not only of the newest."
)
@overwrite_option
@common
def faults(session: Session, clear: bool, folder: Path | None, snapshots: bool, overwrite: bool) -> None:
    """Show active faults, the error history and the fault log, with cause, check and cure.

    The history (1003) has the last eight errors since start-up, without times. The fault log (3020) has the last eight
    faults with their times and the signals of the ticks before. With both --csv and --clear, the files are written
    first.
    """
    files: list[Path] = []
    with session.connect() as device:
        table = find_faults([device.any_schema.source])
        if folder is not None:
            files = _write(session, read_log(device, table), folder, overwrite)
        if clear:
            device.write_int(0x1003, 0, 0, 1)
            clear_log(device)
        found = read_faults(device, table)
        log = read_log(device, table)
    session.out.json(found | {"log": None if log is None else as_json(log), "files": [str(path) for path in files]})
    _show_now(session.out, found)
    _show_log(session.out, log, snapshots)
    for path in files:
        session.out.say(f"written: {path}")
    _show_advice(session.out, found, table, log)


def _write(session: Session, log: FaultLog | None, folder: Path, overwrite: bool) -> list[Path]:
    """All files, or none if one of them must not be replaced."""
    if log is None:
        return []
    session.check_new(snapshot_files(log, folder), overwrite, "--csv")
    return write_snapshots(log, folder)


def _show_now(out: Output, found: dict[str, Any]) -> None:
    kinds = ", ".join(register_names(found["register"])) or "none"
    out.say(f"error register 1001: {found['register']:02X} ({kinds})")
    for axis in found["axes"]:
        out.say(f"{axis['axis']:8} {axis['state']}; 603F = {axis['code']:04X}, {axis['meaning']}")
    if found["history"]:
        rows = [(str(i), f"{h['code']:04X}", h["meaning"], h["origin"]) for i, h in enumerate(found["history"], 1)]
        out.table([("", "right"), "code", "meaning", "from"], rows, "since the start, newest first")
    else:
        out.say("no errors since start-up, or the history was cleared.")


def _show_log(out: Output, log: FaultLog | None, snapshots: bool) -> None:
    if log is None:
        out.say("this node has no fault log (3020), so the times and signals of its faults are unknown.")
        return
    if not log.entries:
        out.say("the fault log (3020) is empty.")
        return
    rows = [(str(i), f"{e.age_s:.3f}", str(e.tick), e.name, e.of) for i, e in enumerate(log.entries, 1)]
    title = f"fault log, newest first; {log.count} entries since it was cleared"
    out.table([("", "right"), ("s ago", "right"), ("tick", "right"), "fault", "of"], rows, title)
    for number, entry in enumerate(log.entries if snapshots else log.entries[:1], 1):
        if entry.samples:
            _show_snapshot(out, number, entry)


def _show_snapshot(out: Output, number: int, entry: LogEntry) -> None:
    shown = [Shown(unit) for _, unit in entry.signals]
    heads = (f"{name.replace('_', ' ')} {of.unit}" for (name, _), of in zip(entry.signals, shown, strict=True))
    columns = [("tick", "right"), *((head.replace("N m", "N\N{NO-BREAK SPACE}m"), "right") for head in heads)]
    rows = [
        (str(tick), *("–" if value is None else of.text(value) for value, of in zip(row, shown, strict=True)))
        for tick, row in zip(entry.ticks(), entry.samples, strict=True)
    ]
    out.table(columns, rows, f"signals before fault {number}: {entry.name}, {entry.of}")


def _show_advice(out: Output, found: dict[str, Any], table: FaultTable, log: FaultLog | None) -> None:
    """Cause, check and cure of the active faults, otherwise of the last one."""
    active = {words["name"]: words for axis in found["axes"] for words in axis["faults"]}
    when = "active" if active else "most recent fault; no axis has a fault now"
    for words in active.values() or _newest(found, table, log):
        out.say(f"{words['name']} ({when})", style="bold")
        show_words(out, words, ("detection", "reaction", "cause", "check", "cure", "clear"))


def _newest(found: dict[str, Any], table: FaultTable, log: FaultLog | None) -> list[dict[str, Any]]:
    if log is not None and log.entries and log.entries[0].fault in table.faults:
        return [words_data(table.faults[log.entries[0].fault])]
    return [words_data(words) for h in found["history"][:1] for words in table.reported(h["code"], h["info"])]
