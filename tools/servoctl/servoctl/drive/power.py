# SPDX-License-Identifier: Apache-2.0
"""The CiA 402 power state machine, as seen by a client: statusword masks, transitions, names of modes.

CiA 402-2 clauses 6.2, 8.4.1 and 8.4.2.
"""

from __future__ import annotations

STATE_MASKS: dict[str, tuple[int, int]] = {
    "not ready to switch on": (0x4F, 0x00),
    "switch on disabled": (0x4F, 0x40),
    "ready to switch on": (0x6F, 0x21),
    "switched on": (0x6F, 0x23),
    "operation enabled": (0x6F, 0x27),
    "quick stop active": (0x6F, 0x07),
    "fault reaction active": (0x4F, 0x0F),
    "fault": (0x4F, 0x08),
}
"""State by (mask, bits) of the statusword."""

ENABLED = "operation enabled"
DISABLED = "switch on disabled"
FAULT = "fault"

SHUTDOWN = 0x06
SWITCH_ON = 0x07
ENABLE_OPERATION = 0x0F
DISABLE_VOLTAGE = 0x00
QUICK_STOP = 0x02
FAULT_RESET = 0x80
NEW_SETPOINT = 0x10
CHANGE_IMMEDIATELY = 0x20
RELATIVE = 0x40
HALT = 0x100

TARGET_REACHED = 0x0400
SETPOINT_ACKNOWLEDGED = 0x1000
HOMING_ATTAINED = 0x1000
HOMING_ERROR = 0x2000
HOMING_BITS = TARGET_REACHED | HOMING_ATTAINED | HOMING_ERROR

NEXT_COMMAND: dict[str, int] = {
    "switch on disabled": SHUTDOWN,
    "ready to switch on": SWITCH_ON,
    "switched on": ENABLE_OPERATION,
    "quick stop active": DISABLE_VOLTAGE,
}
"""The controlword that leads one state further towards operation enabled."""

MODES: dict[int, str] = {-1: "tracking", 0: "none", 1: "pp", 3: "pv", 6: "homing", 8: "csp", 9: "csv", 10: "cst"}
"""Modes of operation (6060, 6061) by number."""

TRACKING = -1
NO_MODE = 0
"""Enabled in it, an axis holds its position, and follows experiments (0x2100)."""
PROFILE_POSITION = 1
PROFILE_VELOCITY = 3
HOMING = 6
CYCLIC_POSITION = 8
CYCLIC_VELOCITY = 9

STATUS_BITS: dict[int, str] = {
    0x0010: "voltage",
    0x0080: "warning",
    0x0200: "remote",
    0x0400: "target reached",
    0x0800: "limit",
}
"""Bits of the statusword that are independent of the power state."""


def state_of(statusword: int) -> str:
    """The power state in a statusword."""
    for state, (mask, bits) in STATE_MASKS.items():
        if statusword & mask == bits:
            return state
    return "unknown"


def mode_name(mode: int) -> str:
    """Short name of a mode of operation."""
    return MODES.get(mode, str(mode))


def status_flags(statusword: int) -> list[str]:
    """Names of the set bits besides those of the state."""
    return [name for bit, name in STATUS_BITS.items() if statusword & bit]
