# SPDX-License-Identifier: Apache-2.0
"""home: finds the turn of an axis that started in an unknown one (mode 6)."""

from __future__ import annotations

import math
import time

import click

from ..drive import power
from ..drive.drive import Drive
from ..errors import InputError, MotionError, Refused
from ..link.device import Device
from ..motion.live import LiveAxis
from ..objects.access_lock import unlocked
from ..objects.parameter import AXES, AXIS_SHIFT
from ..objects.restrictions import ENVELOPE, possible_turns, turn_is_unknown
from ..session import Session, common, unlock_option
from ..units import POSITION_COUNTS_PER_RAD, RATE_COUNTS_PER_RAD_S, degrees
from .motion import confirm, yes_options
from .quantity import ANGLE

HOME_OFFSET, METHOD, SPEEDS, SUPPORTED_MODES = 0x607C, 0x6098, 0x6099, 0x6502
HOMING_BIT = 5
DOWN, UP, HERE = -1, -2, 37
TURN_SUB = 2
HARD_MINIMUM, HARD_MAXIMUM = 9, 10
REVOLUTION = 2.0 * math.pi
SLOW_RAD_S = math.radians(4.0)
"""The node is no faster while the turn is not known."""


@click.command(short_help="Find the turn of an axis that started in an unknown one.")
@yes_options
@click.argument("axis", type=click.Choice(AXES))
@click.option("--down", "method", flag_value=DOWN, type=int, help="Move down first; at an end stop the axis turns round.")
@click.option("--up", "method", flag_value=UP, type=int, help="Move up first; at an end stop the axis turns round.")
@click.option(
    "--seen", type=ANGLE, metavar="ANGLE", default=None,
    help="Move nothing: you see the axis near this joint angle (°, within 90°). Needs --unlock.",
)  # fmt: skip
@unlock_option
@common
def home(
    session: Session, axis: str, method: int | None, seen: float | None, unlock: bool, dry_run: bool, yes: bool
) -> None:  # fmt: skip
    """Find the turn of an axis whose encoder knows one turn only, if its start left several possible (2061).

    With --down or --up the axis moves at 2 °/s until motion has excluded the other turns. Begin in the direction in
    which you know that there is room: at an end stop, which it may touch, it turns round. With --seen nothing moves.
    """
    if (method is None) == (seen is None):
        raise InputError("give one of --down, --up, or --seen with an angle.")
    if unlock != (seen is not None):
        raise InputError("--seen needs --unlock, because a wrong turn leads to the end stop; --down and --up do not.")
    number = AXES.index(axis)
    with session.connect() as device:
        _check_supported(device, number)
        drive = Drive(device, number)
        if not turn_is_unknown(device, number):
            _report(session, device, drive, "is known already")
            return
        chosen = HERE if method is None else method
        session.out.say(_announcement(device, drive, chosen, seen))
        if not confirm(session, {"axis": axis, "method": chosen, "possible_deg": _possible(device, drive)}, dry_run, yes):
            return
        if seen is not None:
            with unlocked(device, True):
                _write_seen(device, drive, seen)
        _home(session, device, number, chosen)
        _report(session, device, drive, "is known now")


def _check_supported(device: Device, axis: int) -> None:
    if not device.axis_int(axis, SUPPORTED_MODES) >> HOMING_BIT & 1:
        raise InputError(
            f"node {device.node_id} has no homing (bit {HOMING_BIT} of 6502 is not set): update its firmware."
        )


def _possible(device: Device, drive: Drive) -> list[float]:
    """The joint angles at which the axis may be, °."""
    lowest, highest = possible_turns(device, drive.axis)
    in_force = device.read_int(ENVELOPE + AXIS_SHIFT * drive.axis, TURN_SUB, signed=True)
    here = drive.position()
    return [degrees(here + (turn - in_force) * REVOLUTION) for turn in range(lowest, highest + 1)]


def _announcement(device: Device, drive: Drive, method: int, seen: float | None) -> str:
    places = " or ".join(f"{angle:.1f}°" for angle in _possible(device, drive)) or "outside of its travel"
    where = f"{drive.name} may be at {places}"
    if seen is not None:
        return f"{where}; you see it near {degrees(seen):.1f}°. It is enabled and holds its position."
    direction = "down" if method == DOWN else "up"
    rate = degrees(min(device.axis_int(drive.axis, SPEEDS, 1) / RATE_COUNTS_PER_RAD_S, SLOW_RAD_S))
    return (
        f"{where}. It will move {direction} at {rate:.3g} °/s until its turn is known; at an end stop, which it may touch, it"
        " turns round."
    )


def _write_seen(device: Device, drive: Drive, seen: float) -> None:
    places = _possible(device, drive)
    try:
        device.axis_write(drive.axis, HOME_OFFSET, round(seen * POSITION_COUNTS_PER_RAD), 4)
    except Refused as error:
        near = " or ".join(f"{angle:.1f}°" for angle in places)
        raise Refused(
            f"{drive.name} cannot be near {degrees(seen):.1f}°: by its encoder and travel it is at {near}.", error.abort
        ) from error


def _longest_s(device: Device, axis: int) -> float:
    """Both paths through the whole travel."""
    low, high = (device.axis_real(axis, 0x2060, sub) for sub in (HARD_MINIMUM, HARD_MAXIMUM))
    rates = [min(device.axis_int(axis, SPEEDS, sub) / RATE_COUNTS_PER_RAD_S, SLOW_RAD_S) for sub in (1, 2)]
    return 10.0 + sum((high - low) / rate for rate in rates)


def _home(session: Session, device: Device, axis: int, method: int) -> None:
    longest_s = _longest_s(device, axis)
    with LiveAxis(device, axis, power.HOMING) as live, session.out.progress() as bar:
        drive = live.drive
        bar.add_task(f"{drive.name} homes", total=None)
        live.keep(METHOD, 1)
        device.axis_write(axis, METHOD, method, 1)
        drive.control(power.ENABLE_OPERATION)
        drive.control(power.ENABLE_OPERATION | power.NEW_SETPOINT)
        drive.wait(lambda: not (drive.statusword() & power.HOMING_BITS) == power.TARGET_REACHED, 1.0, "start the homing")
        deadline = device.clock.now() + longest_s
        done = power.HOMING_ATTAINED | power.TARGET_REACHED
        while (bits := live.check_enabled() & power.HOMING_BITS) != done:
            if bits & power.HOMING_ERROR:
                raise MotionError(
                    f"{drive.name} was not homed, and its turn is still unknown: it was blocked in both directions. Look"
                    " for what blocks it."
                )
            if device.clock.now() > deadline:
                raise MotionError(f"{drive.name} was not homed within {longest_s:.0f} s.")
            time.sleep(0.02)


def _report(session: Session, device: Device, drive: Drive, what: str) -> None:
    here = degrees(drive.position())
    turn = device.read_int(ENVELOPE + AXIS_SHIFT * drive.axis, TURN_SUB, signed=True)
    session.out.json({"axis": drive.name, "position_deg": here, "start_turn": turn, "state": what})
    session.out.say(f"the turn of {drive.name} {what}: it stands at {here:.3f}°.")
