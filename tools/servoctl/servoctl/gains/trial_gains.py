# SPDX-License-Identifier: Apache-2.0
"""Temporary gains: unless they are kept, the old ones are restored, whatever happens."""

from __future__ import annotations

from collections.abc import Mapping
from types import TracebackType

from ..errors import NotVerified, ServoctlError
from ..link.device import Device
from ..link.interrupts import deaf
from ..objects.parameter import Parameter, Value
from .tuning import REVERT, Change, Tuning, command_set, set_state


class TrialGains:
    """Applied as a whole on entering a `with` block; `keep` them in it, or they are withdrawn at its end."""

    def __init__(
        self, device: Device, command: str, gains: Mapping[Parameter, Value], unlock: bool = False
    ) -> None:
        """`gains` are of one axis; `command` is the command's name for the journal; `unlock` as in Tuning.write."""
        self._unlock = unlock
        self._device = device
        self._command = command
        self._gains = gains
        self._old: dict[Parameter, Value] = {}
        self._undoes = ""
        self._kept = False
        self.changes: list[Change] = []

    def __enter__(self) -> TrialGains:
        tuning = Tuning(self._device, self._command)
        axes = {p.axis for p in self._gains if p.axis is not None}
        tuning.refuse_foreign_stage(axes)
        self._old = {parameter: self._device.read(parameter) for parameter in self._gains}
        self._undoes = tuning.transaction
        try:
            self.changes = tuning.write(self._gains, unlock=self._unlock)
        except BaseException:
            self._take_back()
            raise
        return self

    def keep(self) -> None:
        """They stay in effect."""
        self._kept = True

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._kept:
            self._take_back()

    def _take_back(self) -> None:
        """Discards our staged values, and writes the old values where the device has others."""
        try:
            with deaf():
                for axis in {p.axis for p in self._gains if p.axis is not None}:
                    state = set_state(self._device, axis)
                    if state is not None and state.staged_differs:
                        command_set(self._device, axis, REVERT)
                differing = {p: old for p, old in self._old.items() if self._device.read(p) != old}
                if differing:
                    Tuning(self._device, self._command, undoes=self._undoes).write(
                        differing, unlock=self._unlock
                    )
        except ServoctlError as failed:
            raise NotVerified(
                f"the old gains could not be restored, the new ones may be active: {failed} 'servoctl undo'"
                " restores the old ones."
            ) from failed
