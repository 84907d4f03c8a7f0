# SPDX-License-Identifier: Apache-2.0
"""monitor and log: the state of the node, as a live table or as a file."""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager
from datetime import datetime
from pathlib import Path
from typing import Any, TextIO

import can
import click
from rich import box
from rich.console import Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ..drive.power import mode_name, state_of, status_flags
from ..errors import ConnectionFailed, InputError
from ..link.bus import parse_bus
from ..link.listener import Listener, Misfit
from ..link.pdo_ears import Ear, hear, mappings_text
from ..link.pdo_mapping import EXTENDED
from ..objects.fault_table import FaultTable, find_faults
from ..objects.parameter import AXES, AXIS_SHIFT, Parameter, Value
from ..session import NameType, Session, axis_option, common
from ..show.output_files import overwrite_option
from ..units import POSITION_COUNTS_PER_RAD, RATE_COUNTS_PER_RAD_S, degrees, number
from .parameters import read_or_none
from .quantity import DURATION, Quantity

REFRESH_S = 0.2
STALE_S = 1.0


passive_option = click.option(
    "--passive", is_flag=True, help="Listen only, send nothing: PDOs are decoded with the mapping as delivered."
)


def _hear(session: Session, passive: bool) -> AbstractContextManager[Ear]:
    return hear(parse_bus(session.bus), session.node, session.bitrate, session.parameters, passive)


@click.command(short_help="Show state, angles and faults live.")
@click.option("--for", "duration", type=DURATION, help="Stop after this time (s); default: until Ctrl-C.")
@passive_option
@common
def monitor(session: Session, duration: float | None, passive: bool) -> None:
    """Show the state of the node live, from its heartbeats, PDOs and emergencies.

    The mapping of the PDOs is read by SDO at the start, and when it may have changed. With --passive nothing is sent. A frame
    that does not fit its mapping is not decoded, and is shown as such.

    Angles are those of the device: without a limited travel from -32 to 32 turns (607B), with a jump of 64 turns at the ends.

    With --json prints one line every 0.2 s. The bus load counts every frame received, with its stuff bits and the gap after it,
    at the bit rate of the connection; it cannot count repeated frames.
    """
    with _hear(session, passive) as ear:
        live = None if session.out.as_json else Live(console=session.out.console, auto_refresh=False)
        try:
            if live:
                live.start()
            elif ear.warning:
                session.out.note(ear.warning)
            _show_live(session, ear, live, duration)
        except KeyboardInterrupt:
            pass  # the usual end
        finally:
            if live:
                live.stop()


def _show_live(session: Session, ear: Ear, live: Live | None, duration: float | None) -> None:
    listener = ear.listener
    begun = shown = time.monotonic()
    frames, bits, bit_rate = listener.frames, listener.bits, session.bit_rate()
    faults = find_faults([session.parameters])
    while duration is None or time.monotonic() - begun < duration:
        message = ear.recv(0.05)
        if message is not None:
            listener.take(message)
        now = time.monotonic()
        if now - shown < REFRESH_S:
            continue
        rate, bits_per_s = (listener.frames - frames) / (now - shown), (listener.bits - bits) / (now - shown)
        load = bits_per_s / bit_rate if bit_rate else None
        shown, frames, bits = now, listener.frames, listener.bits
        if live:
            live.update(render(ear, faults, rate, load), refresh=True)
        else:
            session.out.json(snapshot(listener) | {
                "frames_per_s": round(rate, 1), "bits_per_s": round(bits_per_s), "bit_rate": bit_rate,
                "load": None if load is None else round(load, 4), "mapping": ear.mapping,
            })  # fmt: skip


def axis_values(listener: Listener, axis: int) -> dict[str, Any]:
    """Values of an axis from its PDOs: ° and °/s, % of rated torque; None for values that did not come within a
    second."""
    now = time.monotonic()

    def value(index: int) -> int | None:
        for parameter, observed in listener.values.items():
            if parameter.index == index + AXIS_SHIFT * axis and parameter.sub == 0 and now - observed.time_s < STALE_S:
                return observed.value if isinstance(observed.value, int) else None
        return None

    status, mode, position, rate, torque, error = (value(i) for i in (0x6041, 0x6061, 0x6064, 0x606C, 0x6077, 0x603F))
    return {
        "axis": AXES[axis],
        "state": None if status is None else state_of(status),
        "flags": [] if status is None else status_flags(status),
        "mode": None if mode is None else mode_name(mode),
        "position_deg": None if position is None else degrees(position / POSITION_COUNTS_PER_RAD),
        "rate_deg_s": None if rate is None else degrees(rate / RATE_COUNTS_PER_RAD_S),
        "torque_percent": None if torque is None else torque / 10.0,
        "error": error,
    }


