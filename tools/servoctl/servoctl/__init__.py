# SPDX-License-Identifier: Apache-2.0
"""servoctl: tuning of a trackservo over CANopen, the same on the simulator and on the board.

The names of __all__ are what LIBRARY.md describes. Each is imported when it is first used, so that a command loads only what
it needs.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .axis import Axis
    from .bus import parse_bus
    from .device import Device
    from .drive import Drive
    from .errors import InputError, ServoctlError
    from .identification import Identification
    from .limits import Limits
    from .live import LiveAxis
    from .loop_test import loop_stimulus, measure_loop
    from .moves import plan_run
    from .rate_run import send_rates
    from .recording import Recorder
    from .recording import read as read_recording
    from .servo import Servo, connect
    from .signal_stream import SignalStream
    from .sim_host import simulator
    from .step_test import cut_steps, plan_step
    from .tuning import Tuning, undo_last
    from .units import degrees, radians

__version__ = (Path(__file__).parent / "descriptions" / "version.txt").read_text(encoding="ascii").strip()
"""That of the firmware whose build printed the descriptions: project(VERSION) of CMakeLists.txt."""

_PLACES = {
    "Axis": "axis", "Device": "device", "Drive": "drive", "Identification": "identification", "InputError": "errors", "Limits": "limits",
    "LiveAxis": "live", "Recorder": "recording", "Servo": "servo", "ServoctlError": "errors", "SignalStream": "signal_stream",
    "Tuning": "tuning", "connect": "servo", "cut_steps": "step_test", "degrees": "units", "loop_stimulus": "loop_test",
    "measure_loop": "loop_test", "parse_bus": "bus", "plan_run": "moves", "plan_step": "step_test", "radians": "units",
    "read_recording": "recording", "send_rates": "rate_run", "simulator": "sim_host", "undo_last": "tuning",
}  # fmt: skip
"""The module of each name."""
_OTHER_NAMES = {"read_recording": "read"}
"""Of those that have another one in their module."""

__all__ = [
    "Axis", "Device", "Drive", "Identification", "InputError", "Limits", "LiveAxis", "Recorder", "Servo", "ServoctlError",
    "SignalStream", "Tuning", "connect", "cut_steps", "degrees", "loop_stimulus", "measure_loop", "parse_bus", "plan_run",
    "plan_step", "radians", "read_recording", "send_rates", "simulator", "undo_last",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Of a name that is not imported yet."""
    if name not in _PLACES:
        raise AttributeError(f"module 'servoctl' has no attribute '{name}'")
    found = getattr(import_module(f".{_PLACES[name]}", __name__), _OTHER_NAMES.get(name, name))
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """For completion in a notebook."""
    return sorted({*globals(), *__all__})
