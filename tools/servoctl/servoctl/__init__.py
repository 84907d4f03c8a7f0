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
    from .drive.drive import Drive
    from .errors import InputError, ServoctlError
    from .gains.loop_test import loop_stimulus, measure_loop
    from .gains.tuning import Tuning, undo_last
    from .identify.identification import Identification
    from .link.bus import parse_bus
    from .link.device import Device
    from .link.signal_stream import SignalStream
    from .motion.limits import Limits
    from .motion.live import LiveAxis
    from .motion.moves import plan_run
    from .motion.rate_run import send_rates
    from .motion.step_test import cut_steps, plan_step
    from .servo import Servo, connect
    from .show.recording import Recorder
    from .show.recording import read as read_recording
    from .sim_host import simulator
    from .units import degrees, radians

__version__ = (Path(__file__).parent / "descriptions" / "version.txt").read_text(encoding="ascii").strip()
"""That of the firmware whose build printed the descriptions: project(VERSION) of CMakeLists.txt."""

_PLACES = {
    "Axis": "axis", "Device": "link.device", "Drive": "drive.drive", "Identification": "identify.identification",
    "InputError": "errors", "Limits": "motion.limits", "LiveAxis": "motion.live", "Recorder": "show.recording",
    "Servo": "servo", "ServoctlError": "errors", "SignalStream": "link.signal_stream",
    "Tuning": "gains.tuning", "connect": "servo", "cut_steps": "motion.step_test", "degrees": "units", "loop_stimulus": "gains.loop_test",
    "measure_loop": "gains.loop_test", "parse_bus": "link.bus", "plan_run": "motion.moves", "plan_step": "motion.step_test", "radians": "units",
    "read_recording": "show.recording", "send_rates": "motion.rate_run", "simulator": "sim_host", "undo_last": "gains.tuning",
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