def snapshot(listener: Listener) -> dict[str, Any]:
    """Everything that is known now."""
    age = None if listener.heartbeat_s is None else round(time.monotonic() - listener.heartbeat_s, 3)
    return {
        "time": time.time(),
        "node": listener.node_id,
        "nmt": listener.state,
        "heartbeat_age_s": age,
        "axes": [axis_values(listener, axis) for axis in range(len(AXES))],
        "not_decoded": [
            {"cob_id": f"{identifier & 0x1FFFFFFF:X}", "length": found.length, "expected": found.expected, "frames": found.frames}
            for identifier, found in listener.misfits.items()
        ],
        "emergencies": [{"time": t, "code": c, "register": r} for t, c, r in listener.emergencies],
    }


def _load_text(load: float | None) -> str:
    return "bus load unknown: give --bitrate" if load is None else f"bus load {100 * load:.1f} %"


def render(ear: Ear, faults: FaultTable, rate: float, load: float | None) -> Group:
    """The live table; `load` is the share of the bus, None if its bit rate is unknown."""
    listener = ear.listener
    data = snapshot(listener)
    age = data["heartbeat_age_s"]
    beat = "no heartbeat yet" if age is None else f"heartbeat {1e3 * age:.0f} ms ago"
    late = age is None or age > STALE_S
    head = Text(
        f"node {listener.node_id}  {data['nmt']}  {beat}  {rate:.0f} frames/s  {_load_text(load)}",
        style="red" if late else "",
    )
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for name, right, width in (  # which fit 80 columns; longer states and flags break between words
        ("axis", False, 7), ("state", False, 9), ("mode", False, 4), ("angle °", True, 9), ("rate °/s", True, 8),
        ("torque %", True, 8), ("error", False, 5), ("flags", False, 12),
    ):  # fmt: skip
        table.add_column(name, justify="right" if right else "left", min_width=width, no_wrap=right)

    def shown(value: float | None, places: int) -> str:
        return "–" if value is None else f"{value:.{places}f}"

    for axis in data["axes"]:
        faulty = axis["state"] in ("fault", "fault reaction active")
        style = "red" if faulty else "green" if axis["state"] == "operation enabled" else ""
        error = f"{axis['error']:04X}" if axis["error"] else ""
        table.add_row(
            axis["axis"], Text(axis["state"] or "–", style=style), axis["mode"] or "–", shown(axis["position_deg"], 4),
            shown(axis["rate_deg_s"], 4), shown(axis["torque_percent"], 1), Text(error, style="red"), ", ".join(axis["flags"]),
        )  # fmt: skip
    lines: list[Any] = [head, table]
    if data["nmt"] != "operational":
        lines.append(
            Text("No PDOs: the node is not operational ('servoctl state AXIS enable' makes it operational).", style="yellow")
        )
    lines += [Text(text, style="yellow") for text in _mapping_lines(ear)]
    for when, code, register in list(listener.emergencies)[-4:]:
        clock = datetime.fromtimestamp(when).strftime("%H:%M:%S")
        text = (
            f"{clock}  emergency {code:04X} {faults.meaning(code)}, register {register:02X}; servoctl explain {code:04X}"
            if code
            else f"{clock}  errors cleared, register {register:02X}"
        )
        lines.append(Text(text, style="red" if code else ""))
    lines += [Text(f"          {cure}", style="yellow") for cure in _newest_cure(ear, faults)]
    return Group(*lines)


def _newest_cure(ear: Ear, faults: FaultTable) -> list[str]:
    """What ends the newest error, if its code has one meaning only."""
    codes = [code for _, code, _ in list(ear.listener.emergencies)[-1:]]
    found = [faults.words(code) for code in codes if code]
    return [words[0].cure for words in found if len(words) == 1 and words[0].cure]


def _mapping_lines(ear: Ear) -> list[str]:
    misfits = [misfit_text(identifier, found) for identifier, found in ear.listener.misfits.items()]
    return [*([ear.warning] if ear.warning else []), *misfits]


def misfit_text(identifier: int, found: Misfit) -> str:
    """Of one PDO."""
    return (
        f"PDO {identifier & 0x1FFFFFFF:X} is not decoded: it has {found.length} bytes, but its mapping here has {found.expected}."
    )


