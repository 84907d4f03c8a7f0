# SPDX-License-Identifier: Apache-2.0
"""One axis as a CiA 402 drive, commanded by SDO: power states, modes and targets.

Needs no PDO and disturbs no PDO mapping; a transition takes a few ms. All times are by the node's clock.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from ..errors import MotionError
from ..link.device import Device
from ..objects import restrictions
from ..objects.parameter import AXES, AXIS_SHIFT
from ..units import POSITION_COUNTS_PER_RAD, POSITION_RANGE_RAD, RATE_COUNTS_PER_RAD_S, TORQUE_COUNTS_OF_RATED
from . import power

TRANSITION_TIMEOUT_S = 2.0
STOP_TIMEOUT_S = 10.0
QUICK_STOP_ACTIVE = "quick stop active"
STANDSTILL_RAD_S = 5e-4
"""A rate below this for `STANDSTILL_S` is standstill: above the noise of the measured rate, far below any motion."""
STANDSTILL_S = 0.1
POLL_S = 0.005
POSITIONING_OPTION, SHORTER_WAY = 0x60F2, 0xC0
"""Of targets in pp without a limited travel."""


class Drive:
    """The objects 6040 to 60FF of one axis; angles in rad, rates in rad/s."""

    def __init__(self, device: Device, axis: int) -> None:
        self.device = device
        self.axis = axis
        self.name = AXES[axis]
        self._position_rad: float | None = None

    # --- state ----------------------------------------------------------------------------------------------------

    def statusword(self) -> int:
        """6041."""
        return self.device.axis_int(self.axis, 0x6041)

    def state(self, statusword: int | None = None) -> str:
        """The power state."""
        return power.state_of(self.statusword() if statusword is None else statusword)

    def flags(self, statusword: int) -> list[str]:
        """Other bits that are set."""
        return power.status_flags(statusword)

    def mode(self) -> str:
        """Name of the mode in effect."""
        return power.mode_name(self.device.axis_int(self.axis, 0x6061, signed=True))

    def mode_number(self) -> int:
        """6060, the requested mode."""
        return self.device.axis_int(self.axis, 0x6060, signed=True)

    def error_code(self) -> int:
        """603F."""
        return self.device.axis_int(self.axis, 0x603F)

    def rate(self) -> float:
        """Measured rate, rad/s."""
        return self.device.axis_int(self.axis, 0x606C, signed=True) / RATE_COUNTS_PER_RAD_S

    def position(self) -> float:
        """Measured joint angle, rad; goes on counting turns from the first reading, where 6064 wraps."""
        shown_rad = self.device.axis_int(self.axis, 0x6064, signed=True) / POSITION_COUNTS_PER_RAD
        before_rad = shown_rad if self._position_rad is None else self._position_rad
        self._position_rad = shown_rad + POSITION_RANGE_RAD * round((before_rad - shown_rad) / POSITION_RANGE_RAD)
        return self._position_rad

    def wraps(self) -> bool:
        """Whether 6064 and 607A wrap at the ends of 607B: no travel is limited."""
        end = self.device.try_upload(0x607B + AXIS_SHIFT * self.axis, 2)
        return end is not None and any(end)

    def position_limits(self) -> tuple[float, float] | None:
        """Software limits 607D in rad, or None when they are not monitored."""
        low = self.device.axis_int(self.axis, 0x607D, 1, signed=True) / POSITION_COUNTS_PER_RAD
        high = self.device.axis_int(self.axis, 0x607D, 2, signed=True) / POSITION_COUNTS_PER_RAD
        return (low, high) if low < high else None

    def rate_limit(self) -> float:
        """607F in rad/s."""
        return self.device.axis_int(self.axis, 0x607F) / RATE_COUNTS_PER_RAD_S

    def torque_limit(self) -> float:
        """The largest torque that the axis can give in both directions, N m: 2055 (motor), 6072, 60E0 and 60E1."""
        motor = self.device.axis_real(self.axis, 0x2055, 1) * self.device.axis_real(self.axis, 0x2055, 6)
        permille = min(self.device.axis_int(self.axis, index) for index in (0x6072, 0x60E0, 0x60E1))
        return min(motor, permille / TORQUE_COUNTS_OF_RATED * self.device.axis_int(self.axis, 0x6076) / 1e3)

    # --- commands -------------------------------------------------------------------------------------------------

    def control(self, controlword: int) -> None:
        """6040; raises MotionError instead of enabling after a stop from another thread."""
        if controlword & power.ENABLE_OPERATION == power.ENABLE_OPERATION and self.device.stopped.is_set():
            raise MotionError(f"{self.name} was stopped.")
        self.device.axis_write(self.axis, 0x6040, controlword, 2)

    def set_mode(self, mode: int) -> None:
        """6060, and waits until 6061 agrees."""
        self.device.axis_write(self.axis, 0x6060, mode, 1)
        self.wait(
            lambda: self.device.axis_int(self.axis, 0x6061, signed=True) == mode,
            1.0,
            f"change to mode {power.mode_name(mode)}",
        )

    def set_target_rate(self, rate_rad_s: float) -> None:
        """60FF."""
        self.device.axis_write(self.axis, 0x60FF, round(rate_rad_s * RATE_COUNTS_PER_RAD_S), 4)

    def set_target_position(self, position_rad: float) -> None:
        """607A."""
        if self.wraps():
            position_rad -= POSITION_RANGE_RAD * round(position_rad / POSITION_RANGE_RAD)
        self.device.axis_write(self.axis, 0x607A, round(position_rad * POSITION_COUNTS_PER_RAD), 4)

    def set_profile_rate(self, rate_rad_s: float) -> None:
        """6081."""
        self.device.axis_write(self.axis, 0x6081, round(rate_rad_s * RATE_COUNTS_PER_RAD_S), 4)

    def start_to(self, position_rad: float, rate_rad_s: float) -> None:
        """In mode pp: starts to an angle, at once; statusword bit 10 then reports the arrival."""
        self.set_profile_rate(rate_rad_s)
        self.set_target_position(position_rad)
        self.control(power.ENABLE_OPERATION)
        self.control(power.ENABLE_OPERATION | power.NEW_SETPOINT | power.CHANGE_IMMEDIATELY)
        self.wait(lambda: bool(self.statusword() & power.SETPOINT_ACKNOWLEDGED), 1.0, "accept the target")
        self.control(power.ENABLE_OPERATION)

    def enable(self) -> None:
        """To operation enabled, step by step; the node is made operational for it."""
        if self.device.nmt_state() != "operational":
            self.device.set_nmt("operational")
        clock = self.device.clock
        last, deadline = "", 0.0
        while (state := self.state()) != power.ENABLED:
            if state != last:
                last, deadline = state, clock.now() + TRANSITION_TIMEOUT_S
            if state in (power.FAULT, "fault reaction active"):
                raise MotionError(
                    f"{self.name} has a fault (603F = {self.error_code():04X}). 'servoctl faults' shows details;"
                    f" 'servoctl state {self.name} reset' resets it."
                )
            if clock.now() > deadline:
                reason = restrictions.reason(self.device, self.axis) or "is its power supply on?"
                raise MotionError(f"{self.name} stays in '{state}': {reason}")
            if state in power.NEXT_COMMAND:
                self.control(power.NEXT_COMMAND[state])
            time.sleep(POLL_S)

    def disable(self) -> None:
        """Stops on the ramp, then removes the torque."""
        if self.state() == power.ENABLED:
            self.control(power.SWITCH_ON)
            self._wait_for_states(("switched on", "ready to switch on", power.DISABLED, power.FAULT), STOP_TIMEOUT_S)
        if self.state() not in (power.FAULT, "fault reaction active", "not ready to switch on"):
            self.control(power.DISABLE_VOLTAGE)
            self._wait_for_states((power.DISABLED, power.FAULT), STOP_TIMEOUT_S)

    def quick_stop(self) -> None:
        """Brakes with 6085 and waits for standstill; 605A decides what follows."""
        state = self.state()
        if state in (power.ENABLED, "switched on", "ready to switch on"):
            self.control(power.QUICK_STOP)
            self._wait_for_states((power.DISABLED, power.FAULT, QUICK_STOP_ACTIVE), TRANSITION_TIMEOUT_S)
        if state in (power.ENABLED, "switched on", "ready to switch on", QUICK_STOP_ACTIVE):
            self.wait_for_standstill()

    def reset_fault(self) -> None:
        """A rising edge of bit 7, after the axis has completed the fault reaction; raises MotionError when the fault is
        still present after it."""
        if self.state() == "fault reaction active":  # no answer to it; a shorted motor brakes for 2 s
            self._wait_for_states((power.FAULT,), STOP_TIMEOUT_S)
        self.control(0)
        self.device.clock.sleep(0.01)
        self.control(power.FAULT_RESET)
        self.device.clock.sleep(0.05)
        self.control(0)
        self._wait_for_states(
            tuple(
                s
                for s in power.STATE_MASKS
                if s not in (power.FAULT, "fault reaction active", "not ready to switch on")
            ),
            TRANSITION_TIMEOUT_S,
        )

    def wait_for_standstill(self, timeout_s: float = STOP_TIMEOUT_S) -> None:
        """Until the rate has been near zero for `STANDSTILL_S`; raises MotionError."""
        deadline = self.device.clock.now() + timeout_s
        still_since: float | None = None
        while True:
            now = self.device.clock.now()
            if abs(self.rate()) > STANDSTILL_RAD_S:
                still_since = None
            elif still_since is None:
                still_since = now
            elif now - still_since >= STANDSTILL_S:
                return
            if now > deadline:
                raise MotionError(f"{self.name} still moves {timeout_s:g} s after the command to stop.")
            time.sleep(POLL_S)

    def wait(self, condition: Callable[[], bool], timeout_s: float, what: str) -> None:
        """Until a condition holds; raises MotionError "does not <what>"."""
        deadline = self.device.clock.now() + timeout_s
        while not condition():
            if self.device.clock.now() > deadline:
                raise MotionError(f"{self.name} did not {what} within {timeout_s:g} s; its state is '{self.state()}'.")
            time.sleep(POLL_S)

    def _wait_for_states(self, states: tuple[str, ...], timeout_s: float) -> None:
        self.wait(lambda: self.state() in states, timeout_s, f"reach '{states[0]}'")
