"""monitor and log: the state of the node, as a live table or as a file."""

from __future__ import annotations

import csv
import sys
import time
from datetime import datetime
from pathlib import Path
from typing import Any, TextIO

import click
from rich import box
from rich.console import Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ..bus import open_bus, parse_bus
from ..errors import ConnectionFailed, InputError
from ..fault_table import FaultTable, find_faults
from ..listener import Listener
from ..output_files import overwrite_option
from ..parameter import AXES, AXIS_SHIFT, Parameter
from ..power import mode_name, state_of, status_flags
from ..schema import need_schema
from ..session import NameType, Session, axis_option, common
from ..units import POSITION_COUNTS_PER_RAD, RATE_COUNTS_PER_RAD_S, degrees, number
from .parameters import read_or_none
from .quantity import DURATION, Quantity

REFRESH_S = 0.2
STALE_S = 1.0


def _listener(session: Session) -> Listener:
    return Listener(session.node, need_schema(session.parameters))


@click.command(short_help="Show state, angles and faults live.")
@click.option("--for", "duration", type=DURATION, help="Stop after this time (s); default: until Ctrl-C.")
@common
def monitor(session: Session, duration: float | None) -> None:
    """Show the state of the node live. Only receives heartbeats, PDOs and emergencies; sends nothing.

    With --json prints one line every 0.2 s. The bus load counts every frame received, with its stuff bits and the gap after it,
    at the bit rate of the connection; it cannot count repeated frames. PDOs are decoded with the default mapping in parameters.json.
    """
    listener = _listener(session)
    begun = time.monotonic()
    with open_bus(parse_bus(session.bus), session.bitrate, listen_only=True) as bus:
        live = None if session.out.as_json else Live(console=session.out.console, auto_refresh=False)
        try:
            if live:
                live.start()
            _show_live(session, listener, bus, live, begun, duration)
        except KeyboardInterrupt:
            pass  # the usual end
        finally:
            if live:
                live.stop()


def _show_live(
    session: Session, listener: Listener, bus: Any, live: Live | None, begun: float, duration: float | None
) -> None:
    shown, frames, bits, bit_rate = begun, 0, 0, session.bit_rate()
    faults = find_faults([session.parameters])
    while duration is None or time.monotonic() - begun < duration:
        message = bus.recv(0.05)
        if message is not None:
            listener.take(message)
        now = time.monotonic()
        if now - shown < REFRESH_S:
            continue
        rate, bits_per_s = (listener.frames - frames) / (now - shown), (listener.bits - bits) / (now - shown)
        load = bits_per_s / bit_rate if bit_rate else None
        shown, frames, bits = now, listener.frames, listener.bits
        if live:
            live.update(render(listener, faults, rate, load), refresh=True)
        else:
            session.out.json(snapshot(listener) | {
                "frames_per_s": round(rate, 1), "bits_per_s": round(bits_per_s), "bit_rate": bit_rate,
                "load": None if load is None else round(load, 4),
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
        "emergencies": [{"time": t, "code": c, "register": r} for t, c, r in listener.emergencies],
    }


def _load_text(load: float | None) -> str:
    return "bus load unknown: give --bitrate" if load is None else f"bus load {100 * load:.1f} %"


def render(listener: Listener, faults: FaultTable, rate: float, load: float | None) -> Group:
    """The live table; `load` is the share of the bus, None if its bit rate is unknown."""
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
    for when, code, register in list(listener.emergencies)[-4:]:
        clock = datetime.fromtimestamp(when).strftime("%H:%M:%S")
        text = (
            f"{clock}  emergency {code:04X} {faults.meaning(code)}, register {register:02X}"
            if code
            else f"{clock}  errors cleared, register {register:02X}"
        )
        lines.append(Text(text, style="red" if code else ""))
    return Group(*lines)


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
@overwrite_option
@common
def log(
    session: Session, names: tuple[str, ...], axis: str | None, rate: float, duration: float | None, file: Path | None,
    overwrite: bool,
) -> None:  # fmt: skip
    """Log values as CSV. NAMEs are read by SDO at --rate; without NAMEs every received PDO is logged.

    With --json prints one JSON object per row. Column names include units; values without a unit are raw counts of the
    device.
    """
    begun = time.monotonic()
    if file:
        session.check_new([file], overwrite, "--out")
    writer = _RowWriter(file, session.out.as_json)
    rows = 0
    try:
        source = _read_rows(session, names, axis, rate) if names else _heard_rows(session, duration)
        for row in source:
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


def _heard_rows(session: Session, duration: float | None) -> Any:
    """A row for each PDO, with the last value of every mapped object; an empty one when nothing came for 50 ms."""
    listener = _listener(session)
    columns = [p for mapping in listener.mappings.values() for p in mapping]
    with open_bus(parse_bus(session.bus), session.bitrate, listen_only=True) as bus:
        while True:
            message = bus.recv(0.05)
            if message is not None and listener.take(message):
                yield {_column(p): listener.values[p].value if p in listener.values else None for p in columns}
            else:
                yield {}
