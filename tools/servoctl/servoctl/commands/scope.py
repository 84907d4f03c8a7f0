# SPDX-License-Identifier: Apache-2.0
"""scope: captures signals inside the device, around a trigger, at up to 1 kHz."""

from __future__ import annotations

import math
import time
from pathlib import Path

import click

from ..errors import InputError, MotionError
from ..objects.parameter import AXES
from ..session import Session, common
from ..show import capture as recorder
from ..units import Shown, parse_quantity
from .motion import timed_path
from .quantity import DURATION, LEAD, Quantity


@click.command(short_help="Record signals in the device at up to 1 kHz.")
@click.argument("signals", nargs=-1, metavar="[SIGNAL]...")
@click.option("--axis", type=click.Choice(AXES), help="Axis of the signals that do not contain one.")
@click.option("--list", "listing", is_flag=True, help="List the signals; capture nothing.")
@click.option(
    "--rate", type=Quantity("Hz", low=0.02, high=1000.0), default="1000", show_default=True, help="Frames per second (Hz)."
)
@click.option("--for", "duration", type=DURATION, help="Length of the capture (s); default: as long as fits.")
@click.option("--pre", type=LEAD, default="0", help="Time before the trigger (s).")
@click.option(
    "--trigger", type=click.Choice(recorder.TRIGGERS), default="now", show_default=True,
    help="When to trigger: at once, above or below a level, on its rising or falling edge, on a state change or a fault.",
)  # fmt: skip
@click.option("--on", "source", help="Signal that triggers (default: the first one).")
@click.option(
    "--level", default="0", show_default=True, metavar="LEVEL",
    help="Trigger level, in the unit that --list shows for its signal, or with a unit, e.g. '10 mrad/s'.",
)  # fmt: skip
@click.option(
    "--timeout", type=DURATION, default="60", show_default=True, help="Longest wait for the trigger (s)."
)
@click.option("--auto", is_flag=True, help="Force the trigger after --timeout instead of giving up.")
@click.option(
    "--out", "folder", type=click.Path(path_type=Path, file_okay=False), default=".", help="Folder for PNG and CSV."
)
@common
def scope(
    session: Session, signals: tuple[str, ...], axis: str | None, listing: bool, rate: float, duration: float | None, pre: float,
    trigger: str, source: str | None, level: str, timeout: float, auto: bool, folder: Path,
) -> None:  # fmt: skip
    """Capture up to 8 SIGNALs in the device around a trigger, at up to 1 kHz. Saves a plot and a CSV file.

    The memory holds 8192 samples, e.g. two signals at 1 kHz for 4 s. A capture with --for ends after that time. It can
    run during 'servoctl move' and similar commands, and is read when they have finished. Table and plot use °/s; CSV
    and --json use rad/s, as the column names state.
    """
    with session.connect() as device:
        names = recorder.signal_names(device)
        if listing:
            session.out.json([{"number": n, "name": name} for n, name in names.items()])
            rows = [(str(n), recorder.without_unit(name), Shown(recorder.unit_of(name)).unit) for n, name in names.items()]
            session.out.table([("", "right"), "signal", "unit"], rows)
            return
        numbers = [_find(names, text, axis) for text in signals]
        on = _find(names, source, axis) if source else None
        trigger_signal = on if on is not None else numbers[0] if numbers else None
        threshold = _level(level, names[trigger_signal]) if trigger_signal is not None else 0.0
        wanted = recorder.request(names, numbers, rate, duration, pre, trigger, on, threshold)
        run = recorder.Run(device, wanted)
        result = _wait_and_read(session, run, names, timeout, auto)
    divider, before = wanted.divider, wanted.before
    time_s, traces = result.time_s, result.traces
    path = timed_path(folder, "scope")
    from ..plots import save, traces_figure, write_csv

    write_csv(path.with_suffix(".csv"), {"time_s": time_s, **traces})
    title = f"scope, {len(time_s)} frames every {divider} ms"
    save(traces_figure(title, time_s, traces, 0.0 if before else None), path.with_suffix(".png"))
    files = [str(path.with_suffix(".png")), str(path.with_suffix(".csv"))]
    statistics = {
        n: {"min": float(t.min()), "mean": float(t.mean()), "max": float(t.max()), "std": float(t.std())}
        for n, t in traces.items()
    }
    session.out.json(
        {
            "frames": len(time_s),
            "period_ms": divider,
            "triggered": result.triggered,
            "signals": statistics,
            "files": files,
        }
    )
    columns = ("min", "mean", "max", "std")
    table: list[tuple[str, ...]] = []
    for name, value in statistics.items():
        shown = Shown(recorder.unit_of(name))
        table.append((recorder.without_unit(name), shown.unit, *(shown.text(value[column]) for column in columns)))
    session.out.table(["signal", "unit", *((column, "right") for column in columns)], table)
    session.out.say("saved: " + ", ".join(files))


def _level(text: str, signal: str) -> float:
    """In the signal's SI unit; a bare number is in the displayed unit."""
    unit = recorder.unit_of(signal)
    level = parse_quantity(text, unit, Shown(unit).unit)
    if not math.isfinite(level):
        raise InputError(f"--level '{text}' is not a finite number.")
    return level


def _find(names: dict[int, str], text: str, axis: str | None) -> int:
    if axis and not text.startswith(AXES):
        of_axis = {n: name for n, name in names.items() if name.startswith(axis + ".")}
        return recorder.find_signal(of_axis, text)
    return recorder.find_signal(names, text)


def _wait_and_read(session: Session, run: recorder.Run, names: dict[int, str], timeout: float, auto: bool) -> recorder.Capture:
    """Waits for the trigger and the required frames after it, then ends the capture and reads it."""
    with session.out.progress() as bar:
        task = bar.add_task("waiting for the trigger", total=run.wanted.seconds_after)
        while (phase := run.poll()) != "done":
            if phase == "triggered":
                bar.update(task, description="capturing", completed=run.captured_s)
            elif run.waited_s > timeout and auto:
                run.force()
            elif run.waited_s > timeout:
                run.stop()
                raise MotionError(f"no trigger within {timeout:g} s; the scope was stopped.")
            time.sleep(0.02)
        bar.update(task, description="reading")
        return run.read(names)