@click.command(short_help="Log values as CSV.")
@click.argument("names", nargs=-1, type=NameType(), metavar="[NAME|GROUP]...")
@axis_option
@click.option(
    "--rate", type=Quantity("Hz", low=0.01, high=200.0), default="10", show_default=True,
    help="Rows per second (Hz), if NAMEs are given."
)
@click.option("--for", "duration", type=DURATION, help="Stop after this time (s); default: until Ctrl-C.")
@click.option(
    "--out", "file", type=click.Path(path_type=Path, dir_okay=False), help="CSV file (default: standard output)."
)
@passive_option
@overwrite_option
@common
def log(
    session: Session, names: tuple[str, ...], axis: str | None, rate: float, duration: float | None, file: Path | None,
    passive: bool, overwrite: bool,
) -> None:  # fmt: skip
    """Log values as CSV. NAMEs are read by SDO at --rate; without NAMEs every received PDO is logged.

    The mapping of the PDOs is read by SDO, or with --passive assumed to be as delivered. A frame that does not fit its mapping is
    not decoded: the column "not decoded" has its identifier and bytes.

    With --json prints one JSON object per row. Column names include units; values without a unit are raw counts of the
    device. Angles are those of the device, too: without a limited travel from -32 to 32 turns (607B), with a jump of 64 turns at
    the ends.
    """
    if names and passive:
        raise InputError("--passive sends nothing, but values with NAMEs are read by SDO: give one of the two.")
    if file:
        session.check_new([file], overwrite, "--out")
    writer = _RowWriter(file, session.out.as_json)
    rows = 0
    try:
        source = _read_rows(session, names, axis, rate) if names else _heard_rows(session, passive)
        begun = None
        for row in source:
            begun = begun or time.monotonic()
            writer.write({"time_s": round(time.monotonic() - begun, 4), **row} if row else {})
            rows += bool(row)
            if duration is not None and time.monotonic() - begun >= duration:
                break
    except KeyboardInterrupt:
        pass  # the usual end
    finally:
        writer.close()
    if file and rows:
        session.out.say(f"{rows} rows in {file}.")
    if rows == 0:
        raise ConnectionFailed("nothing was logged: no PDO arrived. The node sends PDOs only when it is operational.")


class _RowWriter:
    """CSV with a header of the first row's columns, or JSON lines, to a file or to standard output."""

    def __init__(self, file: Path | None, as_json: bool) -> None:
        """The file is opened by the first row: without rows, one of before stays as it was."""
        self._file = file
        self._stream: TextIO | None = None
        self._as_json = as_json
        self._csv: csv.DictWriter[str] | None = None

    def write(self, row: dict[str, Any]) -> None:
        """Empty rows only give others a chance to end."""
        import json

        if not row:
            return
        stream = self._opened()
        if self._as_json:
            print(json.dumps(row, default=repr), file=stream, flush=True)
            return
        if self._csv is None:
            self._csv = csv.DictWriter(stream, list(row), extrasaction="ignore", restval="")
            self._csv.writeheader()
        self._csv.writerow({key: number(v) if isinstance(v, float) else v for key, v in row.items()})
        stream.flush()

    def _opened(self) -> TextIO:
        if self._stream is None:
            self._stream = _open(self._file) if self._file else sys.stdout
        return self._stream

    def close(self) -> None:
        """Ends the file; standard output stays open."""
        if self._file and self._stream:
            self._stream.close()


def _open(file: Path) -> TextIO:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        return file.open("w", newline="", encoding="utf-8")
    except OSError as error:
        raise InputError(f"{file}: cannot be written: {error.strerror}.") from error


def _column(parameter: Parameter) -> str:
    return f"{parameter.name} ({parameter.unit})" if parameter.unit else parameter.name


def _read_rows(session: Session, names: tuple[str, ...], axis: str | None, rate: float) -> Any:
    with session.connect() as device:
        chosen = [p for p in device.schema.select(names, axis) if p.readable and p.type != "DOMAIN"]
        next_s = time.monotonic()
        while True:
            yield {_column(p): read_or_none(device, p, single=False) for p in chosen}
            next_s = max(next_s + 1.0 / rate, time.monotonic())
            time.sleep(next_s - time.monotonic() if next_s > time.monotonic() else 0.0)


NOT_DECODED = "not decoded"


def _heard_rows(session: Session, passive: bool) -> Iterator[dict[str, Any]]:
    """A row for each PDO, with the last value of every mapped object; an empty one when nothing came for 50 ms."""
    with _hear(session, passive) as ear:
        if ear.warning:
            session.out.note(ear.warning)
        columns = [p for mapping in ear.listener.mappings.values() for p in mapping.parameters]
        told: set[int] = set()
        mappings = ear.listener.mappings
        while True:
            if ear.listener.mappings != mappings:
                mappings = ear.listener.mappings
                session.out.note(f"the PDO mapping has changed to {mappings_text(mappings)}. The columns stay as they are.")
            message = ear.recv(0.05)
            found = ear.listener.take(message) if message is not None else {}
            misfit = "" if message is None or found else _misfit(session, ear.listener, message, told)
            yield {**_cells(ear.listener, columns), NOT_DECODED: misfit} if found or misfit else {}


def _cells(listener: Listener, columns: list[Parameter]) -> dict[str, Value | None]:
    return {_column(p): listener.values[p].value if p in listener.values else None for p in columns}


def _misfit(session: Session, listener: Listener, message: can.Message, told: set[int]) -> str:
    """Identifier and bytes of a PDO that does not fit, empty for every other frame; the first one of each is reported."""
    identifier = message.arbitration_id | (EXTENDED if message.is_extended_id else 0)
    if identifier not in listener.misfits or message.is_remote_frame or message.is_error_frame:
        return ""
    if identifier not in told:
        told.add(identifier)
        session.out.note(misfit_text(identifier, listener.misfits[identifier]))
    return f"{message.arbitration_id:X}: {bytes(message.data).hex(' ').upper()}"
