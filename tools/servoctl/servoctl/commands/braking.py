# SPDX-License-Identifier: Apache-2.0
"""braking: measures the deceleration that the axis surely has, and writes it to the protection."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from ..drive import power
from ..drive.drive import Drive
from ..errors import InputError, MotionError
from ..gains.tuning import Tuning
from ..link.device import Device
from ..motion.braking import RESERVE, Stop, analyse_stop, sure_deceleration
from ..motion.limits import Limits, Plan
from ..motion.live import LiveAxis
from ..objects.parameter import AXES, AXIS_SHIFT
from ..session import Session, common, unlock_option
from ..show import capture
from ..units import degrees, radians
from .motion import announce, motion_options, new_path, show_files
from .quantity import RATE, Quantity, Whole

Real = NDArray[np.float64]

LIMIT_OBJECT, SURE_DECELERATION, ORDERED_STOP = 0x2060, 19, 20
QUICK_STOP_DECELERATION, JERK, ACCELERATION = 0x6085, 0x60A4, 0x6083
FASTEST = 0xFFFFFFFF
STEADY_S, BEFORE_S = 0.3, 0.03


@click.command(short_help="Measure how hard the motor can brake the axis.")
@motion_options(Limits(radians(60.0), radians(120.0), 120.0))
@click.option("--rate", type=RATE, default="25", show_default=True, help="Rate from which the axis is stopped (°/s).")
@click.option(
    "--repeats", type=Whole(1, 20), default=3, show_default=True, help="Stops in each direction; the weakest counts."
)
@click.option(
    "--wind", type=Quantity("N m", low=0.0), required=True,
    help="Strongest torque of wind and imbalance that may act later, beyond that of now (N m).",
)  # fmt: skip
@click.option("--write", is_flag=True, help="Write the result to the device (2060:19, guarded: needs --unlock).")
@unlock_option
@click.option(
    "--out", "folder", type=click.Path(path_type=Path, file_okay=False), default=".", help="Folder for PNG and CSV."
)
@common
def braking(
    session: Session, axis: str, rate: float, repeats: int, wind: float, write: bool, unlock: bool, folder: Path,
    max_rate: float, max_travel: float, max_duration: float, dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Measure the deceleration that the full motor torque surely gives, for the protection of the end stops (2060:19).

    The axis runs at --rate and is stopped with the whole torque, --repeats times in each direction. Before that, move
    the other axis to where the inertia of this one is largest. The result is 80 % of the weakest stop, less the share
    of --wind. Nothing is written without --write.
    """
    if rate <= 0.0:
        raise InputError("--rate must be greater than 0; the axis runs in both directions anyway.")
    if unlock and not write:
        raise InputError("--unlock is only useful with --write.")
    number = AXES.index(axis)
    with session.connect() as device:
        drive = Drive(device, number)
        full_nm = _full_torque(device, drive)
        if wind >= full_nm:
            raise InputError(f"--wind {wind:.3g} N m is not below the motor's torque of {full_nm:.3g} N m.")
        plan = _plan(device, axis, rate, repeats)
        if not announce(session, plan, Limits(max_rate, max_travel, max_duration), device, dry_run, yes):
            return
        stops: list[Stop] = []
        path = new_path(folder, "braking", axis)
        with session.out.progress() as bar:
            task = bar.add_task("stops", total=2 * repeats)
            for count in range(2 * repeats):
                record = _stop_once(device, number, rate if count % 2 == 0 else -rate)
                time_s, joint, torque = _signals(record, axis)
                stops.append(analyse_stop(time_s, joint, torque, full_nm))
                bar.advance(task)
        sure = sure_deceleration(stops, full_nm, wind)
        parameter = device.schema.by_index(LIMIT_OBJECT + AXIS_SHIFT * number, SURE_DECELERATION)
        if parameter is None:
            raise InputError(f"node {device.node_id} has no 2060:19: its firmware does not bound the speed at the ends.")
        before = float(device.read(parameter))
        if write:
            Tuning(device, "braking").write({parameter: float(np.float32(sure))}, unlock=unlock)
    from ..plots import save, traces_figure, write_csv

    write_csv(path.with_suffix(".csv"), {"time_s": time_s, **record.traces})
    save(traces_figure(f"{axis}: last of {2 * repeats} stops", time_s, record.traces, 0.0), path.with_suffix(".png"))
    files = [str(path.with_suffix(".png")), str(path.with_suffix(".csv"))]
    session.out.json(
        {"axis": axis, "stops": [asdict(stop) for stop in stops], "full_torque_nm": full_nm, "wind_nm": wind,
         "sure_deceleration_rad_s2": sure, "before_rad_s2": before, "written": write, "files": files}
    )  # fmt: skip
    _show(session, stops, sure, before, wind, write)
    show_files(session, files, 0)


