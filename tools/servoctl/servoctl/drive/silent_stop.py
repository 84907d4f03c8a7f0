# SPDX-License-Identifier: Apache-2.0
"""An axis that stands because its master was silent for longer than 3041:1 (docs/can.md, "A silent master"): the node tells it
once with EMCY, then by the warning bit and the fault log only."""

from __future__ import annotations

from ..link.device import Device
from ..objects.fault_log import read_log
from ..objects.fault_table import NO_FAULTS, FaultTable
from ..objects.parameter import AXES
from .drive import Drive
from .power import ENABLED

FAULT, CODE = 39, 0x8101


def silent_stop_age_s(device: Device, axis: int) -> float | None:
    """Seconds since the stop; None: the axis was not stopped for this, or has been enabled since."""
    drive = Drive(device, axis)
    status = drive.statusword()
    if "warning" not in drive.flags(status) or drive.state(status) == ENABLED:
        return None
    log = read_log(device, NO_FAULTS)
    newest = next((entry for entry in log.entries if entry.of == AXES[axis]), None) if log else None
    return newest.age_s if newest and newest.fault == FAULT else None


def silent_stop_text(axis: str, age_s: float, faults: FaultTable) -> str:
    """Reason, time and remedy in one line."""
    cure = faults.faults[FAULT].cure if FAULT in faults.faults else "Let the master send frames to the node more often."
    return (
        f"{axis} was stopped {age_s:.1f} s ago: {faults.meaning(CODE)} (EMCY {CODE:04X}). {cure} Then enable the axis again."
        f" More: servoctl explain {CODE:04X}"
    )