def _full_torque(device: Device, drive: Drive) -> float:
    """Of the motor, N m; raises InputError when objects of the drive allow less."""
    motor = device.axis_real(drive.axis, 0x2055, 1) * device.axis_real(drive.axis, 0x2055, 6)
    allowed = drive.torque_limit()
    if allowed < 0.999 * motor:
        raise InputError(
            f"6072, 60E0 or 60E1 limits the torque of {drive.name} to {allowed:.3g} of {motor:.3g} N m. Protection brakes"
            " with all of it: raise them for this measurement."
        )
    return motor


def _plan(device: Device, axis: str, rate: float, repeats: int) -> Plan:
    """Each run accelerates by 6083, lasts until the rate is steady, and stops with at least 2060:20."""
    number = AXES.index(axis)
    up = device.axis_int(number, ACCELERATION) / 1e6
    down = device.axis_real(number, LIMIT_OBJECT, ORDERED_STOP)
    travel = rate * rate * (0.5 / up + 0.5 / down) + rate * 3.0 * STEADY_S
    duration = 2 * repeats * (rate / up + rate / down + 3.0 * STEADY_S + 2.0)
    text = f"{repeats} times each forward and back, {degrees(rate):.3g} °/s, then stopped with the whole torque"
    return Plan(axis, text, rate, travel, travel, duration)


def _stop_once(device: Device, axis: int, rate: float) -> capture.Capture:
    names = capture.signal_names(device)
    signals = [capture.find_signal(names, f"{AXES[axis]}.{what}") for what in ("joint_rate_rad_s", "torque_nm", "current_a")]
    with LiveAxis(device, axis, power.PROFILE_VELOCITY) as live:
        live.keep(QUICK_STOP_DECELERATION, 4)
        live.keep(JERK, 4, 1)
        device.axis_write(axis, QUICK_STOP_DECELERATION, FASTEST, 4)
        device.axis_write(axis, JERK, FASTEST, 4, sub=1)
        live.drive.set_target_rate(rate)
        live.drive.wait(lambda: abs(live.drive.rate() - rate) < 0.05 * abs(rate), 20.0, "reach its rate")
        for _ in device.clock.every(0.05, STEADY_S):
            live.check_enabled()
        capture.set_up(device, signals, 1, round(1e3 * BEFORE_S), "state", 0, 0.0)
        device.clock.sleep(2.0 * BEFORE_S)
        live.drive.quick_stop()
        device.write_int(capture.SET_UP, capture.COMMAND, capture.STOP, 1)
        live.drive.set_target_rate(0.0)
        live.drive.enable()
    record = capture.parse_capture(device.upload_block(capture.DATA, 0, "scope data"), names)
    if not record.triggered:
        raise MotionError(f"{AXES[axis]} stopped, but its scope did not record the stop: repeat the measurement.")
    return record


def _signals(record: capture.Capture, axis: str) -> tuple[Real, Real, Real]:
    return record.time_s, record.traces[f"{axis}.joint_rate_rad_s"], record.traces[f"{axis}.torque_nm"]


def _show(session: Session, stops: list[Stop], sure: float, before: float, wind: float, written: bool) -> None:
    rows = [
        (f"{degrees(s.rate_rad_s):+.3g}", f"{s.deceleration_rad_s2:.3f} ± {2 * s.deviation_rad_s2:.3f}", f"{1e3 * s.full_torque_s:.0f}")
        for s in stops
    ]  # fmt: skip
    session.out.table([("from °/s", "right"), ("deceleration rad/s²", "right"), ("full torque ms", "right")], rows)
    session.out.say(
        f"sure deceleration: {sure:.3f} rad/s² ({100 * RESERVE:.0f} % of the weakest stop, less {wind:.3g} N m of wind)."
    )
    if written:
        session.out.say(f"2060:19 was {before:.4g}, is {sure:.4g} rad/s² now; 'servoctl store' keeps it.")
    elif sure < before:
        session.out.note(
            f"2060:19 is {before:.4g} rad/s²: protection relies on more than was measured. Write it with --write --unlock."
        )
    else:
        session.out.say(f"2060:19 is {before:.4g} rad/s²: the machine brakes at least as hard. Nothing was written.")
